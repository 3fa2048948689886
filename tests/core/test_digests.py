"""The bits of small built-in cases are those pinned; scripts/pins.py says how they are changed."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from tbi_cli.integrator.kernels import KERNELS
from tests.core.compilations import of_the_oldest_processor

ROOT = Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "scripts"))

import pins  # noqa: E402

OTHERWISE = (
    "other bits than pinned: `python scripts/digests.py COMMIT` says in which tables; if they are meant, "
    '`python scripts/pins.py --pin "REASON"` pins them'
)

# The least of them that need every kernel: a processor without multiply-adds of its own takes its time.
FOR_TWO_COMPILATIONS = ("paper/verification-1", "paper/verification-2-moving-load", "practice/axle-forces")


def test_bits_of_built_in_cases(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Every table of every case, where this kind of arithmetic is pinned.

    On another kind kernels are compiled once more, for the oldest processor of the family: the same bits.
    """
    known = pins.pinned()["kinds"].get(pins.kind())
    cases = FOR_TWO_COMPILATIONS if known is None else pins.CASES
    found = {case: pins.solved(case, tmp_path) for case in cases}
    if known is not None:
        assert not pins.differences(found, known["cases"]), OTHERWISE
        return
    of_the_oldest_processor(monkeypatch, KERNELS)
    assert not pins.differences(found, {case: pins.solved(case, tmp_path) for case in cases})


def test_all_kinds_have_the_same_cases_and_groups() -> None:
    """None is left from before: of a case that is no more, or with a group fewer than others."""
    kinds = pins.pinned()["kinds"]
    groups = {case: set(found) for case, found in next(iter(kinds.values()))["cases"].items()}
    assert groups.keys() == pins.CASES.keys()
    for one in kinds.values():
        assert {case: set(found) for case, found in one["cases"].items()} == groups
