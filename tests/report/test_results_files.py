"""Reports of files that are not as they should be: clear messages, gaps where there are gaps."""

from __future__ import annotations

import threading
from pathlib import Path

import h5py
import numpy as np
import pytest

from tbi_cli.case import load_case
from tbi_cli.report.make import make_report
from tbi_cli.report.plot import Panel
from tbi_cli.report.wishes import Wishes
from tbi_cli.runner import Options, Silence, run
from tbi_cli.store import open_results
from tbi_cli.workers import Workers
from tests.cli.commands import everything_below, tbi

SWEEP = ("sweep", "velocity", "paper", "--from", "60", "--to", "120", "--step", "10", "-q", "-o", "sweep.h5")


@pytest.fixture
def file(tmp_path: Path) -> Path:
    ended = tbi(*SWEEP, folder=tmp_path)
    assert ended.code == 0, ended.err
    return tmp_path / "sweep.h5"


def refused(folder: Path, message: str) -> None:
    before = everything_below(folder)
    ended = tbi("report", "sweep.h5", folder=folder)
    assert ended.code == 2
    assert message in ended.err
    assert len(ended.err.splitlines()) == 1
    assert ended.out == ""
    assert everything_below(folder) == before


def test_no_such_file(tmp_path: Path) -> None:
    refused(tmp_path, "No such file")


def test_a_truncated_file(file: Path) -> None:
    content = file.read_bytes()
    file.write_bytes(content[: len(content) // 2])
    refused(file.parent, "is damaged or cut short")


def test_a_file_that_is_no_hdf5(file: Path) -> None:
    file.write_text("velocity,car_body_y\n")
    refused(file.parent, "is not an HDF5 file")


def test_somebody_elses_hdf5(file: Path) -> None:
    file.unlink()
    with h5py.File(file, "w") as other:
        other["velocity"] = [1.0, 2.0]
    refused(file.parent, "not one that tbi wrote")


def test_another_version_of_the_format(file: Path) -> None:
    with h5py.File(file, "a") as changed:
        changed.attrs["format_version"] = 99
    refused(file.parent, "has the format version 99, this tbi reads")


def test_a_table_that_lost_a_variable(file: Path) -> None:
    with h5py.File(file, "a") as changed:
        del changed["peak/car_body_y"]
    ended = tbi("report", "sweep.h5", folder=file.parent)
    assert ended.code == 2
    assert "car_body_y" in ended.err
    assert not (file.parent / "sweep-report").exists()


class StopAfterFirst(Silence):
    """A user who stops the run when the first batch is on disk."""

    def __init__(self) -> None:
        self.stop = threading.Event()

    def advance(self, scenarios: int, steps: int) -> None:
        self.stop.set()


def half_finished(path: Path) -> tuple[int, list[bool]]:
    """A run of 41 speeds that was stopped: how many are missing, and which are done."""
    case = load_case("paper", overrides=["sweep.velocity={from: 60, to: 100, step: 1}"])
    user = StopAfterFirst()
    command = ("tbi", "sweep", "velocity", "--from", "60", "--overwrite", "-o", str(path))
    options = Options(output=path, workers=Workers(jobs=1), command=command)
    summary = run(case, options, progress=user, stop=user.stop)
    assert summary.left > 0
    with open_results(path) as opened:
        return summary.left, (opened.status == 1).tolist()


def test_a_half_finished_run_is_reported_with_gaps_and_their_count(tmp_path: Path) -> None:
    left, _ = half_finished(tmp_path / "half.h5")
    ended = tbi("report", "half.h5", "-o", "out", "--formats", "png", folder=tmp_path)
    assert ended.code == 0, ended.err
    message = f"half.h5: {left} of 41 scenarios are not solved yet; curves and tables have gaps"
    assert message in ended.out
    assert (
        f"continue with: cd {Path.cwd()} && tbi sweep velocity --from 60 -o {tmp_path / 'half.h5'} --resume"
        in ended.out
    )
    assert message in (tmp_path / "out" / "report.html").read_text()
    assert (tmp_path / "out" / "fig15.png").exists()


def test_gaps_are_gaps_in_the_curves(tmp_path: Path) -> None:
    _, done = half_finished(tmp_path / "half.h5")
    made = make_report([tmp_path / "half.h5"], tmp_path / "out", Wishes(formats=("svg",)), jobs=1)
    (figure,) = (plot for plot in made.figures if plot.name == "fig15")
    panel = figure.panels[0]
    assert isinstance(panel, Panel)
    for curve in panel.curves:
        assert np.isfinite(curve.y).tolist() == done


def test_a_shard_says_that_it_is_one(tmp_path: Path) -> None:
    assert tbi(*SWEEP, "--shard", "1/2", folder=tmp_path).code == 0
    (shard,) = tmp_path.glob("*.h5")
    ended = tbi("report", shard.name, "-o", "out", "--formats", "png", folder=tmp_path)
    assert ended.code == 0, ended.err
    assert "this is shard 1/2: join it with the others by tbi merge SHARDS -o RESULTS.h5" in ended.out


def test_text_from_the_file_stays_text(file: Path) -> None:
    evil = "<script>alert(1)</script> & $\\frac{ \x07\u202e"
    with h5py.File(file, "a") as changed:
        for name in ("title", "command", "host", "case"):
            changed.attrs[name] = evil
        changed["peak/car_body_y"].attrs["long_name"] = evil
        changed["velocity"].attrs["long_name"] = evil
        changed["velocity"].attrs["units"] = "$\\frac"
    ended = tbi("report", "sweep.h5", "-o", "out", "--formats", "svg", folder=file.parent)
    assert ended.code == 0, ended.err
    assert "\x07" not in ended.out
    page = (file.parent / "out" / "report.html").read_text()
    assert "<script>alert" not in page
    assert "&lt;script&gt;alert(1)&lt;/script&gt;" in page


def test_a_file_whose_case_cannot_be_read_still_has_its_curves(file: Path) -> None:
    with h5py.File(file, "a") as changed:
        changed.attrs["case"] = "train: /etc/passwd\nbridge: paper\n"
    ended = tbi("report", "sweep.h5", "-o", "out", "--formats", "png", folder=file.parent)
    assert ended.code == 0, ended.err
    assert (file.parent / "out" / "fig15.png").exists()
    # What follows from the case alone is missing: no critical velocities, no Table 2.
    assert not (file.parent / "out" / "table2.csv").exists()
    assert "root:x:0" not in (file.parent / "out" / "report.html").read_text()
