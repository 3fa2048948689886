"""Which scenarios of a run are solved when: those of a refined grid in rounds, all others in the first."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from tbi_cli.plan import dealt
from tbi_cli.refine import Refiner, refiner_of
from tbi_cli.shards import Shard
from tbi_cli.store import BatchResult, ResultsStore
from tbi_cli.studies import AnySolver

Mask = NDArray[np.bool_]


class Rounds:
    """The rounds of a run, or of one shard of it, over all its grids, which stand one behind the other.

    `own` (n,) are the scenarios that this run keeps; a shard of a refined grid solves a few more, which it
    leaves to the others to keep.  Raises RunError where a scenario's step cannot be stable.
    """

    def __init__(self, solver: AnySolver, shard: Shard | None = None) -> None:
        self._refiners: dict[str, Refiner] = {}
        for name, part in solver.parts.items():
            refiner = refiner_of(part, shard)
            if refiner is not None:
                self._refiners[name] = refiner
        grids = {name: part.scenarios for name, part in solver.parts.items() if name not in self._refiners}
        owners = {} if shard is None else dealt(grids, shard.of)
        self._others: dict[str, Mask] = {}
        for name, scenarios in grids.items():
            whole = np.ones(len(scenarios), dtype=bool)
            self._others[name] = whole if shard is None else owners[name] == shard.number
        self._ends = dict(
            zip(solver.parts, np.cumsum([len(part.scenarios) for part in solver.parts.values()]), strict=True)
        )
        self.own = self._joined(lambda refiner: refiner.own, self._others)

    def _joined(self, ask: Callable[[Refiner], Mask], others: Mapping[str, Mask]) -> Mask:
        return np.concatenate(
            [ask(self._refiners[name]) if name in self._refiners else others[name] for name in self._ends]
        )

    def first(self) -> Mask:
        """The scenarios (n,) of the first round."""
        return self._joined(Refiner.first, self._others)

    def more(self) -> Mask:
        """The scenarios (n,) of the next round: none once every peak is settled."""
        return self._joined(
            Refiner.more, {name: np.zeros(len(own), dtype=bool) for name, own in self._others.items()}
        )

    def learn(self, result: BatchResult) -> None:
        """Takes in what was solved, all of one grid."""
        if not self._refiners:
            return
        name, end = next((name, end) for name, end in self._ends.items() if result.indices[0] < end)
        if name in self._refiners:
            refiner = self._refiners[name]
            refiner.learn(result.moved(len(refiner.own) - int(end)))

    def learn_stored(self, stores: Mapping[str, ResultsStore]) -> None:
        """Takes in what was solved before."""
        for name, refiner in self._refiners.items():
            if stores[name].done().any():
                refiner.learn_peaks(*stores[name].solved_peaks(refiner.columns))

    def note_unsettled(self, stores: Mapping[str, ResultsStore]) -> None:
        """Keeps in the stores of refined grids which of their peaks may still change."""
        for name, refiner in self._refiners.items():
            stores[name].note_unsettled(np.flatnonzero(refiner.unsettled()))

    def unsettled(self) -> Mask:
        """The scenarios (n,) with a peak that may still change by more than the tolerance."""
        return self._joined(
            Refiner.unsettled, {name: np.zeros(len(own), dtype=bool) for name, own in self._others.items()}
        )
