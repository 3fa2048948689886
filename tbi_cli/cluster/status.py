"""How far a run is, and how long it will take from here: read from its files alone."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from itertools import chain
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tbi_cli.case import Case
from tbi_cli.cluster.found import Opened, case_of, files_of, opened_by_study, shard_in
from tbi_cli.errors import UserError
from tbi_cli.plan import costs_of, dealt
from tbi_cli.refine import refiner_of
from tbi_cli.shards import Shard
from tbi_cli.store import DONE, FAILED, Results, StoreError
from tbi_cli.store.lock import LOCK_FILE, read_holder
from tbi_cli.store.opening import is_there, resolve
from tbi_cli.store.parts import parts_folder
from tbi_cli.store.picked import numbers_in, refined_axis
from tbi_cli.studies import solver_of

# The pace of a run is that of its latest batches: it may have stood still before, or had other neighbours.
_LATEST = 20
_LOOKS = 5
_SECONDS_OF_LOOKS = 3.0
# More shards than scenarios are none that tbi sends; by hand one may have one number for all of one's runs.
_MANY_SHARDS = 1000


@dataclass(frozen=True)
class FileStatus:
    """How far one results file is: a whole run, or a shard of one.

    `state` is finished, incomplete, running, stopped or not begun; `where` says who is at it; `steps_left`
    are the Runge-Kutta steps to do, and `pace` how many are done in a second, None where it does not run.
    `seconds_per_step` is what a step takes one processor, None before the first batch.  `growing` if a
    refined sweep may come to more scenarios than are counted.
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
    growing: bool = False

    @property
    def missing(self) -> int:
        """Scenarios that nobody has solved yet."""
        return self.scenarios - self.done - self.failed


@dataclass(frozen=True)
class RunStatus:
    """How far a run is, all its files together, and each study of it where it is of several."""

    files: tuple[FileStatus, ...]
    studies: Mapping[str, RunStatus] = field(default_factory=dict)

    @property
    def growing(self) -> bool:
        """Whether a refined sweep may come to more scenarios than are counted."""
        return any(file.growing for file in self.files)

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


def run_status(paths: Sequence[Path], case: Case | None = None) -> RunStatus:
    """How far the run is whose results file, or whose shards, are at `paths`.

    A results file that is not there yet stands for its shards, beside it or sent to a cluster.  `case` is
    needed where nothing has been computed yet, and must be the one that the files hold.  Raises UserError
    where there is nothing to tell about.
    """
    begin = time.monotonic()
    for _ in range(_LOOKS - 1):
        with contextlib.suppress(FileNotFoundError, StoreError):
            return _look(paths, case)
        if time.monotonic() - begin > _SECONDS_OF_LOOKS:  # what takes so long is not just ending
            break
        time.sleep(0.2)  # a run that is just ending puts its files away
    return _look(paths, case)


def _look(paths: Sequence[Path], case: Case | None) -> RunStatus:
    with contextlib.ExitStack() as stack:
        opened: list[Opened] = []
        for path, shard in chain.from_iterable(files_of(resolve(named)) for named in paths):
            results = opened_by_study(path)
            for part in results.values():
                stack.enter_context(part)
            opened.append(Opened(path, shard_in(path, results) or shard, results))
        of = {file.shard.of for file in opened if file.shard is not None}
        if len(of) > 1:
            counts = ", ".join(map(str, sorted(of)))
            raise UserError(f"{paths[0]}: the shards are of different numbers ({counts})")
        grids = _Grids(case_of(opened, case, paths[0]))
        most = max(_MANY_SHARDS, grids.size)
        if of and max(of) > most:
            raise UserError(f"{paths[0]}: expected at most {most} shards, got {max(of)}")
        there = {file.shard.number for file in opened if file.shard is not None}
        opened += [
            Opened(None, Shard(number, n), {})
            for n in of
            for number in range(1, n + 1)
            if number not in there
        ]
        opened.sort(key=lambda file: file.shard.number if file.shard else 0)
        told = {name: RunStatus(tuple(grids.status(name, file) for file in opened)) for name in grids.names}
        if list(told) == [""]:
            return told[""]
        rows = zip(*(status.files for status in told.values()), strict=True)
        return RunStatus(tuple(_together(file, row) for file, row in zip(opened, rows, strict=True)), told)


