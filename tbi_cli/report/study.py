"""A results file as a study: its axes, and an array for whatever is drawn of it.

Here every axis rises, whatever the order of its values in the case and in the file, so that neighbours on an
axis are neighbours in value for all that is made of a study.  The order of the file is that in which curves
and panels stand beside each other.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tbi_cli.case import SHORT_NAMES, Axis, Case, Damping
from tbi_cli.case.sweep import SAMPLE
from tbi_cli.report.stored_case import stored_case
from tbi_cli.report.words import clean
from tbi_cli.store import DONE, FAILED, Dim, History, Results, Variable, open_results, studies_of
from tbi_cli.store.picked import refined_axis

Array = NDArray[np.float64]
Place = Mapping[str, int]  # axis name -> index on it


@dataclass(frozen=True, eq=False)
class StudyAxis:
    """A swept axis: its dimension, the values rising, and the keys of the case that it sets.

    `order` (n,) tells where in the file each value stands.
    """

    dim: Dim
    paths: frozenset[str]
    axis: Axis | None
    order: NDArray[np.intp]
    #: Whether the axis may still grow values by itself, so that not all that it has need be solved.
    refined: bool = False

    @property
    def name(self) -> str:
        """The name of the dimension."""
        return self.dim.name

    @property
    def values(self) -> Array:
        """The coordinate values in SI, rising."""
        return self.dim.values

    @property
    def lead(self) -> Dim:
        """The dimension whose values name the places: of zipped axes the first, if they are all different."""
        zipped = self.dim.members and self.dim.name != SAMPLE
        first = self.dim.members[0] if zipped else self.dim
        return first if len(np.unique(first.values)) == len(first.values) else self.dim

    @property
    def varies(self) -> bool:
        """Whether there is more than one value."""
        return len(self.dim.values) > 1

    def nearest(self, value: float) -> int:
        """The index of the value nearest to `value`."""
        return int(np.argmin(np.abs(self.values - value)))

    def holds(self, value: float) -> bool:
        """Whether `value` is one of the axis, to seven digits."""
        return bool(np.isclose(self.values[self.nearest(value)], value, rtol=1e-7, atol=0))


class Study:
    """One results file, opened, with the case that it came from (None if that cannot be read).

    `name` tells it from the other studies of a report and is fit for file names.
    """

    def __init__(self, results: Results, name: str) -> None:
        self.results = results
        self.name = name
        self.case: Case | None = stored_case(results.case_yaml)
        swept = {axis.name: axis for axis in self.case.axes} if self.case else {}
        refined = refined_axis(results.layout)
        self.axes = tuple(
            _study_axis(dim, swept.get(dim.name), k == refined) for k, dim in enumerate(results.dims)
        )
        self.table = lru_cache(maxsize=64)(self._table)

    @property
    def title(self) -> str:
        """The title of the case, or the file's name."""
        return clean(str(self.results.attributes.get("title") or self.results.path.name))

    @property
    def varied(self) -> tuple[StudyAxis, ...]:
        """The axes with more than one value."""
        return tuple(axis for axis in self.axes if axis.varies)

    def _table(self, table: str, channel: str) -> Array:
        """A variable of a table over all axes.  Raises StoreError like `Results.table`."""
        return np.asarray(self._risen(self.results.table(table, channel)), dtype=np.float64)

    def _risen(self, values: NDArray[Any]) -> NDArray[Any]:
        """An array over the axes as the file has them, over the axes as they are here."""
        orders = [axis.order for axis in self.axes]
        if all(np.all(np.diff(order) > 0) for order in orders):
            return values
        return values[np.ix_(*orders)]

    @cached_property
    def status(self) -> NDArray[np.int8]:
        """0 to do, 1 done, 2 failed, of the grid's shape."""
        return self._risen(self.results.status)

    @property
    def to_do(self) -> int:
        """How many scenarios are not solved yet."""
        return int(np.sum((self.status != DONE) & (self.status != FAILED)))

    @property
    def failed(self) -> int:
        """How many scenarios failed."""
        return int(np.sum(self.status == FAILED))

    def axis(self, key: str) -> StudyAxis | None:
        """The axis that sets what `key` sets (a short name or a dotted key), or that has this name."""
        paths = frozenset(SHORT_NAMES.get(key, (key,)))
        return next((axis for axis in self.axes if axis.paths == paths or axis.name == key), None)

    @cached_property
    def base(self) -> dict[str, int]:
        """Where the base case stands on each axis: the nearest value to that of the case itself."""
        return {axis.name: axis.nearest(self._base_value(axis)) for axis in self.axes}

    def _base_value(self, axis: StudyAxis) -> float:
        member = axis.axis.members[0] if axis.axis and axis.axis.members else axis.axis
        if self.case is None or member is None or not member.chains:
            return float(axis.values[0])
        value: object = self.case
        for word in member.chains[0]:
            value = value[word] if isinstance(word, int) else getattr(value, word)  # type: ignore[index]
        if not isinstance(value, int | float):
            return float(axis.values[0])
        if axis.axis is not member:
            return float(np.argmin(np.abs(np.array(member.values) - value)))
        return float(value)

    def value(self, key: str, place: Place) -> float | None:
        """What `key` (a short name or dotted key of a number) is at a place of the grid."""
        axis = self.axis(key)
        if axis is not None:
            return float(axis.values[place.get(axis.name, self.base[axis.name])])
        found: object = self.case
        for word in SHORT_NAMES.get(key, (key,))[0].split("."):
            found = getattr(found, word, None)
        found = found.coefficient if isinstance(found, Damping) else found
        return float(found) if isinstance(found, int | float) else None

    def case_at(self, place: Place) -> Case | None:
        """The single case at a place of the grid; axes left out stand at the base case."""
        if self.case is None:
            return None
        at = {**self.base, **place}
        swept = {axis.name: axis for axis in self.case.axes}
        return self.case.at({a.name: float(a.values[at[a.name]]) for a in self.axes if a.name in swept})

    def index(self, place: Place) -> int:
        """The flat index in the file of a place of the grid."""
        at = {**self.base, **place}
        in_file = [axis.order[at[axis.name]] for axis in self.axes]
        return int(np.ravel_multi_index(in_file, self.results.shape))

    def has(self, table: str, channel: str) -> bool:
        """Whether the file has this variable; `table` may be "history"."""
        return self.variable(table, channel) is not None

    def variable(self, table: str, channel: str) -> Variable | None:
        """Name, units and long name of a variable of a table, or of a channel of the histories."""
        if table == "history":
            variables: Sequence[Variable] = self.results.history_channels
        elif table in self.results.layout.groups:
            variables = self.results.layout.columns(table)
        else:
            return None
        return next((variable for variable in variables if variable.name == channel), None)

    def along(self, table: str, channel: str, axes: Sequence[StudyAxis], place: Place) -> Array:
        """A variable over some axes, in their order, the others at `place` or at the base case."""
        values = self.table(table, channel)
        names = [axis.name for axis in axes]
        at = {**self.base, **place}
        picked = values[tuple(slice(None) if a.name in names else at[a.name] for a in self.axes)]
        order = [axis.name for axis in self.axes if axis.name in names]
        return np.asarray(np.transpose(picked, [order.index(name) for name in names]), dtype=np.float64)

    @cached_property
    def histories(self) -> frozenset[int]:
        """The flat indices in the file of the scenarios that have a history."""
        return frozenset(self.results.history_indices())

    def history(self, place: Place, channels: Sequence[str]) -> History | None:
        """The histories of these channels at a place; None if that scenario has none."""
        index = self.index(place)
        return self.results.history(index, list(channels)) if index in self.histories else None


def open_studies(paths: Sequence[Path]) -> list[Study]:
    """The studies in the results files `paths`.  Raises StoreError, which tells what is wrong with which."""
    studies: list[Study] = []
    parts = [(path, part) for path in paths for part in studies_of(path) or ("",)]
    for path, part in parts:
        results = open_results(path, study=part)
        taken = [study.name for study in studies]
        stem = re.sub(r"[^A-Za-z0-9._-]+", "-", path.name.removesuffix(".h5")).strip("-.") or "results"
        stem = f"{stem}-{part}" if part else stem
        name = next(n for n in (stem, *(f"{stem}-{k}" for k in range(2, len(taken) + 2))) if n not in taken)
        studies.append(Study(results, name))
    return studies


def _study_axis(dim: Dim, axis: Axis | None, refined: bool) -> StudyAxis:
    order = np.argsort(dim.values, kind="stable")
    members = tuple(replace(member, values=member.values[order]) for member in dim.members)
    dim = replace(dim, values=dim.values[order], members=members)
    if axis is not None and len(axis) == len(dim.values):
        return StudyAxis(dim, frozenset(axis.paths), axis, order, refined)
    return StudyAxis(dim, frozenset(SHORT_NAMES.get(dim.name, (dim.name,))), None, order, refined)
