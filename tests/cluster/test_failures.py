"""A scenario that fails: told by its message, the exit code and the last line; the others are solved."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest
import typer

from tbi_cli.case import Case, load_case
from tbi_cli.cli.run import _run as run_and_print
from tbi_cli.cluster.joining import join_shards
from tbi_cli.cluster.status import run_status
from tbi_cli.runner import Options, run
from tbi_cli.shards import Shard
from tests.cluster.runs import content

MESSAGE = "failed: gravity = 1e+303 m/s^2: the state was no longer finite at t = "


@pytest.fixture(scope="module")
def overflowing() -> Case:
    """Its middle scenario leaves the range of floating point; the case reader would refuse the value."""
    case = load_case("paper", overrides=["sweep={gravity: [1, 2, 4]}", "solver.duration=1"])
    return case.swept((replace(case.axes[0], values=(1.0, 1e303, 4.0)),))


def test_one_fails_and_is_tried_again(
    overflowing: Case, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "results.h5"
    for before, how in ((0, Options(output=path)), (2, Options(output=path, resume=True))):
        with pytest.raises(typer.Exit) as ended:
            run_and_print(overflowing, how, False, False, False)
        assert ended.value.exit_code == 1
        out, err = capsys.readouterr()
        assert MESSAGE in err
        assert "2 scenarios solved, 1 failed" in out
        assert (f"({before} of them before)" in out) == bool(before)
        assert out.splitlines()[-1] == f"results: {path}; 1 scenario failed"
        # The largest of those that were solved, not the one that is no number.
        (line,) = (line.split() for line in out.splitlines() if line.startswith("car_body_y "))
        assert line[-2:] == ["4", "m/s^2"] and "nan" not in line
    with h5py.File(path) as file:
        assert file["status"][()].tolist() == [1, 2, 1]
        assert b"no longer finite" in file["message"][1]
        assert np.isnan(file["peak/car_body_y"][()]).tolist() == [False, True, False]
    told = run_status([path], overflowing)
    assert (told.scenarios, told.done, told.failed) == (3, 2, 1)


def test_a_shard_with_a_failed_scenario_is_joined(overflowing: Case, tmp_path: Path) -> None:
    run(overflowing, Options(output=tmp_path / "whole.h5"))
    paths = [tmp_path / f"{number}.h5" for number in (1, 2)]
    for number, path in enumerate(paths, 1):
        run(overflowing, Options(output=path, shard=Shard(number, 2)))
    lines = join_shards(paths, tmp_path / "joined.h5", partial=False, overwrite=False)
    assert lines[0] == "2 shards joined, 3 scenarios: 2 done, 1 failed"
    assert content(tmp_path / "joined.h5") == content(tmp_path / "whole.h5")
