"""The grid of a refined run without the speeds at which nothing was solved."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from tbi_cli.store.errors import StoreError
from tbi_cli.store.layout import Dim, Layout
from tbi_cli.store.records import History
from tbi_cli.store.sources import Source

#: The root attribute that names the axis of which only some values are solved, while more may come.
REFINED = "refined"


def refined_axis(layout: Layout) -> int | None:
    """Which of the axes may still get more values; None if none may."""
    name = layout.attributes.get(REFINED)
    return next((k for k, dim in enumerate(layout.dims) if dim.name == name), None)


def settled(layout: Layout) -> Layout:
    """The layout of a whole run that is finished, to which no more speeds will come; of a shard, itself."""
    if layout.attributes.get("shard"):
        return layout
    return replace(layout, attributes={k: v for k, v in layout.attributes.items() if k != REFINED})


def numbers_in(dims: Sequence[Dim], whole: Sequence[NDArray[np.float64]]) -> NDArray[np.int64]:
    """The flat index in a whole grid of each case of a grid that has some of its values.

    An axis that has all of them may have equal ones, as drawn samples do.  Raises StoreError where it has a
    value of its own.
    """
    places = []
    for dim, values in zip(dims, whole, strict=True):
        if np.array_equal(dim.values, values):
            places.append(np.arange(len(values)))
            continue
        order = np.argsort(values, kind="stable")
        place = order[np.minimum(np.searchsorted(values, dim.values, sorter=order), len(values) - 1)]
        if not np.array_equal(values[place], dim.values):
            raise StoreError(f"the axis {dim.name} has other values")
        places.append(place)
    shape = tuple(len(values) for values in whole)
    flat = np.ravel_multi_index(np.ix_(*places), shape) if places else np.zeros(1, dtype=np.int64)
    return np.asarray(flat, dtype=np.int64).ravel()


def solved_only(
    layout: Layout, sources: Sequence[Source], unsettled: NDArray[np.int64] | None
) -> tuple[Layout, list[Source], NDArray[np.int64] | None]:
    """Layout, sources and unsettled cases of a refined grid with the speeds alone that were solved.

    A grid of which nothing is solved yet keeps the two ends of the axis; one that is not refined, all.
    """
    axis = refined_axis(layout)
    if axis is None:
        return layout, list(sources), unsettled
    size, behind = layout.shape[axis], int(np.prod(layout.shape[axis + 1 :]))
    kept = np.zeros(size, dtype=bool)
    for source in sources:
        kept[source.indices // behind % size] = True
    if not kept.any():
        kept[[0, -1]] = True
    smaller = with_values(layout, axis, layout.dims[axis].values[kept])
    # Cases of the speeds that are left out have no number.
    numbers = np.full(layout.size, -1, dtype=np.int64)
    numbers[numbers_in(smaller.dims, [dim.values for dim in layout.dims])] = np.arange(smaller.size)
    if unsettled is not None:
        unsettled = numbers[unsettled]
        unsettled = unsettled[unsettled >= 0]
    return smaller, [MovedSource(source, numbers) for source in sources], unsettled


def with_values(layout: Layout, axis: int, values: NDArray[np.float64]) -> Layout:
    """The layout with other values on one axis."""
    dims = list(layout.dims)
    dims[axis] = replace(dims[axis], values=values)
    return replace(layout, dims=tuple(dims))


class MovedSource:
    """A source of results whose cases have other flat indices: ``numbers`` gives the new for the old."""

    def __init__(self, source: Source, numbers: NDArray[np.int64]) -> None:
        self._source, self._numbers = source, numbers
        self.path = source.path
        self.indices: NDArray[np.int64] = numbers[source.indices]
        self.status = source.status
        self.solve_seconds, self.case_steps = source.solve_seconds, source.case_steps

    @property
    def messages(self) -> Mapping[int, str]:
        """Why cases failed, by flat index."""
        return {int(self._numbers[index]): text for index, text in self._source.messages.items()}

    def tables(self, groups: Sequence[str]) -> dict[str, NDArray[np.float64]]:
        """All variables of some table groups, each (n, number of variables)."""
        return self._source.tables(groups)

    def column(self, group: str, column: int) -> NDArray[np.float64]:
        """One variable of a table group, (n,)."""
        return self._source.column(group, column)

    def history_indices(self) -> set[int]:
        """The flat indices of the cases whose history is here."""
        return {int(self._numbers[index]) for index in self._source.history_indices()}

    def history(self, index: int, rows: Sequence[int] | None = None) -> History:
        """The history of one case."""
        old = self._source.indices[self.indices == index]
        return self._source.history(int(old[0]), rows)

    def close(self) -> None:
        """Closes the file."""
        self._source.close()
