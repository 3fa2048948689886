"""Peaks of a refined velocity beside fine sweeps, resonance speeds of any train, a tolerance not reached."""

from __future__ import annotations

import json
from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray

from tbi_cli.case import load_case
from tbi_cli.runner import Options, run
from tbi_cli.shards import Shard
from tbi_cli.store import merge, open_results
from tbi_cli.system.resonance import waves
from tests.cluster.runs import content, inside
from tests.studies.test_campaigns import StopAfter

CHANNELS = ("right_midspan", "right_midspan_acceleration")


def written(train: str, span: float, moment: float, mass: float, damping: str, sweep: str) -> str:
    beam = f"youngs_modulus: 35 GPa, second_moment: {moment!r}, mass_per_length: {mass}"
    return f"""\
train: {train}
bridge:
  length: {span}
  modes: 3
  low_pass: 30 Hz
  right: {{{beam}, damping: {{ratio: {damping}}}}}
solver: {{method: exact, duration: 1.1}}
sweep:
  velocity: {sweep}
output: {{file: results.h5}}
"""


def forces(count: int, apart: float) -> str:
    positions = [round(apart * k, 6) for k in range(count)]
    return f"{{model: axle-forces, forces: {[170e3] * count}, positions: {positions}}}"


def moment(frequency: float, span: float, mass: float) -> float:
    """The second moment of area (m4) with which the first frequency (Hz) comes out: Eq. (14) turned round."""
    return float((2 * np.pi * frequency) ** 2 * mass * (span / np.pi) ** 4 / 35e9)


def solved(folder: Path, case: str, *overrides: str) -> xarray.Dataset:
    (folder / "case.yaml").write_text(case)
    path = folder / "solved.h5"
    run(load_case(folder / "case.yaml", overrides=overrides), Options(path, overwrite=True))
    with xarray.open_dataset(path, group="peak", engine="h5netcdf") as data:
        return data.load()


REFINED = "{from: %s, to: %s, step: %s, refine: resonance}"
SIXTEEN = written(forces(16, 13.14), 15, 0.9, 13e3, "1 %", REFINED % (40, 120, 4))
THIRTY = written(forces(30, 17), 12, moment(9, 12, 15e3), 15e3, "0.1 %", REFINED % (40, 100, 5))
NINTH = "{model: hslm-a, number: 9}"
A9 = written(NINTH, 20, moment(5, 20, 15e3), 15e3, "0.2 %", REFINED % (40, 120, 10))


@pytest.mark.parametrize(
    ("case", "low", "high", "finest"),
    [
        (SIXTEEN, 68, 76, 0.02),
        (THIRTY, 50, 52, 0.01),
        (THIRTY.replace("step: 5", "step: 30"), 50, 52, 0.01),
        (A9, 42, 45.5, 0.02),
    ],
    ids=["16 forces", "30 forces", "30 forces by long steps", "HSLM-A9 near f1 D/3"],
)
def test_a_narrow_peak_is_settled(case: str, low: float, high: float, finest: float, tmp_path: Path) -> None:
    """The top of a fine sweep is met to the tolerance, 1 %; such peaks were 2 to 9 % low."""
    channels = (*CHANNELS, "right_midspan_acceleration_low_pass")
    wanted = f"resonance, channels: [{', '.join(channels)}]}}"
    found = solved(tmp_path, case.replace("resonance}", wanted))
    assert 30 < found["velocity"].size < 800
    fine = solved(tmp_path, case, f"sweep={{velocity: {{from: {low}, to: {high}, step: {finest}}}}}")
    for name in channels:
        line = fine[name].values
        assert 0 < int(np.argmax(line)) < len(line) - 1
        there = found.sel(velocity=slice(low, high))[name].values
        # The fine sweep itself may miss a little of what the refined one has found.
        assert 0.99 * line.max() <= there.max() <= 1.003 * line.max(), name


