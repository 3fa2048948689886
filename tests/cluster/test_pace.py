"""How long the rest of a run takes: from the times at which its batches were finished."""

from __future__ import annotations

import os
import threading
from pathlib import Path

import h5py
import numpy as np
import pytest

from tbi_cli.case import Case
from tbi_cli.cluster.status import FileStatus, RunStatus, run_status
from tbi_cli.runner import Options, Silence, run
from tbi_cli.workers import Workers
from tests.cluster.runs import parts


class _Watched(Silence):
    """Dates the batches of a run that goes on, looks how far it is, and stops it."""

    def __init__(self, path: Path, case: Case, dates: list[float]) -> None:
        self._path, self._case, self._dates = path, case, dates
        self.stop = threading.Event()
        self.found: RunStatus | None = None
        self.steps: list[int] = []

    def advance(self, scenarios: int, steps: int) -> None:
        there = parts(self._path)
        if len(there) < len(self._dates) or self.found is not None:
            return
        for path, date in zip(there, self._dates, strict=False):
            os.utime(path, (date, date))
        for path in there[: len(self._dates)]:
            with h5py.File(path) as file:
                self.steps.append(int(np.sum(file["cases"]["steps"])))
        self.found = run_status([self._path], self._case)
        self.stop.set()


def test_the_pace_is_that_between_the_first_date_and_the_last(case: Case, tmp_path: Path) -> None:
    """What was done by the first date was done before: it does not count."""
    path, dates = tmp_path / "results.h5", [1000.0, 1003.0, 1011.0, 1040.0]
    watched = _Watched(path, case, dates)
    run(case, Options(output=path, workers=Workers(jobs=1)), progress=watched, stop=watched.stop)
    assert watched.found is not None
    (file,) = watched.found.files
    assert file.state == "running" and file.steps_left > 0
    assert len(set(watched.steps)) > 1
    pace = sum(watched.steps[1:]) / (dates[-1] - dates[0])
    assert file.pace == pytest.approx(pace, rel=1e-12)
    assert watched.found.seconds_left == pytest.approx(file.steps_left / pace, rel=1e-12)


def test_shards_that_run_together_share_what_is_left() -> None:
    """Three at paces of their own, and one that stands still."""
    paces, left = (100.0, 250.0, 50.0, None), (3000, 9000, 100, 5000)
    files = tuple(
        FileStatus(None, None, 9, 3, 0, "running" if pace else "stopped", steps_left=steps, pace=pace)
        for pace, steps in zip(paces, left, strict=True)
    )
    assert RunStatus(files).seconds_left == pytest.approx(sum(left) / 400.0)
