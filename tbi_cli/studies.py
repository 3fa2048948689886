"""Several grids solved as one run: their scenarios stand one behind the other."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from tbi_cli.case import Case
from tbi_cli.solve import Solver
from tbi_cli.store.records import BatchResult


class StudiesSolver:
    """Solves scenarios of the studies of a case.

    `parts` are the solvers of the studies by name, `starts` the flat index of the first scenario of each.
    """

    def __init__(self, case: Case, stopped: Callable[[], bool] = lambda: False) -> None:
        self.case = case
        self.parts = {name: Solver(study, stopped) for name, study in case.studies.items()}
        sizes = [len(part.scenarios) for part in self.parts.values()]
        self.starts = dict(zip(self.parts, np.cumsum([0, *sizes[:-1]]).tolist(), strict=True))

    def _study(self, index: int) -> str:
        return next(name for name in reversed(self.starts) if self.starts[name] <= index)

    def describe(self, index: int) -> str:
        """A scenario in words, for messages."""
        name = self._study(index)
        return f"study {name}, {self.parts[name].describe(index - self.starts[name])}"

    def solve(self, indices: Sequence[int] | NDArray[np.int64]) -> BatchResult | None:
        """Solves scenarios of one study; see `Solver.solve`."""
        name = self._study(int(indices[0]))
        start = self.starts[name]
        result = self.parts[name].solve(np.asarray(indices, dtype=np.int64) - start)
        return None if result is None else result.moved(start)


AnySolver = Solver | StudiesSolver


def solver_of(case: Case, stopped: Callable[[], bool] = lambda: False) -> AnySolver:
    """The solver of a case, be it one grid or a union of several."""
    return StudiesSolver(case, stopped) if case.studies else Solver(case, stopped)


def kernels_of(solver: AnySolver) -> list[str]:
    """The kinds of kernels that a case needs."""
    return sorted({part.kernel for part in solver.parts.values()})
