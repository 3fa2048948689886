"""How far a run is: told from its files alone."""

from __future__ import annotations

import re
import signal
import time
from pathlib import Path

import pytest

from tbi_cli.case import Case
from tbi_cli.cluster.status import FileStatus, RunStatus, run_status
from tbi_cli.cluster.status_text import duration, status_lines
from tbi_cli.errors import UserError
from tbi_cli.runner import Options, run
from tbi_cli.shards import Shard
from tests.cluster.runs import ENDLESS, SCENARIOS, inside, parts, start

SECONDS = 300.0


def test_before_while_and_after(folder: Path) -> None:
    ended = inside("status", "case.yaml", folder=folder)
    assert ended.code == 0
    assert f"scenarios  {SCENARIOS}: 0 done, 0 failed, {SCENARIOS} missing\n" in ended.out
    assert "not begun" in ended.out
    ended = inside("status", "results.h5", folder=folder)
    assert (ended.code, ended.out, ended.err) == (2, "", "results.h5: nothing has been computed yet\n")

    process = start("run", "case.yaml", *ENDLESS, folder=folder)
    end = time.monotonic() + SECONDS
    while len(parts(folder / "results.h5")) < 3:
        assert time.monotonic() < end
        time.sleep(0.02)
    ended = inside("status", "results.h5", folder=folder)
    process.send_signal(signal.SIGTERM)
    process.communicate(timeout=SECONDS)
    assert process.returncode == 75
    done, failed, missing = (int(n) for n in re.findall(r"(\d+) (?:done|failed|missing)", ended.out)[:3])
    assert (done + missing, failed) == (SCENARIOS, 0)
    assert 0 < done < SCENARIOS
    assert f"results.h5: running by process {process.pid} on " in ended.out
    assert re.search(r"time left  about \d+ s at the present pace\n", ended.out)

    stopped = inside("status", "case.yaml", *ENDLESS, folder=folder)
    assert "results.h5: stopped, " in stopped.out
    assert "of one processor" in stopped.out
    other = inside("status", "case.yaml", folder=folder)
    assert (other.code, other.err) == (2, f"{folder / 'results.h5'}: holds another case\n")


def test_shards(case: Case, tmp_path: Path) -> None:
    paths = [Shard(number, 4).path(tmp_path / "results.h5") for number in (1, 3)]
    for number, path in zip((1, 3), paths, strict=True):
        run(case, Options(output=path, shard=Shard(number, 4)))
    status = run_status(paths[::-1])
    assert [str(file.shard) for file in status.files] == ["1/4", "2/4", "3/4", "4/4"]
    assert [file.state for file in status.files] == ["finished", "not begun", "finished", "not begun"]
    assert status.scenarios == SCENARIOS
    assert status.done == sum(file.scenarios for file in status.files if file.state == "finished")
    assert status.seconds_left is None
    assert status.processor_seconds_left is not None
    assert status.processor_seconds_left > 0
    lines = status_lines(status)
    assert lines[1] == "shards     4: 2 finished, 2 not begun"
    assert lines[3].startswith("shard 2/4: not begun, 0 of ")

    run(case, Options(output=tmp_path / "other.h5", shard=Shard(1, 3)))
    with pytest.raises(UserError, match=r"the shards are of different numbers \(3, 4\)"):
        run_status([*paths, tmp_path / "other.h5"])


@pytest.mark.parametrize(
    ("seconds", "words"),
    [(0.2, "0 s"), (119, "119 s"), (120, "2 min"), (7199, "120 min"), (9000, "2.5 h"), (200000, "2.3 days")],
)
def test_durations(seconds: float, words: str) -> None:
    assert duration(seconds) == words


def test_a_refined_sweep_between_two_rounds() -> None:
    """Nothing is known to be missing, and yet it is not finished."""
    file = FileStatus(Path("r.h5"), None, 90, 90, 0, "stopped", growing=True)
    assert status_lines(RunStatus((file,))) == [
        "scenarios  at least 90: 90 done, 0 failed, none missing so far",
        "r.h5: stopped, 90 of 90 done",
        "time left  unknown: the sweep may add scenarios where it is refined",
    ]
