"""`tbi reproduce`: every number of the paper, ours beside it straight from the files."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from tbi_cli.report.catalogue import data_file
from tests.cli.commands import tbi


@pytest.fixture(scope="module")
def entries(campaign: Path) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = json.loads((campaign / "reproduce.json").read_text())
    return found


def ours(entries: list[dict[str, Any]], name: str) -> list[float]:
    return [entry["ours"] for entry in entries if entry["id"] == name]


def test_every_claim_has_ours_beside_it(entries: list[dict[str, Any]]) -> None:
    assert {entry["id"] for entry in entries} == set(data_file("claims.yaml"))
    assert [entry["id"] for entry in entries if entry["ours"] is None] == []
    for entry in entries:
        if isinstance(entry["paper"], float):
            # What is only rounding of the last bits is told as none.
            away = entry["ours"] - entry["paper"]
            assert entry["difference"] == (0.0 if abs(away) < 1e-12 * abs(entry["paper"]) else away)


def test_what_follows_from_formulas_agrees(entries: list[dict[str, Any]]) -> None:
    for entry in entries:
        if entry["trust"] == "exact":
            # Half a unit of the last of at least four digits; 299.745 is a misprint, 7e-5 away.
            assert entry["ours"] == pytest.approx(entry["paper"], rel=2e-4), entry["what"]


def test_the_beams_take_each_others_damping_ratios(entries: list[dict[str, Any]]) -> None:
    # What the paper prints for the right beam follows for the left one (two decimals).
    assert ours(entries, "zeta_left") == pytest.approx([0.47, 2.36, 4.72], abs=5e-3)


@pytest.mark.parametrize(
    ("name", "file", "path", "index"),
    [
        ("t_body_y", "constant-velocity", "time_of_peak/car_body_y", 0),
        ("body_y_acc", "constant-velocity", "peak/car_body_y_acceleration", 0),
        ("right_midspan", "constant-velocity", "peak/right_midspan", 0),
        ("left_midspan", "masses", "peak/left_midspan", 3),
        ("body_force_min", "contact-forces", "min/car_body_force", 0),
    ],
)
def test_numbers_are_those_of_the_files(
    campaign: Path, entries: list[dict[str, Any]], name: str, file: str, path: str, index: int
) -> None:
    with h5py.File(campaign / f"{file}.h5", locking=False) as opened:
        assert ours(entries, name) == [opened[path][index]]


def test_lists_follow_their_axis(campaign: Path, entries: list[dict[str, Any]]) -> None:
    with h5py.File(campaign / "sampling.h5", locking=False) as file:
        assert ours(entries, "rms_mid_50kmh") == file["rms/right_midspan"][0, :].tolist()
        assert ours(entries, "rms_body_300kmh") == file["rms/car_body_y"][1, :].tolist()
    with h5py.File(campaign / "masses.h5", locking=False) as file:
        assert ours(entries, "t_body_y_by_mass") == file["time_of_peak/car_body_y"][:].tolist()


def test_speeds_of_peaks_are_where_the_curves_peak(campaign: Path, entries: list[dict[str, Any]]) -> None:
    with h5py.File(campaign / "velocity.h5", locking=False) as file:
        speed, y = file["velocity"][:], file["peak/car_body_y"][:]
        pitch = file["peak/car_body_pitch"][:]
    assert ours(entries, "v_body_pitch") == [speed[np.argmax(pitch)]]
    inner = np.flatnonzero((y[1:-1] > y[:-2]) & (y[1:-1] > y[2:])) + 1
    found = ours(entries, "v_body_y")
    assert found == sorted(found) and len(found) == 2
    assert set(found) <= set(speed[inner])
    assert speed[np.argmax(y)] in found


def test_the_three_files_say_the_same(campaign: Path, entries: list[dict[str, Any]]) -> None:
    rows = list(csv.DictReader((campaign / "reproduce.csv").read_text().splitlines()))
    assert [row["id"] for row in rows] == [entry["id"] for entry in entries]
    text = (campaign / "reproduce.txt").read_text()
    for entry in entries:
        if entry["note"]:
            assert entry["note"] in text
        if isinstance(entry["ours"], float):
            assert f"{entry['ours']:.5g}" in text


def test_from_some_results_files_the_rest_has_no_data(campaign: Path, tmp_path: Path) -> None:
    ended = tbi("reproduce", str(campaign / "masses.h5"), "-o", "out", folder=tmp_path)
    assert ended.code == 0, ended.err
    found = {e["id"]: e["ours"] for e in json.loads((tmp_path / "out" / "reproduce.json").read_text())}
    assert found["right_midspan"] is not None and found["v_body_y"] is None
    assert "no data" in ended.out
    assert not list((tmp_path / "out").glob("*.h5"))


def test_other_trains_are_not_compared_with_the_paper(tmp_path: Path) -> None:
    assert tbi("run", "paper", "--set", "train=shinkansen-300", "--set", "contact.static_load=physical",
               "-q", "-o", "other.h5", folder=tmp_path).code == 0  # fmt: skip
    ended = tbi("reproduce", "other.h5", "-o", "out", folder=tmp_path)
    assert ended.code == 0, ended.err
    assert all(e["ours"] is None for e in json.loads((tmp_path / "out" / "reproduce.json").read_text()))


def test_it_goes_on_where_it_was(campaign: Path) -> None:
    before = {path.name: path.stat().st_mtime_ns for path in campaign.glob("*.h5")}
    ended = tbi("reproduce", "-o", str(campaign), "-q", folder=campaign.parent)
    assert ended.code == 0, ended.err
    assert {path.name: path.stat().st_mtime_ns for path in campaign.glob("*.h5")} == before
