"""A velocity that refines itself: the same speeds and bits however it is run, and every peak settled."""

from __future__ import annotations

import re
import signal
import threading
import time
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
import xarray
from numpy.typing import NDArray

from tbi_cli.case import Case, load_case
from tbi_cli.runner import Options, Silence, run
from tbi_cli.shards import Shard
from tbi_cli.store import merge
from tbi_cli.system.resonance import resonant_speeds
from tbi_cli.workers import Workers
from tests.cluster.runs import content, inside, parts, start

# HSLM-A4 repeats itself after 21 m; the span's first frequency is 4.8 Hz: resonance at 101, 50 and 34 m/s.
CASE = """\
title: Refined
train: {model: hslm-a, number: 4}
bridge:
  length: 25 m
  modes: 2
  right: {youngs_modulus: 35 GPa, second_moment: 1.563, mass_per_length: 15 t/m, damping: {ratio: 2 %}}
solver: {method: exact, duration: 1.1, sampling: 4 ms}
sweep:
  velocity: {from: 40, to: 120, step: 4, refine: resonance, tolerance: 1 %}
output: {file: results.h5}
"""
# Two spans and, behind the velocity, two damping ratios: four lines, of which each speed is solved for all.
GRID = CASE.replace("  velocity:", "  bridge.length: [24, 26]\n  velocity:").replace(
    "output:", "  damping: [2 %, 3 %]\noutput:"
)
SLOW = ("--set", "solver.sampling=0.00002")
STEP, PER_STEP = 4.0, 32


def read(folder: Path, text: str = CASE, *overrides: str) -> Case:
    (folder / "case.yaml").write_text(text)
    return load_case(folder / "case.yaml", overrides=overrides)


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with results.h5, run in one go."""
    folder = tmp_path_factory.mktemp("refined")
    run(read(folder), Options(output=folder / "results.h5"))
    return folder


@pytest.fixture(scope="module")
def whole(made: Path) -> Mapping[str, bytes]:
    return content(made / "results.h5")


@pytest.fixture(scope="module")
def fine(made: Path, tmp_path_factory: pytest.TempPathFactory) -> xarray.Dataset:
    """The peaks at all speeds that there may be."""
    folder = tmp_path_factory.mktemp("fine")
    step = STEP / PER_STEP
    axis = f"sweep={{velocity: {{from: 40, to: 120, step: {step}}}}}"
    return peaks(run(read(folder, CASE, axis), Options(output=folder / "fine.h5")).path)


def peaks(path: Path) -> xarray.Dataset:
    with xarray.open_dataset(path, group="peak", engine="h5netcdf") as data:
        return data.load()


def test_the_file_is_that_of_a_plain_sweep(made: Path, tmp_path: Path) -> None:
    """Only speeds that were solved, rising; those of the steps among them; the numbers of a plain sweep."""
    found = peaks(made / "results.h5")
    speeds = found["velocity"].values
    assert (np.diff(speeds) > 0).all()
    assert set(np.arange(40.0, 121.0, STEP)) <= set(speeds)
    assert 30 < len(speeds) < 641 / 2
    listed = f"sweep={{velocity: {speeds.tolist()}}}"
    plain = peaks(run(read(tmp_path, CASE, listed), Options(output=tmp_path / "plain.h5")).path)
    assert np.array_equal(plain["velocity"].values, speeds)
    for name in ("right_midspan", "right_midspan_acceleration"):
        assert found[name].values.tobytes() == plain[name].values.tobytes()
        assert not np.isnan(found[name].values).any()


def test_every_peak_is_found_and_settled(made: Path, fine: xarray.Dataset) -> None:
    """Each maximum of the fine sweep has a solved speed beside it that lacks no more than the tolerance."""
    found, tried = peaks(made / "results.h5"), 0
    speeds, all_speeds = found["velocity"].values, fine["velocity"].values
    for name in ("right_midspan", "right_midspan_acceleration"):
        line = fine[name].values
        top = np.flatnonzero((line[1:-1] > line[:-2]) & (line[1:-1] > line[2:])) + 1
        for place in top:
            near = np.abs(speeds - all_speeds[place]) <= STEP / 2
            # Of the largest value of the steps around: so far a peak may be off.
            around = line[np.abs(all_speeds - all_speeds[place]) <= STEP].max()
            assert line[place] - found[name].values[near].max() <= 0.01 * around, (name, all_speeds[place])
            tried += 1
        assert found[name].values.max() >= 0.99 * line.max()
    assert tried > 10


def test_between_its_speeds_a_line_may_be_drawn(made: Path, fine: xarray.Dataset) -> None:
    """Between neighbours the line is off by about the tolerance of what is largest around, in dips by five.

    Half of an interval was tested by the middle of it, so the tolerance is passed by little.
    """
    found = peaks(made / "results.h5")
    for name in ("right_midspan", "right_midspan_acceleration"):
        line, speeds = fine[name].values, fine["velocity"].values
        drawn = np.interp(speeds, found["velocity"].values, found[name].values)
        around = np.array([line[np.abs(speeds - v) <= STEP].max() for v in speeds])
        off = (line - drawn) / around
        assert off.max() < 0.02 and off.min() > -0.06, name


def test_resonance_is_where_it_is_expected(made: Path) -> None:
    """v = f_j D/i of mode j: the report's marks; and the largest peak stands at f1 D."""
    case = load_case(made / "case.yaml")
    f1 = np.pi / (2 * 25.0**2) * np.sqrt(35e9 * 1.563 / 15e3)
    expected = {(j, i): j * j * f1 * 21.0 / i for j in (1, 2) for i in range(1, 7)}
    told = {(j, i): v for _, j, i, v in resonant_speeds(case)}
    assert told.keys() == expected.keys()
    for key, speed in told.items():
        assert speed == pytest.approx(expected[key])
    found = peaks(made / "results.h5")
    speeds = found["velocity"].values
    assert speeds[int(np.argmax(found["right_midspan"].values))] == pytest.approx(f1 * 21.0, rel=0.01)


