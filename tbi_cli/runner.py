"""A whole run: the grid of a case solved in parallel, batch by batch, into a results file."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Protocol

import numpy as np

from tbi_cli.advice import go_on, in_python
from tbi_cli.case import Axis, Case
from tbi_cli.case.messages import not_among
from tbi_cli.errors import RunFailedError, UserError
from tbi_cli.integrator.kernel_cache import compile_kernels
from tbi_cli.plan import Plan, joined, make_plan
from tbi_cli.refine import usual_scenarios
from tbi_cli.resources import available_memory
from tbi_cli.responses import Channel
from tbi_cli.rounds import Mask, Rounds
from tbi_cli.shards import Shard
from tbi_cli.shortage import shortage
from tbi_cli.solve import Solver
from tbi_cli.store import (
    FAILED,
    Dim,
    Layout,
    ResultsStore,
    StudiesStore,
    Variable,
    check_output,
    provenance,
)
from tbi_cli.store.compare import refuse_other_run
from tbi_cli.store.errors import ExistsError, PlaceError, StoreError
from tbi_cli.store.layout import TABLES, Scalar
from tbi_cli.store.opening import resolve
from tbi_cli.store.parts import parts_folder
from tbi_cli.store.picked import REFINED
from tbi_cli.store.studies import attributes_of
from tbi_cli.studies import AnySolver, kernels_of, solver_of
from tbi_cli.workers import Workers, solve_batches


class Progress(Protocol):
    """What a run tells while it goes on."""

    def say(self, text: str) -> None:
        """A line for the user."""

    def start(self, scenarios: int, steps: int, done: int) -> None:
        """The run begins: so many scenarios of so many steps, `done` of them solved before."""

    def advance(self, scenarios: int, steps: int) -> None:
        """A batch is on disk."""

    def end(self) -> None:
        """No more will come."""


class Silence:
    """A progress that says nothing."""

    def say(self, text: str) -> None:
        """Nothing."""

    def start(self, scenarios: int, steps: int, done: int) -> None:
        """Nothing."""

    def advance(self, scenarios: int, steps: int) -> None:
        """Nothing."""

    def end(self) -> None:
        """Nothing."""


@dataclass(frozen=True)
class Summary:
    """How a run went: scenarios solved now, solved before, failed, and not reached because it was stopped.

    `unsettled` describes the scenarios at which a refined sweep did not reach its tolerance.
    """

    path: Path
    solved: int
    before: int
    failed: int
    left: int
    steps: int
    seconds: float
    messages: tuple[str, ...]
    unsettled: tuple[str, ...] = ()


@dataclass(frozen=True)
class Options:
    """How a run is made; nothing here changes a number in a table."""

    output: Path | None = None
    workers: Workers = field(default_factory=Workers)
    shard: Shard | None = None
    resume: bool = False
    overwrite: bool = False
    command: Sequence[str] = ()


def run(
    case: Case,
    options: Options | None = None,
    *,
    progress: Progress | None = None,
    stop: threading.Event | None = None,
) -> Summary:
    """Solves every scenario of a case that is not solved yet and writes the results file.

    Once `stop` is set, the batches under way are dropped, and what is finished stays beside the results
    file, to be resumed.  Raises RunError for what cannot be run, StoreError for trouble with the file,
    RunFailedError where memory, threads or open files run short.
    """
    options = options or Options()
    try:
        return _solve(case, options, progress or Silence(), _Halted(stop))
    except (StoreError, RunFailedError) as error:
        text = f"{error}; {go_on(options.command)}" if error.goes_on else str(error)
        raise type(error)(text if options.command else in_python(text)) from error
    except Exception as error:
        if isinstance(error, UserError) or (reason := shortage(error)) is None:
            raise
        text = f"{reason}; what was finished is kept (fewer --jobs need less); {go_on(options.command)}"
        raise RunFailedError(text) from error


def _solve(case: Case, options: Options, progress: Progress, halted: _Halted) -> Summary:
    options.workers.check()
    output = output_of(case, options)
    _check_output(output, case, options)
    solver = solver_of(case, halted.is_set)
    rounds = Rounds(solver, options.shard)
    with _store(output, solver, options) as store:
        run = _Run(solver, store, options, progress, halted)
        rounds.learn_stored(store.parts)
        run.all_of(rounds)
        path = store.finish() if not run.left else store.path
        unsettled = [] if run.left else np.flatnonzero(rounds.unsettled()).tolist()
    return run.summary(path, [solver.describe(index) for index in unsettled])


class _Run:
    """What is solved, round by round, and what came of it."""

    def __init__(
        self,
        solver: AnySolver,
        store: ResultsStore | StudiesStore,
        options: Options,
        progress: Progress,
        halted: _Halted,
    ) -> None:
        self.solver, self.store, self.progress = solver, store, progress
        self.left = 0
        self._options, self._halted = options, halted
        self._solved = self._failed = self._before = self._steps = 0
        self._messages: list[str] = []
        self._seconds = 0.0

    def all_of(self, rounds: Rounds) -> None:
        """Round after round until every peak is settled, or the run is halted."""
        wanted, beside = rounds.first(), np.zeros(len(rounds.own), dtype=bool)
        while wanted.any():
            plan = plan_of(self.solver, wanted & ~self.store.done() & ~beside)
            self._round(plan, wanted & rounds.own, rounds)
            beside |= wanted & ~rounds.own
            if self.left:
                return
            wanted = rounds.more()
            rounds.note_unsettled(self.store.parts)
            if wanted.any() and self._halted.is_set():
                self.left = int(np.sum(wanted & rounds.own))
                return

    def _round(self, plan: Plan, kept: Mask, rounds: Rounds) -> None:
        """Solves the batches of a plan; what is not to be kept (n,) is for the rounds alone."""
        solver, store, progress = self.solver, self.store, self.progress
        if plan.batches:
            compile_kernels(progress.say, kernels_of(solver))
        begin = time.perf_counter()
        before = int(store.done()[kept].sum())
        progress.start(int(kept.sum()), int(plan.steps.sum()), before)
        self._before, self._steps = self._before + before, self._steps + int(plan.steps.sum())
        solved = 0
        results = solve_batches(solver, plan.batches, plan.sizes, self._options.workers, self._halted)
        try:
            for result in results:
                rounds.learn(result)
                own = kept[result.indices]
                if own.all():
                    store.write(result)
                elif own.any():
                    store.write(result.picked(own))
                solved += int(own.sum())
                self._failed += int(np.sum(result.status[own] == FAILED))
                self._messages += [
                    f"{solver.describe(int(index))}: {text}"
                    for index, text, mine in zip(result.indices, result.messages, own, strict=True)
                    if text and mine
                ]
                progress.advance(int(own.sum()), int(result.case_steps.sum()))
        finally:
            results.close()
            progress.end()
        self._seconds += time.perf_counter() - begin
        self._solved += solved
        self.left = int(kept.sum()) - before - solved

    def summary(self, path: Path, unsettled: Sequence[str]) -> Summary:
        """How the run went."""
        return Summary(
            path=path,
            solved=self._solved - self._failed,
            before=self._before,
            failed=self._failed,
            left=self.left,
            steps=self._steps,
            seconds=self._seconds,
            messages=tuple(self._messages),
            unsettled=tuple(unsettled),
        )


class _Halted(threading.Event):
    """Set when the run has to end early: by the caller's `stop`, or by an error."""

    def __init__(self, stop: threading.Event | None) -> None:
        super().__init__()
        self._stop = stop

    def is_set(self) -> bool:
        """Whether nothing more is to be solved."""
        return super().is_set() or (self._stop is not None and self._stop.is_set())