class _Grids:
    """The grids that the files share.  What scenarios cost is found out only if some are missing."""

    def __init__(self, case: Case) -> None:
        self._parts = solver_of(case).parts
        self.names = tuple(self._parts)
        self.size = sum(len(part.scenarios) for part in self._parts.values())

    @lru_cache  # noqa: B019 - one case in a process
    def _owners(self, of: int) -> dict[str, NDArray[np.int64]]:
        grids = {name: part.scenarios for name, part in self._parts.items() if refiner_of(part) is None}
        return dealt(grids, of)

    def _own(self, name: str, shard: Shard | None) -> tuple[NDArray[np.bool_], bool]:
        """The scenarios of a shard, or of all; of a refined grid those of the first round, and True."""
        refiner = refiner_of(self._parts[name], shard)
        if refiner is not None:
            return refiner.first() & refiner.own, True
        if shard is None:
            return np.ones(len(self._parts[name].scenarios), dtype=bool), False
        return self._owners(shard.of)[name] == shard.number, False

    def status(self, name: str, file: Opened) -> FileStatus:
        """How far one grid of a file is."""
        results, scenarios = file.results.get(name), self._parts[name].scenarios
        status = np.zeros(len(scenarios), dtype=np.int8)
        whole = False
        if results is not None:
            axes = [np.array(axis.values) for axis in scenarios.axes]
            status[numbers_in(results.dims, axes) if axes else [0]] = results.status.ravel()
            whole = bool(results.status.all()) and refined_axis(results.layout) is None
        attributes = {} if results is None else results.attributes
        steps, seconds = float(attributes.get("case_steps", 0)), float(attributes.get("solve_seconds", 0))
        known = FileStatus(
            path=file.path,
            shard=file.shard,
            scenarios=int(np.sum(status != 0)),
            done=int(np.sum(status == DONE)),
            failed=int(np.sum(status == FAILED)),
            state="finished",
            seconds_per_step=seconds / steps if steps else None,
        )
        if results is not None and results.finished and (file.shard is not None or whole):
            return known
        own, growing = self._own(name, file.shard)
        missing = np.flatnonzero(own & (status == 0))
        state, where = _state(file)
        return replace(
            known,
            scenarios=known.scenarios + len(missing),
            state=state,
            where=where,
            steps_left=int(costs_of(scenarios, missing, 0, None).steps.sum()),
            pace=_pace([results]) if state == "running" and results is not None else None,
            growing=growing,
        )


def _together(file: Opened, studies: Sequence[FileStatus]) -> FileStatus:
    """How far a file of several studies is."""
    first = next((study for study in studies if study.state != "finished"), studies[0])
    known = [study.seconds_per_step for study in studies if study.seconds_per_step is not None]
    return replace(
        first,
        scenarios=sum(study.scenarios for study in studies),
        done=sum(study.done for study in studies),
        failed=sum(study.failed for study in studies),
        steps_left=sum(study.steps_left for study in studies),
        pace=_pace(list(file.results.values())) if first.state == "running" else None,
        seconds_per_step=float(np.median(known)) if known else None,
        growing=any(study.growing for study in studies),
    )


def _state(file: Opened) -> tuple[str, str]:
    """What goes on with a file that is not complete, and who is at it."""
    if file.path is None or not is_there(parts_folder(file.path)):
        return ("incomplete" if file.results else "not begun"), ""
    holder = read_holder(parts_folder(file.path) / LOCK_FILE)
    if holder is None or holder.is_gone():
        return "stopped", ""
    return "running", f"process {holder.pid} on {holder.host}"


def _pace(results: Sequence[Results]) -> float | None:
    """Runge-Kutta steps a second over the latest batches; None before the second one."""
    sources = [source for part in results for source in part.sources]
    latest = sorted((source.path.stat().st_mtime, source.case_steps) for source in sources)[-_LATEST:]
    if len(latest) < 2:
        return None
    return sum(steps for _, steps in latest[1:]) / max(latest[-1][0] - latest[0][0], 1e-3)
