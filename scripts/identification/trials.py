"""Many parameter sets solved at once by tbi's own solver, and read as if they were results files."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.interpolate import Akima1DInterpolator

from identification.parameters import Array, Choice, Parameter
from tbi_cli.case import Axis, Case, load_case
from tbi_cli.report.evidence import BASE, Curve, Study
from tbi_cli.solve import Solver

_MASSES = (20e3, 40e3, 60e3, 80e3)
_SLOW = tuple(float(v) for v in np.arange(12, 30, 1.5))
_FAST = tuple(float(v) for v in (*np.arange(30, 100, 3), *np.arange(100, 201, 10)))
# Curves are interpolated, so that the place of a peak moves smoothly.
_FINE = np.linspace(12, 200, 3761)
_RADIUS = 2.0  # of |lambda| times a step; Runge-Kutta is stable up to 2.7 and more
_SETS_AT_ONCE = 12  # times four masses: as many models as Scenarios keeps


@dataclass(frozen=True)
class Run:
    """Crossings that some claims are read from: axes by their short name, and options of the case."""

    axes: Mapping[str, tuple[float, ...]]
    options: tuple[str, ...] = ()


_TWO_SPEEDS = (50 / 3.6, 300 / 3.6)
# Steps of up to 5 ms are good to less than the errors of the claims; where they are unstable they are halved.
RUNS: tuple[Run, ...] = (
    Run({"car_body_mass": _MASSES}, ("solver.sampling=0.001",)),
    Run({"modes": (1, 2, 3)}, ("solver.sampling=0.002",)),
    Run({"velocity": _TWO_SPEEDS, "sampling": (0.2,)}, ("solver.substeps=40",)),
    Run({"velocity": _TWO_SPEEDS, "sampling": (0.1,)}, ("solver.substeps=20",)),
    Run({"velocity": _TWO_SPEEDS, "sampling": (0.01,)}, ("solver.substeps=2",)),
    Run({"velocity": (*_SLOW, *_FAST)}, ("solver.sampling=0.005",)),
    # What is said of other masses is about peaks at 40 m/s and more.
    Run({"car_body_mass": (20e3, 60e3, 80e3), "velocity": _FAST}, ("solver.sampling=0.005",)),
)


class Solved:
    """One parameter set, solved: what `tbi_cli.report.evidence.Evidence` is to results files."""

    studies: Sequence[Study] = ()
    case: Case | None = None  # the formulas of trust `exact` do not depend on what is free

    def __init__(self, runs: Sequence[tuple[Run, Mapping[str, Array]]]) -> None:
        self._runs = runs

    def point(self, table: str, channel: str, at: Mapping[str, float]) -> float | None:
        """One number of a table; None if no run has it."""
        for run, tables in self._runs:
            place = _place(run, at)
            if place is not None:
                return float(tables[f"{table}/{channel}"][place])
        return None

    def curve(self, table: str, channel: str, at: Mapping[str, float]) -> Curve | None:
        """A response over the velocities, interpolated."""
        for run, tables in self._runs:
            speeds = run.axes.get("velocity", ())
            place = _place(run, {**at, "velocity": speeds[0]}) if len(speeds) >= len(_FAST) else None
            if place is not None:
                curve = Akima1DInterpolator(np.array(speeds), tables[f"{table}/{channel}"][place[:-1]])
                return Curve(_FINE, curve(np.maximum(_FINE, speeds[0])))
        return None

    def values_of(self, key: str) -> list[float]:
        """The values of an axis beside velocity."""
        return list(_MASSES) if key == "car_body_mass" else []


def _place(run: Run, at: Mapping[str, float]) -> tuple[int, ...] | None:
    """Where these values are in a run; None if it has others."""
    wanted = {**BASE, **at}
    if any(key not in run.axes and not np.isclose(value, BASE[key]) for key, value in at.items()):
        return None
    place = []
    for key, values in run.axes.items():
        found = np.flatnonzero(np.isclose(values, wanted[key], rtol=1e-9))
        if not len(found):
            return None
        place.append(int(found[0]))
    return tuple(place)


class Trials:
    """Solves sets of parameters under one choice of what is discrete."""

    def __init__(self, choice: Choice, parameters: Sequence[Parameter], runs: Sequence[Run] = RUNS) -> None:
        self.parameters = parameters
        self.choice, self.runs = choice, runs

    @cached_property
    def _cases(self) -> list[Case]:
        """The case of each run; on the axis of the parameters stand their bounds, which are thus checked."""
        sweep = [
            f"sweep.{key}=[{p.lower * factor!r}, {p.upper * factor!r}]"
            for p in self.parameters
            for key, factor in p.keys
        ]
        names = ", ".join(key for p in self.parameters for key, _ in p.keys)
        zipped = [*sweep, f"sweep.zip=[[{names}]]"]
        cases = []
        for run in self.runs:
            axes = [f"sweep.{key}={list(values)}" for key, values in run.axes.items()]
            options = [*self.choice.overrides, "solver.substeps=1", *run.options, *zipped, *axes]
            cases.append(load_case("paper", overrides=options))
        return cases

    def solve(self, sets: Array) -> list[Solved]:
        """Each of the parameter sets (sets, parameters), in SI, solved."""
        found: list[Solved] = []
        for begin in range(0, len(sets), _SETS_AT_ONCE):
            some = sets[begin : begin + _SETS_AT_ONCE]
            solved = [self._tables(case) for case in self.cases(some)]
            found += [
                Solved(
                    [
                        (run, {name: values[k] for name, values in tables.items()})
                        for run, tables in zip(self.runs, solved, strict=True)
                    ]
                )
                for k in range(len(some))
            ]
        return found

    def cases(self, sets: Array) -> list[Case]:
        """The case of each run, its first axis being the parameter sets."""
        return [case.swept((self._axis(case.axes[0], sets), *case.axes[1:])) for case in self._cases]

    @staticmethod
    def _tables(case: Case) -> dict[str, Array]:
        """The tables of one run by table/channel, each (sets, *axes of the run)."""
        solver = Solver(case)
        scenarios = solver.scenarios
        per_set = len(scenarios) // len(case.axes[0])
        fastest = max(scenarios.model(index).pace.fastest for index in range(0, len(scenarios), per_set))
        needed = math.ceil(scenarios.case_of(0).solver.sampling * fastest / _RADIUS)
        if needed > case.solver.substeps:
            return Trials._tables(case.replacing("solver", case.solver.replacing("substeps", needed)))
        crossers = [scenarios.crosser(index) for index in range(len(scenarios))]
        structure = np.array([(len(c.model.system.beams[0].omega), c.grid.substeps) for c in crossers])
        steps = np.array([c.grid.steps for c in crossers])
        names = [channel.name for channel in solver.tables]
        found: dict[str, Array] = {}
        for kind in np.unique(structure, axis=0):
            members = np.flatnonzero((structure == kind).all(axis=1))
            members = members[np.argsort(-steps[members], kind="stable")]  # lanes of like length
            result = solver.solve(members)
            assert result is not None
            columns = {
                f"{table}/{name}": values[:, c]
                for table, values in result.tables.items()
                for c, name in enumerate(names)
            } | {f"daf/{side}": values for side, values in result.daf.items()}
            for name, values in columns.items():
                found.setdefault(name, np.full(len(scenarios), np.nan))[members] = values
        return {name: values.reshape(scenarios.shape) for name, values in found.items()}

    def _axis(self, axis: Axis, sets: Array) -> Axis:
        """The axis of the parameters with these sets on it."""
        factors = [(k, factor) for k, p in enumerate(self.parameters) for _, factor in p.keys]
        members = tuple(
            replace(member, values=tuple((sets[:, k] * factor).tolist()))
            for member, (k, factor) in zip(axis.members or (axis,), factors, strict=True)
        )
        if len(members) == 1:
            return members[0]
        return replace(axis, members=members, values=tuple(float(i) for i in range(len(sets))))