def output_of(case: Case, options: Options) -> Path:
    """Where the results go; a shard that was given no name of its own has its number in it."""
    if options.output is not None:
        return options.output
    path = Path(case.output.file)
    return path if options.shard is None else options.shard.path(path)


def _check_output(output: Path, case: Case, options: Options) -> None:
    """Raises StoreError, or RunError about the key `output.file`, if the results may not go there."""
    try:
        check_output(output, resume=options.resume, overwrite=options.overwrite)
    except PlaceError as error:
        if options.output is not None:
            raise
        raise case.refused("output.file", str(error)) from None
    except ExistsError:
        # What is another run's is not to be completed or replaced by this one.
        path = resolve(output)
        where = path if path.exists() else parts_folder(path)
        refuse_other_run(str(where), attributes_of(path), origin_of(case, options.command, options.shard))
        raise


def _store(output: Path, solver: AnySolver, options: Options) -> ResultsStore | StudiesStore:
    """The store of a run, opened."""
    origin = origin_of(solver.case, options.command, options.shard)
    if isinstance(solver, Solver):
        layout = results_layout(solver, origin)
        check_memory(solver.case, [solver], [layout])
        return ResultsStore(output, layout, resume=options.resume, overwrite=options.overwrite)
    layouts = {}
    for name, part in solver.parts.items():
        own = {"title": part.case.title, "case": part.case.to_yaml(), "case_sha256": part.case.sha256}
        layouts[name] = results_layout(part, {**origin, **own})
    check_memory(solver.case, list(solver.parts.values()), list(layouts.values()))
    return StudiesStore(output, layouts, origin, resume=options.resume, overwrite=options.overwrite)


