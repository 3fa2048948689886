"""The netCDF-4 data model in HDF5: dimension scales, and variables with ``units`` and ``long_name``.

A history of one case is some eighty variables, so this writes with h5py's low-level interface: about 70
microseconds for a variable with its attributes and its scale, against half a millisecond with the friendly
one.  The data lie contiguous and unfiltered.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import Any

import h5py
import numpy as np
from h5py import h5a, h5d, h5ds, h5g, h5p, h5s, h5t
from numpy.typing import NDArray

from tbi_cli.store.durable import NewFile
from tbi_cli.store.layout import Dim, Scalar, Variable

_TEXT = h5py.string_dtype()
_TEXT_ON_DISK = h5t.py_create(_TEXT, logical=True)
_TEXT_IN_MEMORY = h5t.py_create(_TEXT)
_SCALAR = h5s.create(h5s.SCALAR)
_TYPES = {np.dtype(np.float64): h5t.IEEE_F64LE, np.dtype(np.int8): h5t.STD_I8LE}


def _contiguous(fill_time: int) -> Any:
    plist = h5p.create(h5p.DATASET_CREATE)
    plist.set_layout(h5d.CONTIGUOUS)
    plist.set_fill_time(fill_time)
    plist.set_obj_track_times(False)  # the same results make the same file
    return plist


_FOR_NUMBERS = _contiguous(h5d.FILL_TIME_NEVER)  # every dataset is written whole
_FOR_TEXTS = _contiguous(h5d.FILL_TIME_IFSET)  # which HDF5 insists on for text
_PLACED = _FOR_NUMBERS.copy()  # its place in the file is known as soon as it is made
_PLACED.set_alloc_time(h5d.ALLOC_TIME_EARLY)


def create_group(parent: h5py.Group, name: str) -> h5py.Group:
    """A new group in ``parent``."""
    return h5py.Group(h5g.create(parent.id, name.encode()))


def set_attributes(target: h5py.HLObject, attributes: Mapping[str, Scalar]) -> None:
    """Text as variable-length UTF-8, so that h5py gives str; numbers as 64-bit ones."""
    for name, value in attributes.items():
        if isinstance(value, str):
            _set_text(target.id, name.encode(), value)
        else:
            number = np.array(value, dtype=np.float64 if isinstance(value, float) else np.int64)
            h5a.create(target.id, name.encode(), h5t.py_create(number.dtype), _SCALAR).write(number)


def _set_text(target: Any, name: bytes, text: str) -> None:
    attribute = h5a.create(target, name, _TEXT_ON_DISK, _SCALAR)
    attribute.write(_text_array(text), mtype=_TEXT_IN_MEMORY)


@lru_cache(1024)
def _text_array(text: str) -> NDArray[np.object_]:
    return np.array(text.replace("\0", ""), dtype=object)


def place_numbers(group: h5py.Group, name: str, size: int) -> int:
    """Make a dataset of ``size`` float64 without its data; returns where in the file these belong."""
    space = h5s.create_simple((size,))
    return _offset(h5d.create(group.id, name.encode(), h5t.IEEE_F64LE, space, _PLACED))


def _offset(dataset: Any) -> int:
    return int(dataset.get_offset() or 0)  # an empty dataset has no place, and needs none


class VariableWriter:
    """Writes variables of one shape into one group, over one set of dimension scales.

    The scales are written into the group too, so that the group can be read on its own.
    """

    def __init__(self, group: h5py.Group, dims: Sequence[Dim]) -> None:
        self._group = group.id
        self._space = h5s.create_simple(tuple(len(dim.values) for dim in dims))
        self._scales = [self._scale(dim) for dim in dims]
        self._members = " ".join(member.name for dim in dims for member in dim.members)

    def _scale(self, dim: Dim) -> Any:
        scale = self._coordinate(dim)
        h5ds.set_scale(scale, dim.name.encode())
        for member in dim.members:
            h5ds.attach_scale(self._coordinate(member), scale, 0)
        if dim.members:
            _set_text(scale, b"members", " ".join(member.name for member in dim.members))
        return scale

    def _coordinate(self, dim: Dim) -> Any:
        values = np.ascontiguousarray(dim.values, dtype=np.float64)
        space = h5s.create_simple(values.shape)
        variable = Variable(dim.name, dim.units, dim.long_name)
        dataset = self._create(variable, h5t.IEEE_F64LE, space, _FOR_NUMBERS)
        dataset.write(h5s.ALL, h5s.ALL, values)
        return dataset

    def _create(self, variable: Variable, dtype: Any, space: Any, plist: Any) -> Any:
        dataset = h5d.create(self._group, variable.name.encode(), dtype, space, plist)
        _set_text(dataset, b"units", variable.units)
        _set_text(dataset, b"long_name", variable.long_name)
        return dataset

    def _create_scaled(self, variable: Variable, dtype: Any, plist: Any) -> Any:
        dataset = self._create(variable, dtype, self._space, plist)
        for axis, scale in enumerate(self._scales):
            h5ds.attach_scale(dataset, scale, axis)
        if self._members:
            _set_text(dataset, b"coordinates", self._members)  # by which xarray knows them for what they are
        return dataset

    def numbers(self, variable: Variable, values: NDArray[Any]) -> None:
        """Write float64 or int8 numbers, of the dimensions' shape or flat."""
        dataset = self._create_scaled(variable, _TYPES[values.dtype], _FOR_NUMBERS)
        dataset.write(h5s.ALL, h5s.ALL, np.ascontiguousarray(values).reshape(self._space.shape))

    def texts(self, variable: Variable, texts: NDArray[np.object_]) -> None:
        """Write strings, of the dimensions' shape or flat."""
        dataset = self._create_scaled(variable, _TEXT_ON_DISK, _FOR_TEXTS)
        dataset.write(h5s.ALL, h5s.ALL, texts.reshape(self._space.shape), mtype=_TEXT_IN_MEMORY)

    def place(self, variable: Variable) -> int:
        """Make a variable of float64 without its data; returns where in the file these belong."""
        return _offset(self._create_scaled(variable, h5t.IEEE_F64LE, _PLACED))


def write_series(
    new: NewFile, group: h5py.Group, dim: Dim, variables: Sequence[Variable], rows: NDArray[np.float64]
) -> None:
    """Write one variable along ``dim`` for each row of ``rows`` (number of variables, length of dim).

    HDF5 makes the variables; the data, which are large, go past it in few pieces.
    """
    writer = VariableWriter(group, [dim])
    offsets = [writer.place(variable) for variable in variables]
    rows = np.ascontiguousarray(rows)
    width = rows[0].nbytes if rows.size else 0
    first = 0
    for end in range(1, len(rows) + 1):
        if end == len(rows) or offsets[end] != offsets[end - 1] + width:  # neighbours go in one piece
            new.write_at(offsets[first], rows[first:end])
            first = end
