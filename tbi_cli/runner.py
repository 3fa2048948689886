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
from numpy.typing import NDArray

from tbi_cli.case import Axis, Case
from tbi_cli.errors import UserError
from tbi_cli.plan import Plan, PlanError, joined, make_plan
from tbi_cli.refine import Refiner, refiner_of
from tbi_cli.resources import available_memory
from tbi_cli.responses import Channel
from tbi_cli.shards import Shard
from tbi_cli.solve import Solver
from tbi_cli.store import (
    DONE,
    FAILED,
    Dim,
    Layout,
    ResultsStore,
    StudiesStore,
    Variable,
    check_output,
    open_parts,
    open_results,
    provenance,
)
from tbi_cli.store.layout import TABLES, Scalar
from tbi_cli.store.parts import parts_folder
from tbi_cli.store.picked import REFINED
from tbi_cli.studies import AnySolver, StudiesSolver, solver_of
from tbi_cli.workers import Workers, solve_batches


class RunError(UserError):
    """A run that cannot be made as asked; the text is the complete message."""


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
    """How a run went: scenarios solved now, solved before, failed, and not reached because it was stopped."""

    path: Path
    solved: int
    before: int
    failed: int
    left: int
    steps: int
    seconds: float
    messages: tuple[str, ...]


@dataclass(frozen=True)
class Options:
    """How a run is made; nothing here changes a number in a table."""

    output: Path | None = None
    workers: Workers = field(default_factory=Workers)
    shard: Shard | None = None
    resume: bool = False
    overwrite: bool = False
    command: Sequence[str] = ("tbi",)


def run(
    case: Case,
    options: Options | None = None,
    *,
    progress: Progress | None = None,
    stop: threading.Event | None = None,
) -> Summary:
    """Solves every scenario of a case that is not solved yet and writes the results file.

    Once `stop` is set, the batches under way are dropped, and what is finished stays beside the results
    file, to be resumed.  Raises RunError for what cannot be run, StoreError for trouble with the file.
    """
    options, progress = options or Options(), progress or Silence()
    options.workers.check()
    output = output_of(case, options)
    check_output(output, resume=options.resume, overwrite=options.overwrite)
    halted = _Halted(stop)
    solver = solver_of(case, halted.is_set)
    refiner = refiner_of(solver, options.shard)
    if refiner is not None and options.resume and (summary := _finished(output, case)) is not None:
        return summary
    with _store(output, solver, options) as store:
        _compile(progress)
        run = _Run(solver, store, options, progress, halted)
        if refiner is None:
            run.round(plan_of(solver, ~store.done(), options.shard))
        else:
            _refined(run, refiner, output)
        path = store.finish() if not run.left else store.path
    return run.summary(path)


def _refined(run: _Run, refiner: Refiner, output: Path) -> None:
    """Round after round until every peak is settled, or the run is halted."""
    done = run.store.done()
    if done.any() and (before := open_parts(output) or open_results(output)) is not None:
        with before:
            known = np.flatnonzero(done)
            peaks = before.tables(["peak"])["peak"][refiner.columns]
            refiner.learn_peaks(known, peaks[:, known].T)
    wanted, beside = refiner.first(), np.zeros(len(done), dtype=bool)
    while wanted.any():
        plan = plan_of(run.solver, wanted & ~done & ~beside)
        run.round(replace(plan, own=wanted & refiner.own), refiner)
        beside |= wanted & ~refiner.own
        if run.left:
            return
        wanted, done = refiner.more(), run.store.done()
        if wanted.any() and run.halted:
            run.left = int(np.sum(wanted & refiner.own))
            return


def _finished(output: Path, case: Case) -> Summary | None:
    """What a resumed run of a refined case has to say where its results file is there and complete."""
    if not output.exists() or parts_folder(output).exists():
        return None
    with open_results(output) as results:
        if results.layout.attributes.get("case_sha256") != case.sha256:
            return None
        if results.layout.attributes.get("shard"):
            return None
        done = int(np.sum(results.status == DONE))
        failed = int(np.sum(results.status == FAILED))
    return Summary(output, 0, done, failed, 0, 0, 0.0, ())


