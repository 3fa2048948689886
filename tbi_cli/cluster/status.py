"""How far a run is, and how long it will take from here: read from its files alone."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import chain
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tbi_cli.case import Case
from tbi_cli.cluster.job import submission_folder
from tbi_cli.cluster.submission import read_note
from tbi_cli.errors import UserError
from tbi_cli.plan import Costs, costs_of
from tbi_cli.report.stored_case import stored_case
from tbi_cli.scenarios import Scenarios
from tbi_cli.shards import Shard, deal
from tbi_cli.store import DONE, FAILED, Results, StoreError, open_parts, open_results
from tbi_cli.store.lock import LOCK_FILE, read_holder
from tbi_cli.store.parts import parts_folder

# The pace of a run is that of its latest batches: it may have stood still before, or had other neighbours.
_LATEST = 20
_LOOKS = 5


@dataclass(frozen=True)
class FileStatus:
    """How far one results file is: a whole run, or a shard of one.

    `state` is finished, incomplete, running, stopped or not begun; `where` says who is at it; `steps_left`
    are the Runge-Kutta steps to do, and `pace` how many are done in a second, None where it does not run.
    `seconds_per_step` is what a step takes one processor, None before the first batch.
    """

    path: Path | None
    shard: Shard | None
    scenarios: int
    done: int
    failed: int
    state: str
    where: str = ""
    steps_left: int = 0
    pace: float | None = None
    seconds_per_step: float | None = None

    @property
    def missing(self) -> int:
        """Scenarios that nobody has solved yet."""
        return self.scenarios - self.done - self.failed


@dataclass(frozen=True)
class RunStatus:
    """How far a run is, all its files together."""

    files: tuple[FileStatus, ...]

    @property
    def scenarios(self) -> int:
        """Scenarios of the grid."""
        return sum(file.scenarios for file in self.files)

    @property
    def done(self) -> int:
        """Scenarios solved."""
        return sum(file.done for file in self.files)

    @property
    def failed(self) -> int:
        """Scenarios that failed."""
        return sum(file.failed for file in self.files)

    @property
    def seconds_left(self) -> float | None:
        """How long the rest takes at the present pace; None if nothing runs or nothing is known."""
        pace = sum(file.pace or 0.0 for file in self.files)
        return sum(file.steps_left for file in self.files) / pace if pace else None

    @property
    def processor_seconds_left(self) -> float | None:
        """How long the rest would take one processor; None before the first batch."""
        known = [file.seconds_per_step for file in self.files if file.seconds_per_step is not None]
        return sum(file.steps_left for file in self.files) * float(np.median(known)) if known else None


def run_status(paths: Sequence[Path], case: Case | None = None, *, study: str = "") -> RunStatus:
    """How far the run is whose results file, or whose shards, are at `paths`.

    A results file that is not there yet, and was sent to a cluster, stands for its shards.  `case` is needed
    where nothing has been computed yet, and must be the one that the files hold.  `study` names one of
    several that a file holds.  Raises UserError where
    there is nothing to tell about.
    """
    for _ in range(_LOOKS - 1):
        with contextlib.suppress(FileNotFoundError, StoreError):
            return _look(paths, case, study)
        time.sleep(0.2)  # a run that is just ending puts its files away
    return _look(paths, case, study)


def _look(paths: Sequence[Path], case: Case | None, study: str) -> RunStatus:
    with contextlib.ExitStack() as stack:
        opened: list[_Opened] = []
        for path, shard in chain.from_iterable(_files(named.resolve()) for named in paths):
            results = _open(path, study)
            if results is not None:
                stack.enter_context(results)
            opened.append(_Opened(path, _shard_in(results) or shard, results))
        of = {file.shard.of for file in opened if file.shard is not None}
        if len(of) > 1:
            counts = ", ".join(map(str, sorted(of)))
            raise UserError(f"{paths[0]}: the shards are of different numbers ({counts})")
        grid = _Grid(_case_of(opened, case, paths[0]))
        told = [grid.status(file) for file in opened]
    there = {file.shard.number for file in told if file.shard is not None}
    absent = [Shard(number, n) for n in of for number in range(1, n + 1) if number not in there]
    told += [grid.status(_Opened(None, shard, None)) for shard in absent]
    return RunStatus(tuple(sorted(told, key=lambda file: file.shard.number if file.shard else 0)))


@dataclass(frozen=True)
class _Opened:
    path: Path | None
    shard: Shard | None
    results: Results | None


class _Grid:
    """The grid that the files share.  What its scenarios cost is found out only if some are missing."""

    def __init__(self, case: Case) -> None:
        self._scenarios = Scenarios(case)

    @cached_property
    def _costs(self) -> Costs:
        return costs_of(self._scenarios, np.arange(len(self._scenarios)), 0, None)

    @lru_cache  # noqa: B019 - one grid in a process
    def _owners(self, of: int) -> NDArray[np.int64]:
        return deal(self._costs.steps, self._costs.structure, of)

    def status(self, file: _Opened) -> FileStatus:
        """How far one file is."""
        results, shard = file.results, file.shard
        n = len(self._scenarios)
        status = np.zeros(n, dtype=np.int8) if results is None else results.status.ravel()
        attributes = {} if results is None else results.attributes
        steps, seconds = float(attributes.get("case_steps", 0)), float(attributes.get("solve_seconds", 0))
        known = FileStatus(
            path=file.path,
            shard=shard,
            scenarios=int(np.sum(status != 0)),
            done=int(np.sum(status == DONE)),
            failed=int(np.sum(status == FAILED)),
            state="finished",
            seconds_per_step=seconds / steps if steps else None,
        )
        if results is not None and results.finished and (shard is not None or status.all()):
            return known
        own = np.ones(n, dtype=bool) if shard is None else self._owners(shard.of) == shard.number
        state, where = _state(file)
        return replace(
            known,
            scenarios=int(own.sum()),
            state=state,
            where=where,
            steps_left=int(self._costs.steps[own & (status == 0)].sum()),
            pace=_pace(results) if state == "running" and results is not None else None,
        )


def _files(path: Path) -> list[tuple[Path, Shard | None]]:
    """The files that a path stands for: itself, or the shards of a run that was sent to a cluster."""
    note = read_note(submission_folder(path))
    if note is None or path.exists() or parts_folder(path).exists():
        return [(path, None)]
    shards = [Shard(number, note["shards"]) for number in range(1, note["shards"] + 1)]
    return [(shard.path(submission_folder(path) / "shards" / path.name), shard) for shard in shards]


def _open(path: Path, study: str) -> Results | None:
    """What a run has written so far; None before its first batch."""
    results = open_parts(path, study)
    if results is not None:
        return results
    return open_results(path, study=study) if path.exists() else None


def _shard_in(results: Results | None) -> Shard | None:
    text = "" if results is None else str(results.attributes.get("shard", ""))
    return Shard.parse(text) if text else None


def _case_of(opened: Sequence[_Opened], case: Case | None, named: Path) -> Case:
    """The case of all files; raises UserError if they are of several."""
    for file in opened:
        if file.results is None:
            continue
        if case is None:
            case = stored_case(file.results.case_yaml)
            if case is None:
                raise UserError(f"{file.path}: holds a case that this version of tbi cannot read")
        if file.results.attributes.get("case_sha256") != case.sha256:
            raise UserError(f"{file.path}: holds another case")
    if case is None:
        raise UserError(f"{named}: nothing has been computed yet")
    return case


def _state(file: _Opened) -> tuple[str, str]:
    """What goes on with a file that is not complete, and who is at it."""
    if file.path is None or not parts_folder(file.path).exists():
        return ("not begun" if file.results is None else "incomplete"), ""
    holder = read_holder(parts_folder(file.path) / LOCK_FILE)
    if holder is None or holder.is_gone():
        return "stopped", ""
    return "running", f"process {holder.pid} on {holder.host}"


def _pace(results: Results) -> float | None:
    """Runge-Kutta steps a second over the latest batches; None before the second one."""
    latest = results.sources[-_LATEST:]
    if len(latest) < 2:
        return None
    times = [source.path.stat().st_mtime for source in latest]
    return sum(source.case_steps for source in latest[1:]) / max(times[-1] - times[0], 1e-3)