def test_the_waves_of_any_train() -> None:
    """Random trains of unequal forces: every strong local maximum of a dense sum is told, and no other."""
    rng = np.random.default_rng(5)
    for count in (3, 17, 60):
        positions = np.concatenate([[0.0], np.cumsum(rng.uniform(1.5, 12.0, count - 1))])
        loads = rng.uniform(50e3, 200e3, count)
        told = waves(positions, loads, 2.0, 30.0)
        numbers = np.linspace(1 / 30, 1 / 2, 100_001)
        total = np.zeros((2, len(numbers)))
        for x, load in zip(positions, loads, strict=True):
            total += load * np.array([np.cos(2 * np.pi * x * numbers), np.sin(2 * np.pi * x * numbers)])
        share = np.hypot(*total) / loads.sum()
        tops = np.flatnonzero((share[1:-1] > share[:-2]) & (share[1:-1] > share[2:])) + 1
        tops = tops[(share[tops] > 0.15) & (numbers[tops] > 0.51 / positions[-1])]
        assert len(tops) >= 3
        # The numbers of waves in a metre to the distance of those in the dense sum.
        assert [1 / wave.length for wave in told] == pytest.approx(numbers[tops], abs=5e-6)
        assert [wave.share for wave in told] == pytest.approx(share[tops], rel=1e-4)


def test_equal_forces_are_in_step_at_whole_parts_of_their_distance() -> None:
    told = waves(13.14 * np.arange(16.0), np.full(16, 170e3), 13.14 / 4.5, 20.0)
    lengths = [wave.length for wave in told if wave.share > 0.9]
    assert lengths == pytest.approx([13.14 / i for i in (1, 2, 3, 4)], rel=1e-9)
    assert waves(np.zeros(1), np.ones(1), 1.0, 20.0) == []


def test_lists_of_forces_have_speeds_of_resonance(tmp_path: Path) -> None:
    """With a tolerance that everything keeps, the steps are solved and each resonance of mode 1, f1 D/i."""
    found = solved(tmp_path, THIRTY.replace("resonance}", "resonance, tolerance: 100 %}"))
    speeds = found["velocity"].values
    for i in (2, 3):
        speed = 9 * 17 / i
        # An eighth of the half of a lobe of the spectrum, lambda/length, beside it at most.
        near = speed / (2 * 29 * i) / 8
        assert np.abs(speeds - speed).min() <= near * 1.0001
        assert speeds[np.abs(speeds - speed) <= 8 * near * 1.2].size >= 3


# A tolerance that the finest speeds cannot reach; two lines, of which one is settled more easily.
CLOSE = written(
    forces(30, 17), 12, moment(9, 12, 15e3), 15e3, "0.1 %",
    "{from: 45, to: 55, step: 5, refine: resonance, tolerance: 0.0001 %}\n  damping: [0.1 %, 5 %]",
)  # fmt: skip


def test_where_the_tolerance_is_not_reached_is_told(tmp_path: Path) -> None:
    """A line at the end of the run, a variable of the file, a table of the export."""
    (tmp_path / "case.yaml").write_text(CLOSE)
    ended = inside("run", "case.yaml", "-q", folder=tmp_path)
    assert (ended.code, ended.out) == (0, "")
    last = ended.err.splitlines()[-1]
    assert last.startswith("the tolerance of the refined sweep was not reached at ")
    with xarray.open_dataset(tmp_path / "results.h5", engine="h5netcdf") as data:
        converged, status = data["converged"].load(), data["status"].load()
    assert converged.dims == ("velocity", "damping") and converged.dtype == np.int8
    assert (status == 1).all() and set(np.unique(converged)) == {0, 1}
    # Where it was not reached there is a local maximum of a channel that decides.
    with xarray.open_dataset(tmp_path / "results.h5", group="peak", engine="h5netcdf") as data:
        values = np.array([data[name].values for name in CHANNELS])
    places = np.argwhere(converged.values == 0)
    for place, line in places:
        before, here, behind = (values[:, place + by, line] for by in (-1, 0, 1))
        assert ((here >= before) & (here >= behind)).any()
    assert f"all but {len(places)} of those done" in inside("info", "results.h5", folder=tmp_path).out
    assert inside("export", "results.h5", "-o", "tables", folder=tmp_path).code == 0
    rows = (tmp_path / "tables" / "converged.csv").read_text().splitlines()
    assert rows[0].endswith(",converged") and sum(row.endswith(",0") for row in rows) == len(places)


