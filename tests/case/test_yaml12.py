"""Scalars are read as YAML 1.2 has them, and every value knows its place."""

from __future__ import annotations

import math
from typing import Any

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from tbi_cli.case.emit import emit_yaml
from tbi_cli.case.messages import Source
from tbi_cli.case.yaml12 import Mapping, plain, read_yaml


def read(text: str) -> Any:
    node, problems = read_yaml(Source("case.yaml", text))
    assert problems == []
    return plain(node)


@pytest.mark.parametrize(
    ("written", "value"),
    [
        ("1.176e6", 1.176e6),
        ("1e5", 1e5),
        ("110.2e3", 110.2e3),
        ("1E5", 1e5),
        (".5", 0.5),
        ("5.", 5.0),
        ("-1.5e-3", -1.5e-3),
        ("12", 12),
        ("-12", -12),
        ("+12", 12),
        ("012", 12),
        ("0x1F", 31),
        ("0o17", 15),
        ("true", True),
        ("False", False),
        ("null", None),
        ("~", None),
        ("", None),
        ("on", "on"),
        ("off", "off"),
        ("yes", "yes"),
        ("no", "no"),
        ("y", "y"),
        ("1_000", "1_000"),
        ("1:30", "1:30"),
        ("2026-01-01", "2026-01-01"),
        ("1e5 N", "1e5 N"),
        ("'1e5'", "1e5"),
        ('"true"', "true"),
        ("0b11", "0b11"),
        ("1e", "1e"),
        ("e5", "e5"),
        (".", "."),
        ("+", "+"),
        ("=", "="),
    ],
)
def test_scalars_follow_yaml_1_2(written: str, value: object) -> None:
    found = read(f"key: {written}\n")["key"]
    assert found == value
    assert type(found) is type(value)


@pytest.mark.parametrize(
    ("written", "value"), [(".inf", math.inf), ("-.INF", -math.inf), ("1e999", math.inf)]
)
def test_infinities(written: str, value: float) -> None:
    assert read(f"key: {written}") == {"key": value}


def test_not_a_number() -> None:
    assert math.isnan(read("key: .nan")["key"])


def test_merge_keys_are_ordinary_keys() -> None:
    assert read("a: &a {b: 1}\nc: {<<: *a}") == {"a": {"b": 1}, "c": {"<<": {"b": 1}}}


def test_keys_are_always_strings() -> None:
    assert read("{1: a, true: b, null: c}") == {"1": "a", "true": "b", "null": "c"}


def test_keys_and_values_know_their_places() -> None:
    node, _ = read_yaml(Source("case.yaml", "a:\n  b: [1,\n      22]\n"))
    assert isinstance(node, Mapping)
    inner = node.entries["a"].value
    assert isinstance(inner, Mapping)
    entry = inner.entries["b"]
    assert (entry.line, entry.column, entry.width) == (2, 3, 1)
    last = entry.value.items[1]  # type: ignore[attr-defined]
    assert (last.line, last.column, last.width) == (3, 7, 2)


FLOATS = st.floats(allow_nan=False, allow_infinity=False)
WORDS = st.from_regex(r"[a-z_]{1,8}", fullmatch=True).filter(
    lambda word: word not in ("null", "true", "false")
)
TEXTS = st.text(st.characters(min_codepoint=32, max_codepoint=0x7E), max_size=20) | st.sampled_from(
    ["1e5", "on", "null", "~", "a: b", "# c", "é", "0x1F", ".5", "- x", "'", '"', "\\n", "2026-01-01"]
)
VALUES = st.recursive(
    FLOATS | st.integers(-(10**15), 10**15) | st.booleans() | st.none() | TEXTS,
    lambda inner: st.lists(inner, max_size=4),
    max_leaves=8,
)
TREES = st.recursive(
    st.dictionaries(WORDS, VALUES, min_size=1, max_size=4),
    lambda inner: st.dictionaries(WORDS, inner | VALUES, min_size=1, max_size=4),
    max_leaves=12,
)


@settings(deadline=None)
@given(TREES)
def test_what_is_written_is_read_back(tree: dict[str, Any]) -> None:
    assert read(emit_yaml(tree)) == tree


@settings(deadline=None)
@given(TREES)
def test_other_readers_of_yaml_read_the_same(tree: dict[str, Any]) -> None:
    """PyYAML follows YAML 1.1, where several words are booleans: as keys they are left out here."""
    if not any(word in emit_yaml(tree) for word in ("on", "off", "yes", "no", "y", "n")):
        assert yaml.safe_load(emit_yaml(tree)) == tree
