"""A grid without the values of one axis at which nothing was solved."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from tbi_cli.store.layout import Layout, Scalar
from tbi_cli.store.records import History
from tbi_cli.store.results import Results
from tbi_cli.store.sources import ResultsSource

#: The root attribute that names the axis of which only some values are solved.
REFINED = "refined"


def settled(layout: Layout, results: Results) -> tuple[Layout, Results | PickedResults]:
    """Layout and results of a refined grid with the speeds that were solved; any other grid as it is.

    A shard keeps all speeds that there may be, so that shards can be put together.
    """
    name = layout.attributes.get(REFINED)
    if not name or layout.attributes.get("shard"):
        return layout, results
    place = _place(layout)
    solved = np.moveaxis(results.status != 0, place, 0).reshape(layout.shape[place], -1).any(axis=1)
    smaller, picked = _cut(layout, solved)
    return smaller, PickedResults(results, smaller, picked)


def _place(layout: Layout) -> int:
    """Which of the axes is the refined one."""
    return [dim.name for dim in layout.dims].index(str(layout.attributes[REFINED]))


def _cut(layout: Layout, kept: NDArray[np.bool_]) -> tuple[Layout, NDArray[np.int64]]:
    """The layout with some values of the refined axis alone, and its cases' flat indices in the whole."""
    place = _place(layout)
    dims = tuple(
        replace(dim, values=dim.values[kept]) if k == place else dim for k, dim in enumerate(layout.dims)
    )
    attributes = {key: value for key, value in layout.attributes.items() if key != REFINED}
    grid = np.arange(layout.size).reshape(layout.shape)
    return replace(layout, dims=dims, attributes=attributes), np.compress(kept, grid, axis=place).ravel()


def is_settled(old: Layout, layout: Layout) -> bool:
    """Whether a file of the layout ``old`` has only the speeds that were solved of the grid ``layout``."""
    return REFINED in layout.attributes and REFINED not in old.attributes


def unsolved(layout: Layout, status: NDArray[np.int8]) -> NDArray[np.bool_]:
    """Which cases of the grid are to do: of a refined axis, only at values that others were solved at."""
    name = layout.attributes.get(REFINED)
    if not name:
        return np.asarray(status == 0)
    place = _place(layout)
    others = tuple(k for k in range(status.ndim) if k != place)
    to_do: NDArray[np.bool_] = (status == 0) & (status != 0).any(axis=others, keepdims=True)
    return to_do


class PickedResults:
    """Some scenarios of other results, by their flat indices there, as a grid of their own."""

    def __init__(self, results: Results, layout: Layout, picked: NDArray[np.int64]) -> None:
        self._results = results
        self._layout = layout
        self._picked = picked
        self._place = {int(index): place for place, index in enumerate(picked)}

    @property
    def attributes(self) -> dict[str, Scalar]:
        """Root attributes."""
        return {key: value for key, value in self._results.attributes.items() if key != REFINED}

    @property
    def status(self) -> NDArray[np.int8]:
        """0 to do, 1 done, 2 failed; of the grid's shape."""
        return np.asarray(self._results.status.ravel()[self._picked].reshape(self._layout.shape))

    @property
    def messages(self) -> Mapping[int, str]:
        """Why cases failed, by flat index."""
        found = self._results.messages.items()
        return {self._place[index]: text for index, text in found if index in self._place}

    def tables(self, groups: Sequence[str]) -> dict[str, NDArray[np.float64]]:
        """Whole table groups: (number of variables, number of cases)."""
        return {name: values[:, self._picked] for name, values in self._results.tables(groups).items()}

    def history_indices(self) -> list[int]:
        """The flat indices of the cases that have a history, in ascending order."""
        return sorted(self._place[i] for i in self._results.history_indices() if i in self._place)

    def history(self, index: int) -> History:
        """The history of a case."""
        return self._results.history(int(self._picked[index]))


class SettledSource:
    """A results file that has only the solved values of a refined axis, as a source of the whole grid."""

    def __init__(self, source: ResultsSource, layout: Layout) -> None:
        place = _place(layout)
        named = [dim.values for dim in source.layout.dims if dim.name == layout.dims[place].name]
        kept = np.isin(layout.dims[place].values, named[0] if named else [])
        #: The layout that the file should have.
        self.layout, self._whole = _cut(layout, kept)
        self._source = source
        self._old = {int(index): k for k, index in enumerate(self._whole)}
        self.path = source.path
        self.indices: NDArray[np.int64] = self._whole[source.indices]
        self.status = source.status
        self.solve_seconds, self.case_steps = source.solve_seconds, source.case_steps

    @property
    def messages(self) -> Mapping[int, str]:
        """Why cases failed, by flat index."""
        return {int(self._whole[index]): text for index, text in self._source.messages.items()}

    def tables(self, groups: Sequence[str]) -> dict[str, NDArray[np.float64]]:
        """All variables of some table groups, each (n, number of variables)."""
        return self._source.tables(groups)

    def column(self, group: str, column: int) -> NDArray[np.float64]:
        """One variable of a table group, (n,)."""
        return self._source.column(group, column)

    def history_indices(self) -> set[int]:
        """The flat indices of the cases whose history is here."""
        return {int(self._whole[index]) for index in self._source.history_indices()}

    def history(self, index: int, rows: Sequence[int] | None = None) -> History:
        """The history of one case."""
        return self._source.history(self._old[index], rows)

    def close(self) -> None:
        """Closes the file."""
        self._source.close()