def test_converged_is_the_same_whatever_the_way(tmp_path: Path) -> None:
    """From shards, and stopped and resumed; an unfinished run has it too."""
    (tmp_path / "case.yaml").write_text(CLOSE)
    case = load_case(tmp_path / "case.yaml")
    whole = content(run(case, Options(tmp_path / "whole.h5")).path)
    assert 0 in np.frombuffer(whole["converged"], dtype=np.int8)
    paths = [tmp_path / f"{number}.h5" for number in (1, 2)]
    for number, path in enumerate(paths, 1):
        run(case, Options(path, shard=Shard(number, 2)))
    merge(paths, tmp_path / "joined.h5")
    assert content(tmp_path / "joined.h5") == whole
    stop = StopAfter(6)
    assert run(case, Options(tmp_path / "stopped.h5"), progress=stop, stop=stop.event).left > 0
    with open_results(tmp_path / "stopped.h5") as results:
        assert results.converged is not None and results.converged.shape == results.shape
        assert not results.converged[results.status == 0].any()
    run(case, Options(tmp_path / "stopped.h5", resume=True))
    assert content(tmp_path / "stopped.h5") == whole


def test_a_peak_that_leads_out_of_a_step_belongs_to_every_shard(tmp_path: Path) -> None:
    """A case in which what one step asks for lies in the next, and a shard's border between them."""
    seventh = "{model: hslm-a, number: 7}"
    text = written(seventh, 33.5623, 6.6111665, 11048, "0.308919 %", REFINED % (30, 110, 4))
    (tmp_path / "case.yaml").write_text(
        text.replace("modes: 3", "modes: 1").replace("  low_pass: 30 Hz\n", "")
    )
    case = load_case(tmp_path / "case.yaml")
    whole = content(run(case, Options(tmp_path / "whole.h5")).path)
    paths = [tmp_path / f"{number}.h5" for number in range(1, 9)]
    for number, path in enumerate(paths, 1):
        run(case, Options(path, shard=Shard(number, 8)))
    merge(paths, tmp_path / "joined.h5")
    assert content(tmp_path / "joined.h5") == whole


def test_a_settled_sweep_says_nothing(tmp_path: Path) -> None:
    (tmp_path / "case.yaml").write_text(SIXTEEN)
    ended = inside("run", "case.yaml", "-q", folder=tmp_path)
    assert (ended.code, ended.out, ended.err) == (0, "", "")
    with h5py.File(tmp_path / "results.h5") as file:
        assert (file["converged"][()] == 1).all()
    axis = "sweep.velocity={from: 40, to: 48, step: 4}"
    assert inside("run", "case.yaml", "-q", "--overwrite", "--set", axis, folder=tmp_path).code == 0
    with h5py.File(tmp_path / "results.h5") as file:
        assert "converged" not in file


def test_the_end_of_the_axis_is_solved(tmp_path: Path) -> None:
    """Refined also where it ends a shorter step; unrefined it is left out: a warning names what is last."""
    axis = "sweep.velocity={from: 66, to: 77.3, step: 4"
    speeds = solved(tmp_path, SIXTEEN, axis + ", refine: resonance}")["velocity"].values
    assert {66.0, 70.0, 74.0, 77.3} <= set(speeds.tolist()) and speeds[-1] == 77.3
    warning = "sweep.velocity.to: 77.3 m/s is not on a step; the last value is 74 m/s\n"
    for strict, code in (((), 0), (("--strict",), 2)):
        ended = inside("run", "case.yaml", "-q", "--overwrite", *strict, "--set", axis + "}", folder=tmp_path)
        assert ended.code == code and warning in ended.err
    assert (
        inside("validate", "case.yaml", "--set", axis.replace("77.3", "78") + "}", folder=tmp_path).err == ""
    )


def test_steps_of_a_refined_axis_are_the_decimals(tmp_path: Path) -> None:
    found = solved(tmp_path, SIXTEEN, "sweep.velocity={from: 70.1, to: 71.3, step: 0.1, refine: resonance}")
    assert {float(f"{k / 10:.1f}") for k in range(701, 714)} <= set(found["velocity"].values.tolist())


def test_the_notes_of_an_unfinished_run_may_be_damaged(tmp_path: Path) -> None:
    (tmp_path / "case.yaml").write_text(SIXTEEN)
    stop, path = StopAfter(1), tmp_path / "results.h5"
    run(load_case(tmp_path / "case.yaml"), Options(path), progress=stop, stop=stop.event)
    note = tmp_path / "results.h5.parts" / "unsettled.json"
    kept = {"run_id": json.loads((note.parent / "layout.json").read_text())["run_id"]}
    for bad in ("{", json.dumps({**kept, "cases": [10**9]}), json.dumps({**kept, "cases": "x"})):
        note.write_text(bad)
        ended = inside("info", "results.h5", folder=tmp_path)
        assert ended.code == 2 and "unsettled.json" in ended.err and len(ended.err.splitlines()) == 1
