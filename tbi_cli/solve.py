"""A handful of scenarios of a case, solved: from the grid to tables and histories."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from functools import cached_property
from itertools import product

import numpy as np
from numpy.typing import NDArray

from tbi_cli.batch import Crosser, build_batch
from tbi_cli.case import Axis, Case
from tbi_cli.integrator.integrate import Reduced, StoppedError, integrate
from tbi_cli.responses import Channel
from tbi_cli.scenarios import Scenarios
from tbi_cli.store.records import DONE, FAILED, BatchResult, History

Array = NDArray[np.float64]


class Solver:
    """Solves scenarios of one case: which channels it reduces and keeps is settled once.

    `tables` and `histories` are the channels of the results file; a scenario with fewer modes than another
    lacks some of the latter, which are NaN in its histories.
    """

    def __init__(self, case: Case, stopped: Callable[[], bool] = lambda: False) -> None:
        self.case = case
        self.scenarios = Scenarios(case)
        self.stopped = stopped

    @property
    def parts(self) -> dict[str, Solver]:
        """The solvers of its grids by name: of a case that is one grid, itself."""
        return {"": self}

    @property
    def kernel(self) -> str:
        """The kind of kernel that crosses its bridge."""
        return "forces" if self.scenarios.model(0).system.constant_forces else "general"

    @cached_property
    def channels(self) -> tuple[Channel, ...]:
        """Every channel that any scenario has: those of the most modes and of the most coaches."""
        found: dict[str, Channel] = {}
        for place in product(*(_largest(axis) for axis in self.scenarios.axes)):
            flat = int(np.ravel_multi_index(place, self.scenarios.shape)) if place else 0
            found |= {channel.name: channel for channel in self.scenarios.model(flat).channels}
        return tuple(found.values())

    @cached_property
    def tables(self) -> tuple[Channel, ...]:
        """The channels of the tables."""
        return tuple(channel for channel in self.channels if channel.in_tables)

    @cached_property
    def histories(self) -> tuple[Channel, ...]:
        """The channels of the histories: those named, or all, or none.  KeyError for an unknown one."""
        wanted = self.case.output.histories.channels
        by_name = {channel.name: channel for channel in self.channels if channel.in_histories}
        if wanted is None:
            return tuple(by_name.values())
        return tuple(by_name[name] for name in wanted)

    def describe(self, index: int) -> str:
        """A scenario in words, for messages."""
        return self.scenarios.describe(index) or "the case"

    def solve(self, indices: Sequence[int] | NDArray[np.int64]) -> BatchResult | None:
        """Solves scenarios that share their number of modes and of substeps; None if told to stop.

        A scenario whose state stops being finite has failed, with a message; the others are not touched.
        """
        crossers = [self.scenarios.crosser(int(index)) for index in indices]
        channels = crossers[0].model.channels
        place = {channel.name: c for c, channel in enumerate(channels)}
        kept = [channel for channel in self.histories if channel.name in place]
        columns = [self._columns(channels, place, channel.name) for channel in self.tables]
        reduced_ones = sorted({c for column in columns for c in column})
        batch = build_batch(crossers, reduced_ones, [place[channel.name] for channel in kept])
        every = np.array([c.grid.stride for c in crossers]) if self.histories else None
        begin = time.perf_counter()
        try:
            reduced = integrate(
                batch.topology,
                batch.crossing,
                batch.last,
                batch.substeps,
                every=every,
                rails=batch.rails,
                stopped=self.stopped,
            )
        except StoppedError:
            return None
        seconds = time.perf_counter() - begin
        columns = [[reduced_ones.index(c) for c in column] for column in columns]
        return self._result(np.asarray(indices, dtype=np.int64), crossers, reduced, columns, kept, seconds)

    @staticmethod
    def _columns(channels: Sequence[Channel], place: dict[str, int], name: str) -> list[int]:
        """The places of the channels of a model that a table's channel is made of; none if it lacks it."""
        if name not in place:
            return []
        return [place[member] for member in channels[place[name]].members or (name,)]

    def _result(
        self,
        indices: NDArray[np.int64],
        crossers: Sequence[Crosser],
        reduced: Reduced,
        columns: Sequence[Sequence[int]],
        kept: Sequence[Channel],
        seconds: float,
    ) -> BatchResult:
        sampling = np.array([c.grid.sampling for c in crossers])
        steps = np.array([c.grid.steps for c in crossers], dtype=np.int64)
        failed = ~np.isnan(reduced.failed_at) | ~np.isfinite(reduced.square_sum).all(axis=0)
        tables = _train_wide(_tables(reduced, sampling, crossers), columns)
        for values in tables.values():
            values[failed] = np.nan
        ends = [c.grid.start + reduced.failed_at[i] * sampling[i] for i, c in enumerate(crossers)]
        messages = [
            f"the state was no longer finite at t = {ends[i]:.6g} s" if failed[i] else ""
            for i in range(len(indices))
        ]
        return BatchResult(
            indices=indices,
            status=np.where(failed, FAILED, DONE).astype(np.int8),
            messages=messages,
            tables=tables,
            daf=self._amplification(tables["peak"], crossers),
            solve_seconds=seconds * steps / max(int(steps.sum()), 1),
            case_steps=steps,
            histories={
                int(indices[i]): self._history(
                    values, kept, crossers[i].grid.start, crossers[i].grid.stride * sampling[i]
                )
                for i, values in reduced.histories.items()
                if not failed[i]
            },
        )

    def _amplification(self, peak: Array, crossers: Sequence[Crosser]) -> dict[str, Array]:
        """The dynamic amplification factors of section 3.6 and of model.md, by beam.

        NaN of a beam on which nothing presses at rest: there is nothing to be amplified.
        """
        factors: dict[str, Array] = {}
        names = [channel.name for channel in self.tables]
        system = crossers[0].model.system
        for b, side in enumerate(("right", "left")[: len(system.beams)]):
            deflection = peak[:, names.index(f"{side}_midspan")]
            weights = []
            for crosser in crossers:
                s = crosser.model.system
                weights.append(s.beams[b].static_deflection(float(s.wheel_load[s.wheel_beam == b].sum())))
            crawling = [crosser.model.crawling[b] for crosser in crossers]
            for name, static in ((side, np.array(weights)), (f"{side}_static", np.array(crawling))):
                nothing = np.full(len(deflection), np.nan)
                factors[name] = np.divide(deflection, static, out=nothing, where=static != 0)
        return factors

    def _history(self, values: Array, kept: Sequence[Channel], start: float, interval: float) -> History:
        if len(kept) < len(self.histories):
            names = [channel.name for channel in kept]
            full = np.full((len(self.histories), values.shape[1]), np.nan)
            full[[k for k, channel in enumerate(self.histories) if channel.name in names]] = values
            values = full
        return History(start + np.arange(values.shape[1], dtype=np.float64) * interval, values)


