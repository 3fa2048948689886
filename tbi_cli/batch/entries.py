"""Sparse matrices as lists of their entries."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class Entries:
    """The entries of a sparse matrix of so many columns, row by row."""

    row: NDArray[np.int64]
    column: NDArray[np.int64]
    value: NDArray[np.float64]
    columns: int

    @classmethod
    def of(cls, matrix: NDArray[np.float64]) -> Entries:
        """Those of a full matrix."""
        row, column = np.nonzero(matrix)
        return cls(row, column, matrix[row, column], matrix.shape[1])

    def moved(self, rows: int, columns: int, of: int) -> Entries:
        """The same entries further down and to the right, in a matrix of `of` columns."""
        return Entries(self.row + rows, self.column + columns, self.value, of)

    @staticmethod
    def together(parts: Sequence[Entries]) -> Entries:
        """All entries of matrices that share none."""
        row, column, value = (
            np.concatenate([getattr(p, k) for p in parts]) for k in ("row", "column", "value")
        )
        order = np.argsort(row * parts[0].columns + column)
        return Entries(row[order], column[order], value[order], parts[0].columns)

    @staticmethod
    def common(matrices: Sequence[Entries]) -> tuple[Entries, NDArray[np.float64]]:
        """The places where any of some matrices has an entry, and the values there (matrices, entries)."""
        first = matrices[0]
        keys = [m.row * m.columns + m.column for m in matrices]
        if all(np.array_equal(key, keys[0]) for key in keys):
            return first, np.stack([m.value for m in matrices])
        places = np.unique(np.concatenate(keys))
        values = np.zeros((len(matrices), len(places)))
        for into, key, m in zip(values, keys, matrices, strict=True):
            into[np.searchsorted(places, key)] = m.value
        row, column = np.divmod(places, first.columns)
        return Entries(row, column, values[0], first.columns), values
