"""Files that hold results of some cases of a grid: a part of a running sweep, or a results file.

Both answer the same questions, so that reading, resuming and merging are one thing.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import Protocol

import h5py
import numpy as np
from numpy.typing import NDArray

from tbi_cli.printable import one_line
from tbi_cli.store import safe
from tbi_cli.store.errors import StoreError
from tbi_cli.store.layout import (
    CONVERGED,
    DAF,
    FORMAT,
    FORMAT_VERSION,
    NAME_LISTS,
    STUDIES_FORMAT,
    TOTALS,
    Dim,
    Layout,
    Variable,
)
from tbi_cli.store.records import DONE, FAILED, History


class Source(Protocol):
    """What a file of results answers.  Rows are the cases that it holds, n of them."""

    path: Path
    indices: NDArray[np.int64]  # (n,) flat indices in the whole grid
    status: NDArray[np.int8]  # (n,) 1 or 2
    solve_seconds: float
    case_steps: int

    @property
    def messages(self) -> Mapping[int, str]:
        """Why cases failed, by flat index."""

    def tables(self, groups: Sequence[str]) -> dict[str, NDArray[np.float64]]:
        """All variables of some table groups, each (n, number of variables)."""

    def column(self, group: str, column: int) -> NDArray[np.float64]:
        """One variable of a table group, (n,)."""

    def history_indices(self) -> set[int]:
        """The flat indices of the cases whose history is here."""

    def history(self, index: int, rows: Sequence[int] | None = None) -> History:
        """The history of one case; ``rows`` picks channels by their place in the layout."""

    def close(self) -> None:
        """Close the file; the next question opens it again."""


class SourceFile:
    """A file, or one study of it, that is opened when it is asked something."""

    def __init__(self, path: Path, layout: Layout, study: str = "") -> None:
        self.path = path
        self.layout = layout
        self.study = study
        self._open: h5py.File | None = None

    @property
    def file(self) -> h5py.Group:
        """The root of the file, or the group of the study."""
        if self._open is None:
            self._open = safe.open_h5(self.path)
        return _study_group(self._open, self.path, self.study)

    def close(self) -> None:
        if self._open is not None:
            self._open.close()
            self._open = None

    def group(self, *names: str) -> h5py.Group:
        group: h5py.Group = self.file
        for name in names:
            child = safe.child_group(group, name)
            if child is None:
                raise StoreError(f"{self.path}: the group /{'/'.join(names)} is missing")
            group = child
        return group


class ResultsSource(SourceFile):
    """A results file, or one study of it.  Raises `StoreError` if it is none, or not as it should be."""

    def __init__(self, path: Path, study: str = "") -> None:
        super().__init__(path, read_layout(path, study), study)
        with safe.reading(path):
            self._read_head()

    def _read_head(self) -> None:
        path, shape = self.path, self.layout.shape
        status = safe.read_numbers(self.file, "status", shape).ravel()
        if not np.isin(status, (0, DONE, FAILED)).all():
            raise StoreError(f"{path}: /status holds a number other than 0, 1 and 2")
        self.indices = np.flatnonzero(status)
        self.status = status[self.indices].astype(np.int8)
        #: Cases (flat indices) at which a refined sweep did not reach its tolerance; None of any other.
        self.unsettled: NDArray[np.int64] | None = None
        if CONVERGED in safe.child_names(self.file):
            converged = safe.read_numbers(self.file, CONVERGED, shape).ravel()
            if not np.isin(converged, (0, 1)).all():
                raise StoreError(f"{path}: /{CONVERGED} holds a number other than 0 and 1")
            self.unsettled = np.flatnonzero((converged == 0) & (status == DONE))
        attributes = safe.read_attributes(self.file)
        self.solve_seconds = float(_number(attributes.get("solve_seconds")))
        self.case_steps = int(_number(attributes.get("case_steps")))

    @cached_property
    def messages(self) -> Mapping[int, str]:
        failed = self.indices[self.status == FAILED]
        if not len(failed):
            return {}
        texts = safe.read_texts(self.file, "message", self.layout.shape).ravel()
        return {int(i): str(texts[i]) for i in failed}

    def look(self) -> None:
        """Open every variable, and read the first of each table; raises `StoreError` for the first fault."""
        for group in self.layout.groups:
            for variable in self.layout.columns(group):
                safe.number_dataset(self.group(group), variable.name, self.layout.shape)
            if self.layout.columns(group):
                self.column(group, 0)

    def column(self, group: str, column: int) -> NDArray[np.float64]:
        variable = self.layout.columns(group)[column]
        return safe.read_numbers(self.group(group), variable.name, self.layout.shape).ravel()[self.indices]

    def tables(self, groups: Sequence[str]) -> dict[str, NDArray[np.float64]]:
        found = {}
        for group in groups:
            found[group] = np.empty((len(self.indices), len(self.layout.columns(group))))
            for i in range(found[group].shape[1]):
                found[group][:, i] = self.column(group, i)
        return found

    def history_indices(self) -> set[int]:
        return self._history_indices

    @cached_property
    def _history_indices(self) -> set[int]:
        group = safe.child_group(self.file, "histories")
        return set() if group is None else {i for i in _indices(group) if i < self.layout.size}

    def history(self, index: int, rows: Sequence[int] | None = None) -> History:
        group = self.group("histories", str(index))
        time = safe.read_numbers(group, "time")
        channels = self.layout.history_channels
        names = [channels[row].name for row in (range(len(channels)) if rows is None else rows)]
        values = np.empty((len(names), len(time)))
        for row, name in zip(values, names, strict=True):
            row[:] = safe.read_numbers(group, name, time.shape)
        return History(time, values)


def _number(value: str | int | float | None) -> float:
    return value if isinstance(value, int | float) and np.isfinite(value) else 0


def _study_group(file: h5py.File, path: Path, study: str) -> h5py.Group:
    group = safe.child_group(file, study) if study else file
    if group is None:
        raise StoreError(f"{path}: holds no study {study}")
    return group


def read_layout(path: Path, study: str = "") -> Layout:
    """The layout of the results file ``path``, or of one study of it; raises `StoreError`."""
    with safe.open_h5(path) as opened, safe.reading(path):
        file = _study_group(opened, path, study)
        attributes = safe.read_attributes(file)
        found = attributes.pop("format", None)
        if found == STUDIES_FORMAT:
            studies = one_line(str(attributes.get("studies", "")))[:400]
            raise StoreError(f"{path}: holds several studies, of which one is to be named: {studies}")
        if found != FORMAT:
            raise StoreError(f"{path}: is an HDF5 file, but not one that tbi wrote")
        version = attributes.pop("format_version", None)
        if version != FORMAT_VERSION:
            found = f"has the format version {version!r:.40}"
            raise StoreError(f"{path}: {found}, this tbi reads {FORMAT_VERSION}")
        for total in TOTALS:
            attributes.pop(total, None)
        names = {key: _names(path, attributes.pop(key, "")) for key in NAME_LISTS}
        if not set(names["daf"]) <= set(DAF):
            raise StoreError(f"{path}: names unknown amplification factors")
        dims = _dims(file, names["dimensions"])
        channels = _variables(safe.child_group(file, "peak"), names["channels"])
        histories = safe.child_group(file, "histories")
        first = None if histories is None else next(_indices(histories), None)
        history = None if histories is None or first is None else safe.child_group(histories, str(first))
        history_channels = _variables(history, names["history_channels"])
        layout = Layout(dims, channels, history_channels, tuple(names["daf"]), attributes)
        try:
            layout.check()
        except StoreError as error:
            raise StoreError(f"{path}: {error}") from error
        return layout


def _indices(histories: h5py.Group) -> Iterator[int]:
    """The flat indices that name the groups of histories; other names are passed over."""
    for name in safe.child_names(histories):
        if name.isascii() and name.isdecimal() and len(name) < 19 and name == str(int(name)):
            yield int(name)


def _names(path: str | Path, listed: str | float) -> list[str]:
    """The names in an attribute that lists them; raises `StoreError` for what would garble a terminal."""
    names = str(listed).split()
    if not all(name.isprintable() for name in names):
        raise StoreError(f"{path}: names a variable by control characters")
    return names


def _dims(file: h5py.Group, names: Sequence[str], shape: tuple[int, ...] | None = None) -> tuple[Dim, ...]:
    """The dimensions of those names, with what moves together along each; or such members, of that shape."""
    found = []
    for v in _variables(file, names):
        values = safe.read_numbers(file, v.name, shape)
        if not np.isfinite(values).all():
            raise StoreError(f"{file.file.filename}: /{v.name} holds values that are not finite")
        attributes = {} if shape else safe.read_attributes(safe.child_dataset(file, v.name))
        members = _dims(file, _names(file.file.filename, attributes.get("members", "")), values.shape)
        found.append(Dim(v.name, values, v.units, v.long_name, members))
    return tuple(found)


def _variables(group: h5py.Group | None, names: Sequence[str]) -> tuple[Variable, ...]:
    """The variables of those names; without units and long name where the group or variable is missing."""
    found = []
    for name in names:
        dataset = None if group is None else safe.child_dataset(group, name)
        attributes = {} if dataset is None else safe.read_attributes(dataset)
        units, long_name = (
            one_line(str(attributes.get(key, default)))
            for key, default in (("units", ""), ("long_name", name))
        )
        found.append(Variable(name, units, long_name))
    return tuple(found)