def _largest(axis: Axis) -> list[int]:
    """Where on an axis the model is largest: at the most modes, at the most coaches; else at the start."""
    columns = [
        column
        for column in axis.members or (axis,)
        if all(path == "bridge.modes" or path.endswith(".count") for path in column.paths)
    ]
    return sorted({int(np.argmax(column.values)) for column in columns}) or [0]


def _tables(reduced: Reduced, sampling: Array, crossers: Sequence[Crosser]) -> dict[str, Array]:
    """The five tables, (scenarios, channels), from what the integrator reduced."""
    # Adding zero turns -0 into 0: two ways to the same number shall have the same bits.
    maximum, minimum = reduced.maximum.T + 0.0, reduced.minimum.T + 0.0
    high, low = reduced.step_of_maximum.T, reduced.step_of_minimum.T
    upper = np.where(maximum == -minimum, np.minimum(high, low), np.where(maximum > -minimum, high, low))
    substeps = np.array([c.grid.substeps for c in crossers])
    start = np.array([c.grid.start for c in crossers])
    samples = np.array([c.grid.last + 1 for c in crossers])
    return {
        "peak": np.maximum(np.abs(maximum), np.abs(minimum)),
        "max": maximum,
        "min": minimum,
        "rms": np.sqrt(reduced.square_sum.T / samples[:, None]),
        "time_of_peak": start[:, None] + upper / substeps[:, None] * sampling[:, None],
    }


def _train_wide(tables: dict[str, Array], columns: Sequence[Sequence[int]]) -> dict[str, Array]:
    """The tables (scenarios, len(columns)): the extremes over some columns each, NaN where there is none."""
    found = {name: np.full((len(values), len(columns)), np.nan) for name, values in tables.items()}
    for k, column in enumerate(columns):
        if not column:
            continue
        largest = np.argmax(tables["peak"][:, column], axis=1)
        for name, values in tables.items():
            if name == "time_of_peak":
                found[name][:, k] = np.take_along_axis(values[:, column], largest[:, None], axis=1)[:, 0]
            else:
                found[name][:, k] = (np.min if name == "min" else np.max)(values[:, column], axis=1)
    return found
