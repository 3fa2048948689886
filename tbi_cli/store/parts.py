"""One finished batch as a file of its own: compact, quick to write and to read, and only tbi reads it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tbi_cli.store import safe
from tbi_cli.store.durable import NewFile, new_h5
from tbi_cli.store.errors import StoreError
from tbi_cli.store.layout import Layout
from tbi_cli.store.netcdf import place_numbers
from tbi_cli.store.records import DONE, FAILED, BatchResult, History
from tbi_cli.store.sources import SourceFile

#: The layout of the run that the parts belong to, in the same folder.
LAYOUT_FILE = "layout.json"

#: Which studies a run is of, where it is of several; each has a folder of its own below.
STUDIES_FILE = "studies.json"

#: Which cases of a refined run have a peak that may still change, as of the last round.
UNSETTLED_FILE = "unsettled.json"

_NO_HISTORY = -1
_MOST = 1 << 40  # steps or samples of one case; sums of them stay far below the largest integer
_CASE = np.dtype(
    [("index", "<i8"), ("status", "i1"), ("seconds", "<f8"), ("steps", "<i8"), ("samples", "<i8")]
)


def parts_folder(path: Path, study: str = "") -> Path:
    """Where the parts of the results file ``path``, or of one study of it, are while it is not finished."""
    folder = path.with_name(path.name + ".parts")
    return folder / study if study else folder


def part_name(number: int) -> str:
    """The file name of a part: in order of writing, also when sorted by name up to a million of them."""
    return f"{number:06d}.h5"


def part_number(path: Path) -> int | None:
    """The number in a part's name; None for any other file."""
    return int(path.stem) if path.suffix == ".h5" and path.stem.isdecimal() and path.stem.isascii() else None


def write_part(folder: Path, number: int, run_id: str, layout: Layout, batch: BatchResult) -> Path:
    """Write ``batch`` durably as part ``number`` and return its path.

    Raises `StoreError` if the disk refuses, ValueError if the batch does not fit the layout.
    """
    _check(layout, batch)
    path = folder / part_name(number)
    cases = np.zeros(len(batch.indices), dtype=_CASE)
    cases["index"], cases["status"] = batch.indices, batch.status
    cases["seconds"], cases["steps"] = batch.solve_seconds, batch.case_steps
    stored = [batch.histories.get(index) for index in batch.indices.tolist()]
    cases["samples"] = [_NO_HISTORY if history is None else len(history.time) for history in stored]
    failed = np.flatnonzero(batch.status == FAILED).tolist()
    with new_h5(path, folder, "the cases finished before are safe") as new:
        root = new.file
        root.attrs["run_id"] = np.bytes_(run_id)
        root["cases"] = cases
        root["numbers"] = np.hstack([_table(layout, batch, group) for group in layout.groups])
        if failed:
            root["messages"] = np.array([batch.messages[i].encode() or b" " for i in failed], dtype=np.bytes_)
        histories = [history for history in stored if history is not None]
        if histories:
            _write_histories(new, layout, histories)
    return path


def _write_histories(new: NewFile, layout: Layout, histories: Sequence[History]) -> None:
    """All histories of the batch in one dataset, one after the other, each of all channels."""
    times = np.concatenate([history.time for history in histories])
    new.file["history_times"] = times
    offset = place_numbers(new.file, "history_values", len(times) * len(layout.history_channels))
    for history in histories:
        new.write_at(offset, np.ascontiguousarray(history.values))
        offset += history.values.nbytes
        new.check()


def _table(layout: Layout, batch: BatchResult, group: str) -> NDArray[np.float64]:
    if group != "daf":
        return batch.tables[group]
    return np.column_stack([batch.daf[name] for name in layout.daf] or [np.empty((len(batch.indices), 0))])