def test_tolerance_and_channels_decide(tmp_path: Path) -> None:
    """The closer, the more speeds; looking at one channel alone takes fewer than at both."""
    counts = {}
    for tolerance in ("0.3 %", "1 %", "10 %"):
        for channels in ("", ", channels: [right_midspan]"):
            text = CASE.replace("tolerance: 1 %", f"tolerance: {tolerance}{channels}")
            summary = run(read(tmp_path, text), Options(output=tmp_path / "r.h5", overwrite=True))
            counts[tolerance, bool(channels)] = summary.solved
    assert counts["0.3 %", False] > counts["1 %", False] > counts["10 %", False]
    for tolerance in ("0.3 %", "1 %"):
        assert counts[tolerance, True] < counts[tolerance, False]


@pytest.mark.parametrize("jobs", [1, 2])
def test_the_same_whatever_the_jobs(whole: Mapping[str, bytes], tmp_path: Path, jobs: int) -> None:
    path = run(read(tmp_path), Options(output=tmp_path / "r.h5", workers=Workers(jobs=jobs))).path
    assert content(path) == whole


@pytest.mark.parametrize(("text", "of"), [(CASE, 1), (CASE, 2), (CASE, 3), (CASE, 7), (GRID, 3)])
def test_shards_joined_are_the_whole(text: str, tmp_path: Path, of: int) -> None:
    """The same speeds and bits; a shard keeps the speeds that are its own."""
    case = read(tmp_path, text)
    whole = content(run(case, Options(output=tmp_path / "whole.h5")).path)
    paths = [tmp_path / f"{number}.h5" for number in range(1, of + 1)]
    for number, path in enumerate(paths, 1):
        run(case, Options(output=path, shard=Shard(number, of)))
        assert not np.isnan(peaks(path)["right_midspan"].values).any()
    merge(paths, tmp_path / "joined.h5")
    assert content(tmp_path / "joined.h5") == whole


class _Stopping(Silence):
    """Sets an event once so many batches are on disk."""

    def __init__(self, batches: int) -> None:
        self.left, self.event = batches, threading.Event()

    def advance(self, scenarios: int, steps: int) -> None:
        self.left -= 1
        if self.left == 0:
            self.event.set()


@pytest.mark.parametrize("batches", [1, 3, 6, 9])
def test_stopped_in_any_round_and_resumed(whole: Mapping[str, bytes], tmp_path: Path, batches: int) -> None:
    """However far it came, the rest of the speeds are those of one go; resumed again, nothing is solved."""
    path, stopping = tmp_path / "results.h5", _Stopping(batches)
    first = run(
        read(tmp_path), Options(output=path, workers=Workers(jobs=1)), progress=stopping, stop=stopping.event
    )
    assert first.left > 0 and not path.exists()
    second = run(read(tmp_path), Options(output=path, resume=True))
    assert second.before == first.solved and second.left == 0
    assert content(path) == whole
    third = run(read(tmp_path), Options(output=path, resume=True))
    assert (third.solved, third.left) == (0, 0)
    assert content(path) == whole


