"""Speeds that a sweep grows by itself: at resonances, at peaks, and where a channel bends sharply.

The axis holds all speeds that there may be, `per_step` in each of its steps; which of them are solved is
found out in rounds, by a search in each step, see `tbi_cli.step_search`.  A search knows the solutions alone
that it has asked for itself, in its step and the two beside it, so every shard, and every run that is
resumed, grows the same speeds.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tbi_cli.case.messages import not_among
from tbi_cli.case.refinement import LEAST_PARTS
from tbi_cli.plan import costs_of
from tbi_cli.shards import Shard
from tbi_cli.solve import Solver
from tbi_cli.step_search import StepSearch
from tbi_cli.store.records import DONE, BatchResult
from tbi_cli.system.resonance import resonances

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


class Refiner:
    """Decides, round by round, which scenarios of a grid with a refined velocity are solved.

    `own` (n,) are the scenarios of this run's shard, in whole steps of the axis.  A shard searches the steps
    beside its own as well, whose searches may reach into its own, but leaves theirs to the others to keep.
    """

    def __init__(self, solver: Solver, shard: Shard | None = None) -> None:
        axes = solver.scenarios.axes
        place = next(k for k, axis in enumerate(axes) if axis.refinement is not None)
        axis = axes[place]
        assert axis.refinement is not None
        self.refinement = axis.refinement
        self._solver = solver
        self._speeds = np.array(axis.values)
        self._step = self.refinement.per_step
        self._columns = _columns(solver, self.refinement.channels)
        self._cells = (len(self._speeds) - 1) // self._step
        # A scenario's number is (outer * speeds + speed) * inner + the place on the axes behind.
        shape = solver.scenarios.shape
        self._outer, self._inner = int(np.prod(shape[:place])), int(np.prod(shape[place + 1 :]))
        # The peaks (channels, scenarios at one speed) at each speed that was solved.
        self._peaks: dict[int, Array] = {}
        self._asked: set[int] = set()
        self._mine = self._cells_of(shard)
        cell = np.minimum(np.arange(len(self._speeds)) // self._step, self._cells - 1)
        self.own = self._of_speeds(np.flatnonzero(self._mine[cell]))
        near = self._mine.copy()
        near[1:] |= self._mine[:-1]
        near[:-1] |= self._mine[1:]
        self._searched = np.flatnonzero(near).tolist()
        self._searches: list[StepSearch] = []

    def _of_speeds(self, speeds: list[int] | NDArray[np.int64]) -> Mask:
        """The scenarios (n,) at some speeds."""
        mask = np.zeros((self._outer, len(self._speeds), self._inner), dtype=bool)
        mask[:, speeds] = True
        return mask.ravel()

    def _numbers(self, speed: int) -> NDArray[np.int64]:
        """The scenarios at one speed, in the order of their peaks."""
        outer, inner = np.arange(self._outer)[:, None], np.arange(self._inner)
        return np.asarray(((outer * len(self._speeds) + speed) * self._inner + inner).ravel())

    def _cells_of(self, shard: Shard | None) -> Mask:
        """The steps of the axis that are a shard's: neighbours, so many that all shards cost alike."""
        if shard is None:
            return np.ones(self._cells, dtype=bool)
        ends = np.array([self._numbers(cell * self._step) for cell in range(self._cells)])
        costs = costs_of(self._solver.scenarios, ends.ravel(), 0, None)
        steps = np.asarray(costs.steps[ends].sum(axis=1), dtype=np.int64)
        before = np.cumsum(steps) - steps
        place = shard.of * (2 * before + steps) // max(2 * int(np.sum(steps)), 1)
        return np.asarray(np.minimum(place, shard.of - 1) + 1 == shard.number)

    def first(self) -> Mask:
        """The scenarios (n,) of the first round."""
        resonant = np.array(self._resonances(), dtype=np.int64)
        self._searches = [
            StepSearch(cell, self._speeds, self.refinement, resonant) for cell in self._searched
        ]
        return self._next([search.places for search in self._searches])

    def _resonances(self) -> list[int]:
        """Places of the speeds of resonance of all trains and bridges of the grid, with one to either side.

        They are in the coarsest halving of the step that is finer than a quarter of their peaks' width, so
        that trains and bridges that are much alike share them.
        """
        slowest, fastest = float(self._speeds[0]), float(self._speeds[-1])
        found: set[int] = set()
        seen: set[tuple[float, ...]] = set()
        for number in self._numbers(0).tolist():
            key = self._solver.scenarios.model_key(number)
            if key in seen:
                continue
            seen.add(key)
            for resonance in resonances(self._solver.scenarios.case_of(number), slowest, fastest):
                width = resonance.width * resonance.speed
                for speed in (resonance.speed - width, resonance.speed, resonance.speed + width):
                    found |= self._snapped(speed, width / 4)
        return sorted(found)

    def _snapped(self, speed: float, apart: float) -> set[int]:
        """The place nearest to a speed in the coarsest halving of the steps into less than `apart`."""
        if not self._speeds[0] <= speed <= self._speeds[-1]:
            return set()
        after = int(np.clip(np.searchsorted(self._speeds, speed), 1, len(self._speeds) - 1))
        start = (after - 1) // self._step * self._step
        low, high = float(self._speeds[start]), float(self._speeds[start + self._step])
        halvings = int(np.clip(np.ceil(np.log2((high - low) / apart)), 0, self._step.bit_length() - 1))
        parts = 2**halvings
        return {start + round((speed - low) / (high - low) * parts) * (self._step // parts)}

    def learn(self, result: BatchResult) -> None:
        """Takes in what was solved."""
        done = result.status == DONE
        self.learn_peaks(result.indices[done], result.tables["peak"][done][:, self._columns])

    def learn_peaks(self, indices: NDArray[np.int64], peaks: Array) -> None:
        """Takes in the peaks (scenarios, channels) of scenarios that were solved before."""
        speeds = indices // self._inner % len(self._speeds)
        places = indices // (self._inner * len(self._speeds)) * self._inner + indices % self._inner
        for speed in np.unique(speeds).tolist():
            here = speeds == speed
            self._row(speed)[:, places[here]] = peaks[here].T

    def _row(self, speed: int) -> Array:
        """The peaks at one speed; NaN where nothing was solved, or it failed."""
        nothing = np.full((len(self._columns), self._outer * self._inner), np.nan)
        return self._peaks.setdefault(speed, nothing)

    @property
    def columns(self) -> list[int]:
        """The channels that decide, by their place in the tables."""
        return self._columns

    def more(self) -> Mask:
        """The scenarios (n,) of the next round: none once every peak is settled."""
        return self._next([self._wishes(search) for search in self._searches])

    def _wishes(self, search: StepSearch) -> list[int]:
        """The next places that a search asks for: if others have asked for them before, those after."""
        while True:
            places = search.more(self._peaks)
            if not self._asked.issuperset(places) or not places:
                return places

    def _next(self, asked: list[list[int]]) -> Mask:
        new = {place for places in asked for place in places} - self._asked
        self._asked |= new
        for place in new:
            self._row(place)
        return self._of_speeds(sorted(new))

    def unsettled(self) -> Mask:
        """The scenarios (n,) with a peak that may still change by more than the tolerance."""
        found = np.zeros(len(self.own), dtype=bool)
        for search in self._searches:
            for place, which in search.unsettled.items():
                found[self._numbers(place)[which]] = True
        return found & self.own


def refiner_of(solver: object, shard: Shard | None = None) -> Refiner | None:
    """The refiner of a case, where its velocity is refined."""
    if not isinstance(solver, Solver):
        return None
    refined = any(axis.refinement is not None for axis in solver.scenarios.axes)
    return Refiner(solver, shard) if refined else None


def usual_scenarios(solver: Solver) -> Mask:
    """As many scenarios (n,) of a grid as are usually solved at most.

    Of a refined grid these are the ones down to which lines are drawn; peaks add a few.
    """
    scenarios = solver.scenarios
    mask = np.ones(scenarios.shape, dtype=bool)
    for place, axis in enumerate(scenarios.axes):
        if axis.refinement is not None:
            kept = np.arange(len(axis)) % (axis.refinement.per_step // LEAST_PARTS) == 0
            mask = mask & kept.reshape(-1, *[1] * (len(scenarios.shape) - place - 1))
    return mask.ravel()


def _columns(solver: Solver, names: tuple[str, ...] | None) -> list[int]:
    """The places of the channels that decide in the tables.  Raises RunError for an unknown one."""
    tables = [channel.name for channel in solver.tables]
    if names is None:
        names = tuple(
            name
            for side in ("right", "left")
            for name in (f"{side}_midspan", f"{side}_midspan_acceleration")
            if name in tables
        )
    for name in names:
        if name not in tables:
            raise solver.case.refused("sweep.velocity.channels", not_among(name, tables))
    return [tables.index(name) for name in names]
