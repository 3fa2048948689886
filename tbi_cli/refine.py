"""Speeds that a sweep grows by itself: near resonance, and where a table's channel bends sharply.

The axis holds all speeds that there may be, `per_step` in each of its steps; which of them are solved is
found out in rounds.  The first takes the steps themselves and, for every train and bridge of the grid, the
speed nearest to each v = f_j D/i: mode j of a beam, with the i-th part of its period for the way D after
which the train repeats itself.  A round later those speeds come in between neighbours of which the middle
one is off the straight line through the others by more than the tolerance.  What happens in a step depends
on the solutions in it and at the four ends of it and its neighbours alone, so every shard, and every run that
is resumed, grows the same speeds.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tbi_cli.errors import UserError
from tbi_cli.plan import costs_of
from tbi_cli.shards import Shard
from tbi_cli.solve import Solver
from tbi_cli.store.records import DONE, BatchResult
from tbi_cli.system.resonance import resonant_speeds

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

# How much more a channel may be off the straight line in a dip, where no peak is to be settled.
_IN_DIPS = 5.0


class Refiner:
    """Decides, round by round, which scenarios of a grid with a refined velocity are solved.

    `own` (n,) are the scenarios of this run's shard, in whole steps of the axis; a shard solves the ends of
    the steps beside its own as well, but leaves them to the others to keep.
    """

    def __init__(self, solver: Solver, shard: Shard | None = None) -> None:
        axes = solver.scenarios.axes
        self._axis = next(k for k, axis in enumerate(axes) if axis.refinement is not None)
        axis = axes[self._axis]
        assert axis.refinement is not None
        self.refinement = axis.refinement
        self._solver = solver
        self._shape = solver.scenarios.shape
        self._speeds = np.array(axis.values)
        self._step = self.refinement.per_step
        self._columns = _columns(solver, self.refinement.channels)
        size = len(self._speeds)
        self._cells = (size - 1) // self._step
        # Scenarios with the velocity first: (speeds, others); the peaks: (channels, speeds, others).
        grid = np.arange(len(solver.scenarios)).reshape(self._shape)
        self._index = np.moveaxis(grid, self._axis, 0).reshape(size, -1)
        self._peaks = np.full((len(self._columns), *self._index.shape), np.nan)
        self._known = np.zeros(size, dtype=bool)
        self._mine = self._cells_of(shard)
        cell = np.minimum(np.arange(size) // self._step, self._cells - 1)
        self.own = self._of_speeds(self._mine[cell])

    def _of_speeds(self, speeds: Mask) -> Mask:
        """The scenarios (n,) at some speeds."""
        mask = np.zeros(self._index.size, dtype=bool)
        mask[self._index[speeds]] = True
        return mask

    def _cells_of(self, shard: Shard | None) -> Mask:
        """The steps of the axis that are a shard's: neighbours, so many that all shards cost alike."""
        if shard is None:
            return np.ones(self._cells, dtype=bool)
        ends = self._index[:: self._step]
        costs = costs_of(self._solver.scenarios, ends.ravel(), 0, None)
        steps = np.asarray(costs.steps[ends].sum(axis=1)[:-1], dtype=np.int64)
        before = np.cumsum(steps) - steps
        place = shard.of * (2 * before + steps) // max(2 * int(np.sum(steps)), 1)
        return np.asarray(np.minimum(place, shard.of - 1) + 1 == shard.number)

    def first(self) -> Mask:
        """The scenarios (n,) of the first round."""
        speeds = np.zeros(len(self._speeds), dtype=bool)
        for cell in np.flatnonzero(self._mine).tolist():
            last = min(cell + 2, self._cells)
            speeds[max(cell - 1, 0) * self._step : last * self._step + 1 : self._step] = True
        inside = np.repeat(self._mine, self._step)
        for value in self._resonances():
            nearest = round(float((value - self._speeds[0]) / (self._speeds[1] - self._speeds[0])))
            if 0 <= nearest < len(inside) and inside[nearest]:
                speeds[nearest] = True
        self._known |= speeds
        return self._of_speeds(speeds)

    def _resonances(self) -> list[float]:
        """Speeds of resonance of all trains and bridges of the grid, in it."""
        found: set[float] = set()
        seen: set[tuple[float, ...]] = set()
        for index in self._index[0].tolist():
            key = self._solver.scenarios.model_key(index)
            if key not in seen:
                seen.add(key)
                found |= {speed for *_, speed in resonant_speeds(self._solver.scenarios.case_of(index))}
        return sorted(found)

    def learn(self, result: BatchResult) -> None:
        """Takes in what was solved."""
        done = result.status == DONE
        self.learn_peaks(result.indices[done], result.tables["peak"][done][:, self._columns])

    def learn_peaks(self, indices: NDArray[np.int64], peaks: Array) -> None:
        """Takes in the peaks (scenarios, channels) of scenarios that were solved before."""
        place = np.unravel_index(indices, self._shape)
        others = [place[k] for k in range(len(place)) if k != self._axis]
        sizes = [self._shape[k] for k in range(len(place)) if k != self._axis]
        other = np.ravel_multi_index(others, sizes) if others else np.zeros(len(indices), dtype=np.int64)
        self._peaks[:, place[self._axis], other] = peaks.T

    @property
    def columns(self) -> list[int]:
        """The channels that decide, by their place in the tables."""
        return self._columns

    def more(self) -> Mask:
        """The scenarios (n,) of the next round: none once every peak is settled."""
        speeds = np.zeros(len(self._speeds), dtype=bool)
        for cell in np.flatnonzero(self._mine).tolist():
            speeds[self._between(cell)] = True
        self._known |= speeds
        return self._of_speeds(speeds)

    def _between(self, cell: int) -> list[int]:
        """Speeds to come into one step of the axis."""
        a, b = cell * self._step, (cell + 1) * self._step
        before, behind = max(a - self._step, 0), min(b + self._step, len(self._speeds) - 1)
        around = np.fmax.reduce(self._peaks[:, [before, a, b, behind]], axis=1)
        places = [a, *(a + 1 + np.flatnonzero(self._known[a + 1 : b])).tolist(), b]
        bent: set[tuple[int, int]] = set()
        if len(places) == 2:
            # Nothing in between yet: the ends with the next steps' other ends.
            if before < a and self._bends(before, a, b, around):
                bent.add((a, b))
            if b < behind and self._bends(a, b, behind, around):
                bent.add((a, b))
        for left, middle, right in zip(places, places[1:], places[2:], strict=False):
            if self._bends(left, middle, right, around):
                bent |= {(left, middle), (middle, right)}
        return [(left + right) // 2 for left, right in bent if right - left > 1]

    def _bends(self, left: int, middle: int, right: int, around: Array) -> bool:
        """Whether any channel of any line is off the straight line between two speeds at a third.

        It may be off by the tolerance, relative to the largest value `around` (channels, others) and here;
        by more where it is below the line, a dip between peaks.
        """
        share = (middle - left) / (right - left)
        low, mid, high = (self._peaks[:, place] for place in (left, middle, right))
        off = mid - ((1 - share) * low + share * high)
        size = self.refinement.tolerance * np.fmax(np.fmax(np.fmax(low, mid), high), around)
        # A scenario that failed is NaN and bends nothing.
        with np.errstate(invalid="ignore"):
            return bool(np.any((off > size) | (off < -_IN_DIPS * size)))


def refiner_of(solver: object, shard: Shard | None = None) -> Refiner | None:
    """The refiner of a case, where its velocity is refined."""
    if not isinstance(solver, Solver):
        return None
    refined = any(axis.refinement is not None for axis in solver.scenarios.axes)
    return Refiner(solver, shard) if refined else None


def _columns(solver: Solver, names: tuple[str, ...] | None) -> list[int]:
    """The places of the channels that decide in the tables.  Raises UserError for an unknown one."""
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
            raise UserError(f"sweep.velocity.channels: expected some of {', '.join(tables)}; got {name}")
    return [tables.index(name) for name in names]