def test_killed_from_outside_and_resumed(tmp_path: Path) -> None:
    """SIGKILL, SIGTERM with exit code 75, and the rest: the bits of one go."""
    read(tmp_path)
    path = tmp_path / "results.h5"
    for number, code in ((signal.SIGKILL, -9), (signal.SIGTERM, 75)):
        before = len(parts(path))
        process = start("run", "case.yaml", "-q", "--resume", "-j", "1", *SLOW, folder=tmp_path)
        while process.poll() is None and len(parts(path)) <= before:
            time.sleep(0.02)
        process.send_signal(number)
        process.communicate(timeout=60)
        assert process.returncode == code
        assert not path.exists() and len(parts(path)) > before
    ended = inside("run", "case.yaml", "-q", "--resume", *SLOW, folder=tmp_path)
    assert ended.code == 0, ended.err
    ended = inside("run", "case.yaml", "-q", "-o", "again.h5", *SLOW, folder=tmp_path)
    assert ended.code == 0, ended.err
    assert content(path) == content(tmp_path / "again.h5")


def test_a_gap_is_left_to_a_later_run(whole: Mapping[str, bytes], tmp_path: Path) -> None:
    """Two shards of three joined, and what the third had is solved by a resumed run of the whole."""
    case = read(tmp_path)
    paths = [tmp_path / f"{number}.h5" for number in (1, 3)]
    for number, path in zip((1, 3), paths, strict=True):
        run(case, Options(output=path, shard=Shard(number, 3)))
    names = [path.name for path in paths]
    ended = inside("merge", *names, "-o", "results.h5", folder=tmp_path)
    assert (ended.code, ended.err) == (2, "missing shards: 2/3; --partial leaves their cases to be done\n")
    assert inside("merge", *names, "-o", "results.h5", "--partial", folder=tmp_path).code == 0
    assert inside("run", "case.yaml", "--resume", "-q", folder=tmp_path).code == 0
    assert content(tmp_path / "results.h5") == whole


@pytest.mark.parametrize("kind", ["stopped", "shard", "finished"])
def test_commands_take_what_is_not_solved(kind: str, tmp_path: Path) -> None:
    """Speeds that were never needed are neither zeros nor failures, whoever looks at them."""
    case, path = read(tmp_path), tmp_path / "results.h5"
    if kind == "stopped":
        stopping = _Stopping(3)
        run(case, Options(output=path, workers=Workers(jobs=1)), progress=stopping, stop=stopping.event)
    else:
        run(case, Options(output=path, shard=Shard(2, 3) if kind == "shard" else None))
    for command in ("status", "info", "export", "report"):
        more = {"export": ("-o", "tables"), "report": ("-o", "report", "--formats", "png")}.get(command, ())
        ended = inside(command, "results.h5", *more, folder=tmp_path)
        assert ended.code == 0, (command, ended.err)
        assert not re.search(r"\bnan\b", ended.out + ended.err, re.IGNORECASE), command
        if command == "info":
            assert " 0 failed" in ended.out


def limits(values: NDArray[np.float64]) -> tuple[float, float]:
    return float(values.min()), float(values.max())


def test_from_the_command_line(tmp_path: Path) -> None:
    """`--set` makes a plain sweep a refined one, and the other way round."""
    read(tmp_path)
    axis = "sweep.velocity={from: 90, to: 110, step: 5, refine: resonance}"
    assert inside("run", "case.yaml", "-q", "--set", axis, folder=tmp_path).code == 0
    refined = peaks(tmp_path / "results.h5")["velocity"].values
    assert limits(refined) == (90.0, 110.0) and len(refined) > 8
    plain = "sweep.velocity={from: 90, to: 110, step: 5}"
    assert inside("run", "case.yaml", "-q", "--overwrite", "--set", plain, folder=tmp_path).code == 0
    assert peaks(tmp_path / "results.h5")["velocity"].values.tolist() == [90, 95, 100, 105, 110]
