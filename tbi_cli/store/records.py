"""What a solved batch hands to the store."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

TO_DO, DONE, FAILED = 0, 1, 2


@dataclass(frozen=True)
class History:
    """The sampled motion of one case.

    ``time`` is (nt,) in s; ``values`` is (number of stored channels, nt), C-contiguous, rows in the order of
    the layout's history channels and in their units.
    """

    time: NDArray[np.float64]
    values: NDArray[np.float64]


@dataclass(frozen=True)
class BatchResult:
    """The responses of n cases, in any order.

    ``indices`` are their flat indices in the whole grid (row-major, from 0), ``status`` is 1 (done) or 2
    (failed, see ``messages``).  ``tables`` holds, for each of peak, max, min, rms and time_of_peak, an
    (n, number of table channels) array; ``daf`` an (n,) array for each dynamic amplification factor; NaN
    where a case failed.  ``solve_seconds`` and ``case_steps`` (n,) are what the solution cost.
    ``histories`` maps flat indices to histories, where they were asked for.
    """

    indices: NDArray[np.int64]
    status: NDArray[np.int8]
    messages: Sequence[str]
    tables: Mapping[str, NDArray[np.float64]]
    daf: Mapping[str, NDArray[np.float64]]
    solve_seconds: NDArray[np.float64]
    case_steps: NDArray[np.int64]
    histories: Mapping[int, History] = field(default_factory=dict)

    def picked(self, which: NDArray[np.bool_]) -> BatchResult:
        """Some of the cases alone."""
        kept = {int(index) for index in self.indices[which]}
        return BatchResult(
            indices=self.indices[which],
            status=self.status[which],
            messages=[text for text, keep in zip(self.messages, which, strict=True) if keep],
            tables={name: values[which] for name, values in self.tables.items()},
            daf={name: values[which] for name, values in self.daf.items()},
            solve_seconds=self.solve_seconds[which],
            case_steps=self.case_steps[which],
            histories={index: h for index, h in self.histories.items() if index in kept},
        )

    def moved(self, by: int) -> BatchResult:
        """The same with flat indices that are larger by so many."""
        histories = {index + by: history for index, history in self.histories.items()}
        return replace(self, indices=self.indices + by, histories=histories)