def _check(layout: Layout, batch: BatchResult) -> None:
    n = len(batch.indices)
    if n and not (batch.indices.min() >= 0 and batch.indices.max() < layout.size):
        raise ValueError("a flat index lies outside the grid")
    if len(np.unique(batch.indices)) != n or not set(batch.histories) <= set(batch.indices.tolist()):
        raise ValueError("a flat index comes twice in one batch, or a history belongs to no case of it")
    if not np.isin(batch.status, (DONE, FAILED)).all() or len(batch.messages) != n:
        raise ValueError("a batch gives each of its cases status 1 or 2, and a message, empty where done")
    if set(batch.daf) != set(layout.daf):
        raise ValueError(f"amplification factors {sorted(batch.daf)}, the layout has {sorted(layout.daf)}")
    for group in layout.groups:
        shape = (n, len(layout.columns(group)))
        if _table(layout, batch, group).shape != shape:
            raise ValueError(f"table {group} of shape {_table(layout, batch, group).shape}, expected {shape}")
    for index, history in batch.histories.items():
        if history.values.shape != (len(layout.history_channels), len(history.time)):
            raise ValueError(f"history {index} of shape {history.values.shape} does not fit the layout")


class PartSource(SourceFile):
    """A part as a source of results.  Raises `StoreError` if it is damaged."""

    def __init__(self, path: Path, layout: Layout) -> None:
        super().__init__(path, layout)
        with safe.reading(path):
            self._read_head()

    def _read_head(self) -> None:
        root = self.file
        self.run_id = str(safe.read_attributes(root).get("run_id"))
        self._cases = safe.read_records(root, "cases", _CASE)
        self.indices: NDArray[np.int64] = self._cases["index"]
        self.status: NDArray[np.int8] = self._cases["status"]
        self.solve_seconds = float(self._cases["seconds"].sum())
        self.case_steps = int(self._cases["steps"].sum())
        samples, steps, seconds = (self._cases[key] for key in ("samples", "steps", "seconds"))
        sound = (steps >= 0) & (steps <= _MOST) & (samples >= _NO_HISTORY) & (samples <= _MOST)
        if not (sound & np.isfinite(seconds)).all():
            raise StoreError(f"{self.path}: holds a case of impossible length")
        inside = (self.indices >= 0) & (self.indices < self.layout.size)
        if not (inside & np.isin(self.status, (DONE, FAILED))).all():
            raise StoreError(f"{self.path}: holds a case outside the grid or of an unknown status")

    @cached_property
    def messages(self) -> Mapping[int, str]:
        failed = self.indices[self.status == FAILED]
        if not len(failed):
            return {}
        texts = safe.read_texts(self.file, "messages", failed.shape)
        return {int(index): text.strip() for index, text in zip(failed, texts, strict=True)}

    def _columns(self) -> dict[str, slice]:
        """Where the variables of each table group are among all numbers."""
        found, first = {}, 0
        for group in self.layout.groups:
            found[group] = slice(first, first + len(self.layout.columns(group)))
            first = found[group].stop
        return found

    def tables(self, groups: Sequence[str]) -> dict[str, NDArray[np.float64]]:
        columns = self._columns()
        shape = (len(self.indices), max(part.stop for part in columns.values()))
        numbers = safe.read_numbers(self.file, "numbers", shape)
        return {group: numbers[:, columns[group]] for group in groups}

    def look(self) -> None:
        """Read the numbers of the tables; raises `StoreError` for the first fault."""
        self.tables(self.layout.groups)

    def column(self, group: str, column: int) -> NDArray[np.float64]:
        return self.tables([group])[group][:, column]

    @cached_property
    def _places(self) -> dict[int, tuple[int, int]]:
        """Where each history lies: its first sample, counted over the part, and its length."""
        found, first = {}, 0
        for index, length in zip(self.indices.tolist(), self._cases["samples"].tolist(), strict=True):
            if length >= 0:
                found[index] = (first, length)
                first += length
        return found

    def history_indices(self) -> set[int]:
        return set(self._places)

    def history(self, index: int, rows: Sequence[int] | None = None) -> History:
        start, length = self._places[index]
        channels = len(self.layout.history_channels)
        time = safe.number_dataset(self.file, "history_times")[start : start + length]
        block = safe.number_dataset(self.file, "history_values")
        if len(time) != length:
            raise StoreError(f"{self.path}: holds less than all of history {index}")
        values = np.empty((channels if rows is None else len(rows), length))
        if rows is None:
            block.read_direct(values.reshape(-1), np.s_[channels * start : channels * (start + length)])
        else:
            for into, row in zip(values, rows, strict=True):
                first = channels * start + row * length
                into[:] = block[first : first + length]
        return History(np.asarray(time, dtype=np.float64), values)
