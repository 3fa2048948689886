"""What a case would cost: its grid, steps, bytes and time, without solving it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tbi_cli.case import Axis, Case, Consist
from tbi_cli.case.refinement import LEAST_PARTS
from tbi_cli.refine import usual_scenarios
from tbi_cli.resources import available_cpus
from tbi_cli.rounds import Rounds
from tbi_cli.runner import check_memory, plan_of, results_layout
from tbi_cli.solve import Solver
from tbi_cli.store.layout import TABLES
from tbi_cli.studies import solver_of

# Seconds of one processor for one step of one coordinate, side by side with others: an order of magnitude.
_SECONDS_PER_STEP = 7e-9
# As many scenarios, or models of vehicles, as are looked at in about a second; of more, some speak for all.
_MOST_SCENARIOS, _MOST_VEHICLES = 20_000, 100


def estimate(case: Case) -> list[str]:
    """Lines for people.  Raises RunError for a case that could not be run."""
    solver = solver_of(case)
    parts = solver.parts
    layouts = [results_layout(part, {}) for part in parts.values()]
    check_memory(case, list(parts.values()), layouts)
    Rounds(solver)
    usual = [usual_scenarios(part) for part in parts.values()]
    scenarios = sum(int(mask.sum()) for mask in usual)
    weights = np.concatenate(
        [_weights(part, mask, len(parts)) for part, mask in zip(parts.values(), usual, strict=True)]
    )
    plan = plan_of(solver, weights > 0)
    steps, histories = (round(float(counts @ weights)) for counts in (plan.steps, plan.sizes))
    sizes = [np.full(len(part.scenarios), _coordinates(part)) for part in parts.values()]
    seconds = float(plan.steps * np.concatenate(sizes) @ weights) * _SECONDS_PER_STEP
    refined = any(axis.refinement is not None for part in parts.values() for axis in part.scenarios.axes)
    most = "at most about " if refined else ""
    about = "about " if np.any(weights > 1) and not refined else ""
    tables = sum(
        8 * int(mask.sum()) * (len(TABLES) * len(layout.channels) + len(layout.daf) + 1)
        for mask, layout in zip(usual, layouts, strict=True)
    )
    stored = any(layout.history_channels for layout in layouts)
    cpus = available_cpus()
    lines = [f"title      {case.title}"] if case.title else []
    for name, part in parts.items():
        lines += [f"study      {name}"] if name else []
        lines += _described(part)
    return [
        *lines,
        f"scenarios  {most}{scenarios}",
        f"steps      {most}{about}{float(f'{steps:.3g}') if about else steps:,.0f}",
        f"tables     {most}{_bytes(tables)}",
        f"histories  {most + about + _bytes(histories) if stored else 'none'}",
        f"time       {most or 'about '}{_time(seconds / cpus)} on {cpus} CPU{'s' if cpus > 1 else ''}",
    ]


def _weights(solver: Solver, usual: NDArray[np.bool_], of: int) -> NDArray[np.float64]:
    """How many scenarios each scenario of a grid stands for: 1, or of a large grid 0 or a few, drawn by lot.

    usual: those that are thought of (n,); of: how many grids there are besides, which share the time.
    """
    scenarios = solver.scenarios
    count = int(usual.sum())
    train = solver.case.train
    vehicles = sum(group.count for group in train.consist) if isinstance(train, Consist) else 1
    models = _MOST_VEHICLES // (vehicles * of)
    wanted = max(_MOST_SCENARIOS // of if scenarios.model_count <= models else models, 1)
    if count <= wanted:
        return usual.astype(np.float64)
    # One in each stretch of as many, the first and the last among them.
    ends = np.linspace(0, count, wanted + 1)
    draws = np.random.default_rng(0).uniform(ends[:-1], ends[1:]).astype(np.int64)
    draws[0], draws[-1] = 0, count - 1
    weights = np.zeros(len(scenarios))
    np.add.at(weights, np.flatnonzero(usual)[draws], count / wanted)
    return weights


def _described(solver: Solver) -> list[str]:
    """The train, the bridge and the axes of one grid."""
    case = solver.case
    lines = [
        f"train      {case.train.model}",
        f"bridge     {case.bridge.length:g} m, {case.bridge.modes} modes on each beam",
    ]
    for axis in solver.scenarios.axes:
        count = f"{len(axis)} value{'s' if len(axis) > 1 else ''}"
        if axis.refinement is not None:
            steps = (len(axis) - 1) // axis.refinement.per_step
            count = f"{steps + 1} to about {steps * LEAST_PARTS + 1} values"
        ends = "; ".join(_ends(member) for member in axis.members or (axis,))
        lines.append(f"axis       {axis.name}: {count}, {ends}")
    return lines


def _ends(axis: Axis) -> str:
    """From where to where an axis goes, with its unit."""
    unit = "" if axis.units == "1" else f" {axis.units}"
    first, last = min(axis.values), max(axis.values)
    return f"{first:g} to {last:g}{unit}" if len(axis) > 1 else f"{first:g}{unit}"


def _coordinates(solver: Solver) -> int:
    """How many coordinates a grid's first scenario has: the vehicle's and the modal amplitudes."""
    system = solver.scenarios.model(0).system
    return len(system.coordinates) + len(system.beams) * len(system.beams[0].omega)


def _bytes(count: int) -> str:
    for unit in ("B", "kB", "MB", "GB"):
        if count < 1000:
            return f"{count:.3g} {unit}"
        count = count / 1000  # type: ignore[assignment]
    return f"{count:.3g} TB"


def _time(seconds: float) -> str:
    if seconds < 1:
        return "a second"
    if seconds < 120:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 7200 else f"{seconds / 3600:.1f} h"
