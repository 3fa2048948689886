"""The JSON Schema checks the files as they are written, as far as an editor can."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from jsonschema import Draft202012Validator

from tbi_cli.case import CaseError, load_case
from tbi_cli.case.builtin import configs_folder
from tbi_cli.case.fields import Quantity
from tbi_cli.case.keys import find_number, numeric_keys
from tbi_cli.case.messages import Source
from tbi_cli.case.schema import Kind, json_schema
from tbi_cli.case.train import TRAINS
from tbi_cli.case.unit_patterns import unit_pattern
from tbi_cli.case.units import to_si
from tbi_cli.case.yaml12 import plain, read_yaml

from .conftest import CASE

KINDS: tuple[Kind, ...] = ("case", "train", "bridge")
VALIDATORS = {kind: Draft202012Validator(json_schema(kind)) for kind in KINDS}
FILES = sorted(path for path in configs_folder().rglob("*.yaml") if path.parent.name != "templates")
FOLDERS: dict[str, Kind] = {"trains": "train", "bridges": "bridge"}


def faults(text: str, kind: Kind = "case") -> list[str]:
    value = plain(read_yaml(Source("file.yaml", text))[0])
    return [error.message for error in VALIDATORS[kind].iter_errors(value)]


@pytest.mark.parametrize("kind", KINDS)
def test_it_is_a_schema_of_the_draft(kind: Kind) -> None:
    schema = json_schema(kind)
    Draft202012Validator.check_schema(schema)
    assert schema["$schema"] == "https://json-schema.org/draft/2020-12/schema"


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.relative_to(configs_folder()).as_posix())
def test_every_built_in_file_passes(path: Path) -> None:
    assert faults(path.read_text(encoding="utf-8"), FOLDERS.get(path.parent.name, "case")) == []


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.relative_to(configs_folder()).as_posix())
def test_every_resolved_case_passes(path: Path) -> None:
    if path.parent.name not in FOLDERS:
        assert faults(load_case(path).to_yaml()) == []


NEWER = {
    "track: {approach: 100 m, irregularity: {dip: {at: 1, length: 2 m, depth: 5 mm}}}": "5 mm -> 5 kg",
    "track: {irregularity: {random: {spectrum: fra-6}}}": "fra-6 -> fra-7",
    "contact: {model: hertz, stiffness: 1.4e9}": "stiffness -> stifness",
    "output: {coaches: each}": "each -> every",
    "sweep: {velocity: {from: 1, to: 99, step: 2, refine: resonance, tolerance: 1 %}}": "1 % -> 1 kg",
    "sweep: {sample: {kind: sobol, count: 4, over: {velocity: {uniform: [1, 2]}}}}": "uniform -> unifrom",
    "studies: {a: {velocity: 20}, b: {sweep: {span: [30, 40]}}}": "velocity: 20 -> velcity: 20",
}


@pytest.mark.parametrize("text", NEWER)
def test_what_other_cases_have_is_checked_too(text: str, tmp_path: Path) -> None:
    """Each passes, and loads; and neither after one mistake."""
    old, new = NEWER[text].split(" -> ")
    for right, more in ((True, text), (False, text.replace(old, new, 1))):
        path = tmp_path / "case.yaml"
        path.write_text(f"train: paper\nbridge: paper\nvelocity: 300 km/h\n{more}\n")
        assert (faults(path.read_text()) == []) == right
        if right:
            load_case(path)
        else:
            with pytest.raises(CaseError):
                load_case(path)


GOOD_SWEEPS = [
    "velocity: [10, 36 km/h]",
    "velocity: {from: 2 m/s, to: 200, step: 0.5}",
    "span: {log: {from: 30 m, to: 60 m, count: 4}}",
    "damping: [1 %, 2 %]",
    "damping: [1 kN*s/m^2]",
    "modes: {from: 1, to: 8, step: 1}",
    "solver.substeps: [1, 2]",
    "train.front_bogie.primary.vertical.damping: [0, 1e3]",
    "{velocity: [1, 2], span: [30, 40], zip: [velocity, span]}",
    "sample: {kind: sobol, count: 4, over: {velocity: {normal: [80, 5], within: [70, 90]}}}",
]


@pytest.mark.parametrize("sweep", GOOD_SWEEPS)
def test_sweeps_pass(sweep: str) -> None:
    assert faults(f"{CASE}sweep: {sweep if sweep.startswith('{') else '{' + sweep + '}'}\n") == []


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("207 GPa", "207 GPx"),
        ("207 GPa", "207 kN"),
        ("207 GPa", "-207 GPa"),
        ("207 GPa", "0 GPa"),
        ("207 GPa", "GPa"),
        ("207 GPa", "true"),
        ("207 GPa", "-1"),
        ("207 GPa", "1e30"),
        ("207 GPa", ""),
        ("20 t/m", "20 t"),
        ("youngs_modulus: 207", "young_modulus: 207"),
        ("modes: 4", "modes: 2.5"),
        ("modes: 4", "modes: 0"),
        ("modes: 4", "modes: four"),
        ("length: 50 m", "length: 0"),
        ("    damping: 10 kN*s/m^2\n", "    damping: 2 %\n"),
        ("    damping: 10 kN*s/m^2\n", "    damping: {ratio: 1 %, first_mode_ratio: 1 %}\n"),
        ("    damping: 10 kN*s/m^2\n", "    damping: {}\n"),
        ("    damping: 10 kN*s/m^2\n", ""),
        ("velocity: 300 km/h", "velocty: 300 km/h"),
        ("velocity: 300 km/h", ""),
        ("velocity: 300 km/h", "velocity: 0"),
        ("velocity: 300 km/h", "velocity: [1]"),
        ("train: paper", "train: 5"),
        ("train: paper", "train: {model: maglev}"),
        ("train: paper", "train: {model: sprung-mass, mass: 5, stiffness: 1e6, damping: 0}"),
        ("train: paper", "train: {model: moving-load, forces: []}"),
        ("train: paper", "train: paper\ncontact: {model: rigid}"),
        ("train: paper", "train: paper\ncontact: {convective: on}"),
        ("train: paper", "train: paper\nsolver: {sampling: often}"),
        ("train: paper", "train: paper\nsolver: {substeps: 0}"),
        ("train: paper", "train: paper\noutput: {histories: some}"),
        ("train: paper", "train: paper\noutput: {histories: {channels: []}}"),
        ("train: paper", "train: paper\nsweep: {velocity: []}"),
        ("train: paper", "train: paper\nsweep: {velocity: 5}"),
        ("train: paper", "train: paper\nsweep: {velocity: {from: 1, to: 2}}"),
        ("train: paper", "train: paper\nsweep: {velocity: [-1]}"),
        ("train: paper", "train: paper\nsweep: {velocity: [5 kg]}"),
        ("train: paper", "train: paper\nsweep: {spam: [1]}"),
        ("train: paper", "train: paper\nsweep: {zip: velocity}"),
        (
            "train: paper",
            "train: paper\nsweep: {sample: {kind: grid, count: 4, over: {velocity: {uniform: [1, 2]}}}}",
        ),
        ("train: paper", "train: paper\ntitle: 2024"),
    ],
)
def test_broken_files_fail_in_the_schema_and_in_the_reader(tmp_path: Path, old: str, new: str) -> None:
    assert CASE.count(old) == 1
    text = CASE.replace(old, new)
    assert faults(text) != []
    (tmp_path / "case.yaml").write_text(text)
    with pytest.raises(CaseError):
        load_case(tmp_path / "case.yaml")


def quantities() -> Iterator[tuple[str, Quantity]]:
    for model in TRAINS:
        for key in numeric_keys(model):
            leaf, _ = find_number(key, {}, model)
            if isinstance(leaf, Quantity):
                yield key, leaf


PATTERNS = {unit_pattern(leaf): leaf for _, leaf in quantities()}


@settings(deadline=None)
@given(
    st.sampled_from(sorted(PATTERNS)).flatmap(
        lambda p: st.tuples(st.just(p), st.from_regex(p, fullmatch=True))
    )
)
def test_whatever_unit_the_schema_takes_the_reader_takes(drawn: tuple[str, str]) -> None:
    pattern, text = drawn
    # The reader takes numbers of at most 60 characters.
    assume(len(text) < 60)
    assert isinstance(to_si(text, PATTERNS[pattern].dimension.unit), float)


@pytest.mark.parametrize("kind", KINDS)
def test_every_key_is_described(kind: Kind) -> None:
    schema = json_schema(kind)
    for where, key, value in described(schema):
        known = schema["$defs"][value["$ref"].rpartition("/")[2]] if "$ref" in value else {}
        assert value.get("description") or known.get("description"), f"{where}/{key}"


def described(node: Any, where: str = "") -> Iterator[tuple[str, str, Any]]:
    """Every key that a file may have, wherever it may have it; conditions are no keys."""
    if isinstance(node, list):
        node = dict(enumerate(node))
    for word, inner in node.items() if isinstance(node, dict) else ():
        if word == "properties":
            yield from ((where, key, value) for key, value in inner.items() if value is not False)
        if word not in ("if", "then"):
            yield from described(inner, f"{where}/{word}")


def test_every_quantity_has_a_unit_and_examples_in_the_schema() -> None:
    beam: dict[str, Any] = json_schema("bridge")["$defs"]["Beam"]["properties"]
    assert beam["youngs_modulus"]["description"] == "Young's modulus E [Pa]"
    assert beam["youngs_modulus"]["examples"] == ["207 GPa", 207e9]