def plan_of(solver: AnySolver, wanted: Mask) -> Plan:
    """The batches for the scenarios that are wanted (n,).  Raises RunError where one cannot be solved."""
    plans, first = [], 0
    for part in solver.parts.values():
        own, first = wanted[first : first + len(part.scenarios)], first + len(part.scenarios)
        plans.append(make_plan(part.scenarios, own, len(part.histories), part.case.output.histories.every))
    return joined(plans)


def origin_of(case: Case, command: Sequence[str], shard: Shard | None = None) -> dict[str, Scalar]:
    """The attributes of the root of a case's results file."""
    return provenance(
        case_yaml=case.to_yaml(),
        case_sha256=case.sha256,
        command=command,
        title=case.title,
        shard=str(shard or ""),
    )


def results_layout(solver: Solver, origin: Mapping[str, Scalar]) -> Layout:
    """What the results file of a case will hold; `origin` are the attributes of its root."""
    case, axes = solver.case, solver.scenarios.axes
    try:
        histories = solver.histories
    except KeyError as error:
        text = not_among(str(error.args[0]), [channel.name for channel in solver.channels])
        raise case.refused("output.histories.channels", text) from None
    dims = tuple(replace(_dim(axis), members=tuple(_dim(member) for member in axis.members)) for axis in axes)
    if not axes:
        dims = (Dim("velocity", np.array([case.velocity]), "m/s", "train velocity"),)
    sides = ("right", "left") if case.bridge.left is not None else ("right",)
    refined = [axis.name for axis in axes if axis.refinement is not None]
    return Layout(
        dims=dims,
        channels=_variables(solver.tables),
        history_channels=_variables(histories),
        daf=(*sides, *(f"{side}_static" for side in sides)),
        attributes={**origin, REFINED: refined[0]} if refined else origin,
    )


def _dim(axis: Axis) -> Dim:
    return Dim(axis.name, np.array(axis.values, dtype=float), axis.units, axis.long_name)


def check_memory(case: Case, parts: Sequence[Solver], layouts: Sequence[Layout]) -> None:
    """Raises RunError if the tables of grids do not fit into half of the memory that is free.

    Of a refined grid the tables hold the scenarios that are solved, see `usual_scenarios`.
    """
    sizes = [int(usual_scenarios(part).sum()) for part in parts]
    need = sum(
        8 * size * (len(TABLES) * len(layout.channels) + len(layout.daf) + 4)
        for size, layout in zip(sizes, layouts, strict=True)
    )
    scenarios = sum(sizes)
    free = available_memory()
    if need > free / 2:
        text = (
            f"expected a grid whose tables fit into half of the free memory ({free / 2**30:.1f} GiB), "
            f"got {scenarios} scenarios that need {need / 2**30:.1f} GiB; split it into several cases"
        )
        raise case.refused("studies" if case.studies else "sweep", text)


def _variables(channels: Sequence[Channel]) -> tuple[Variable, ...]:
    return tuple(Variable(c.name, c.units, c.long_name) for c in channels)


def this_command() -> list[str]:
    """The command line of this process, for the provenance."""
    return ["tbi", *sys.argv[1:]]