class _Run:
    """The rounds of a run, of which all but those of a refined case have one; what came of them."""

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
        self._begin = time.perf_counter()

    def round(self, plan: Plan, refiner: Refiner | None = None) -> None:
        """Solves the batches of a plan; what is not this run's own is for the refiner alone."""
        solver, store, progress = self.solver, self.store, self.progress
        before = int(store.done()[plan.own].sum())
        progress.start(int(plan.own.sum()), int(plan.steps.sum()), before)
        self._before, self._steps = self._before + before, self._steps + int(plan.steps.sum())
        solved = 0
        results = solve_batches(solver, plan.batches, plan.sizes, self._options.workers, self._halted)
        try:
            for result in results:
                if refiner is not None:
                    refiner.learn(result)
                own = plan.own[result.indices]
                if own.all():
                    store.write(result)
                elif own.any():
                    store.write(result.picked(own))
                solved += int(own.sum())
                self._failed += int(np.sum(result.status[own] == FAILED))
                self._messages += [
                    f"{solver.describe(int(index))}: {text}"
                    for index, text, kept in zip(result.indices, result.messages, own, strict=True)
                    if text and kept
                ]
                progress.advance(int(own.sum()), int(result.case_steps.sum()))
        finally:
            results.close()
            progress.end()
        self._solved += solved
        self.left = int(plan.own.sum()) - before - solved

    @property
    def halted(self) -> bool:
        """Whether nothing more is to be solved."""
        return self._halted.is_set()

    def summary(self, path: Path) -> Summary:
        """How the run went."""
        return Summary(
            path=path,
            solved=self._solved - self._failed,
            before=self._before,
            failed=self._failed,
            left=self.left,
            steps=self._steps,
            seconds=time.perf_counter() - self._begin,
            messages=tuple(self._messages),
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


def _store(output: Path, solver: AnySolver, options: Options) -> ResultsStore | StudiesStore:
    """The store of a run, opened."""
    origin = origin_of(solver.case, options.command, options.shard)
    if isinstance(solver, Solver):
        layout = results_layout(solver, origin)
        check_memory([layout])
        return ResultsStore(output, layout, resume=options.resume, overwrite=options.overwrite)
    if options.shard is not None:
        raise RunError("--shard: a case of several studies is not divided; run it whole, or each study alone")
    layouts = {}
    for name, part in solver.parts.items():
        own = {"title": part.case.title, "case": part.case.to_yaml(), "case_sha256": part.case.sha256}
        layouts[name] = results_layout(part, {**origin, **own})
    check_memory(list(layouts.values()))
    return StudiesStore(output, layouts, origin, resume=options.resume, overwrite=options.overwrite)


def plan_of(solver: AnySolver, wanted: NDArray[np.bool_], shard: Shard | None = None) -> Plan:
    """The batches for the scenarios that are wanted (n,).  Raises RunError where one cannot be solved."""
    if isinstance(solver, StudiesSolver):
        plans = []
        for name, part in solver.parts.items():
            first = solver.starts[name]
            try:
                plans.append(plan_of(part, wanted[first : first + len(part.scenarios)]))
            except RunError as error:
                raise RunError(f"studies.{name}: {error}") from None
        return joined(plans)
    every = solver.case.output.histories.every
    try:
        return make_plan(solver.scenarios, wanted, len(solver.histories), every, shard)
    except PlanError as error:
        raise RunError(str(error)) from None


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
        known = ", ".join(channel.name for channel in solver.channels)
        raise RunError(f"output.histories.channels: expected some of {known}; got {error.args[0]}") from None
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


def check_memory(layouts: Sequence[Layout]) -> None:
    """Raises RunError if the tables of grids do not fit into half of the memory that is free."""
    need = sum(
        8 * layout.size * (len(TABLES) * len(layout.channels) + len(layout.daf) + 4) for layout in layouts
    )
    scenarios = sum(layout.size for layout in layouts)
    free = available_memory()
    if need > free / 2:
        raise RunError(
            f"sweep: expected a grid whose tables fit into half of the free memory ({free / 2**30:.1f} GiB), "
            f"got {scenarios} scenarios that need {need / 2**30:.1f} GiB; split it into several cases"
        )


def _variables(channels: Sequence[Channel]) -> tuple[Variable, ...]:
    return tuple(Variable(c.name, c.units, c.long_name) for c in channels)


def _compile(progress: Progress) -> None:
    from tbi_cli.integrator.kernel_cache import compile_kernels

    compile_kernels(progress.say)


def this_command() -> list[str]:
    """The command line of this process, for the provenance."""
    return ["tbi", *sys.argv[1:]]
