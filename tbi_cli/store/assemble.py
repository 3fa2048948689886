"""Writing a results file from whatever files hold its cases.

The tables are put together by flat index, so the order in which batches finished leaves no trace.
"""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np

from tbi_cli.store.durable import NewFile, new_h5
from tbi_cli.store.layout import CONVERGED, FORMAT, FORMAT_VERSION, TABLES, Dim, Layout, Variable
from tbi_cli.store.netcdf import VariableWriter, create_group, set_attributes, write_series
from tbi_cli.store.results import Results

_TABLE_MEMORY = 256 << 20  # bytes of tables held at once; larger grids take more passes over the parts

_STATUS = Variable("status", "1", "0 to do, 1 done, 2 failed")
_CONVERGED = Variable(CONVERGED, "1", "1, or 0 where the tolerance of the refined sweep was not reached")
_MESSAGE = Variable("message", "1", "why the case failed")
_STATUS_FLAGS = {"flag_meanings": "to_do done failed"}


def write_results(path: Path, scratch: Path, layout: Layout, results: Results, kept: str = "") -> None:
    """Write all that ``results`` holds as the results file ``path``, which is replaced in one step.

    ``layout`` has the attributes and the history channels of the new file.  Histories are copied one case
    at a time.  Raises `StoreError`, with what is ``kept``, if the disk refuses; ``path`` then stays what it
    was.
    """
    with new_h5(path, scratch, kept) as new:
        write_group(new, new.file, layout, results)


def write_group(new: NewFile, root: h5py.Group, layout: Layout, results: Results) -> None:
    """Write all that ``results`` holds into ``root``, an empty group of the file ``new``."""
    set_attributes(root, {"format": FORMAT, "format_version": FORMAT_VERSION, **layout.name_lists})
    set_attributes(root, {**results.attributes, **layout.attributes})
    _write_status(root, layout, results)
    _write_tables(new, root, layout, results)
    if layout.history_channels:
        _write_histories(new, root, layout, results)


def _write_status(root: h5py.Group, layout: Layout, results: Results) -> None:
    writer = VariableWriter(root, layout.dims)
    writer.numbers(_STATUS, results.status)
    root["status"].attrs["flag_values"] = np.array([0, 1, 2], dtype=np.int8)
    set_attributes(root["status"], _STATUS_FLAGS)
    texts = np.full(layout.size, "", dtype=object)
    for index, text in results.messages.items():
        texts[index] = text
    writer.texts(_MESSAGE, texts)
    converged = results.converged
    if converged is not None:
        writer.numbers(_CONVERGED, converged)


def _write_tables(new: NewFile, root: h5py.Group, layout: Layout, results: Results) -> None:
    groups = list(layout.groups)
    largest = 8 * layout.size * max(1, len(layout.channels))
    at_once = max(1, _TABLE_MEMORY // largest)
    for first in range(0, len(groups), at_once):
        for name, values in results.tables(groups[first : first + at_once]).items():
            group = create_group(root, name)
            if name in TABLES:
                set_attributes(group, {"long_name": TABLES[name]})
            writer = VariableWriter(group, layout.dims)
            for variable, row in zip(layout.columns(name), values, strict=True):
                writer.numbers(variable, row)
                new.check()


def _write_histories(new: NewFile, root: h5py.Group, layout: Layout, results: Results) -> None:
    parent = create_group(root, "histories")
    for index in results.history_indices():
        history = results.history(index)
        group = create_group(parent, str(index))
        set_attributes(group, layout.point(index))
        time = Dim("time", history.time, "s", "time since the first axle entered the bridge")
        write_series(new, group, time, layout.history_channels, history.values)
        new.check()
