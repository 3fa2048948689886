"""Reading HDF5 files from strangers: nothing outside the file, nothing of a surprising kind or size.

Links are followed only if they are hard ones, so no external file and no loop of soft links; datasets only if
their bytes lie in the file itself; and no array is made that the file is too small to hold.
"""

from __future__ import annotations

import contextlib
import stat
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from h5py import h5d, h5o
from numpy.typing import NDArray

from tbi_cli.printable import one_line
from tbi_cli.store.errors import StoreError

_SIGNATURE = b"\x89HDF\r\n\x1a\n"
_FILTERS = {
    1,
    2,
    3,
    4,
    6,
}  # deflate, shuffle, fletcher32, szip, scale-offset: inside the library, as after h5repack
_EXPANSION = 1100  # deflate packs no more than 1032 bytes into one
_SMALL = 1 << 20  # bytes that any file may ask for

#: What h5py and numpy raise on files that are not what they say.
_READ_ERRORS = (
    OSError,
    ValueError,
    TypeError,
    LookupError,
    RuntimeError,
    AttributeError,
    ArithmeticError,
    MemoryError,
    SystemError,
)


@contextlib.contextmanager
def reading(path: Path) -> Iterator[None]:
    """Turns whatever a damaged file makes h5py raise into a `StoreError` that names the file."""
    try:
        yield
    except _READ_ERRORS as error:
        raise StoreError(f"{path}: is damaged or cut short ({one_line(str(error))})") from error


def looks_like_hdf5(path: Path) -> bool:
    """Whether the file starts as HDF5 files do."""
    with path.open("rb") as file:
        return file.read(len(_SIGNATURE)) == _SIGNATURE


def open_h5(path: Path) -> h5py.File:
    """Open ``path`` for reading, without file locks; raises `StoreError` for all that can be wrong."""
    try:
        mode = path.stat().st_mode
        if stat.S_ISDIR(mode):
            raise StoreError(f"{path}: is a folder, not a results file")
        if not stat.S_ISREG(mode):
            raise StoreError(f"{path}: is not a regular file")
        if not looks_like_hdf5(path):
            raise StoreError(f"{path}: is not an HDF5 file")
    except OSError as error:
        raise StoreError.from_os(path, error) from error
    with reading(path):
        return h5py.File(path, "r", locking=False)


def child_names(group: h5py.Group) -> Iterator[str]:
    """The names of the hard links in ``group``."""
    for name in group:
        if isinstance(group.get(name, getlink=True), h5py.HardLink):
            yield name


def child_group(group: h5py.Group, name: str) -> h5py.Group | None:
    """The sub-group ``name``; None if there is none.  Raises `StoreError` if it is something else."""
    child = _child(group, name)
    if child is not None and not isinstance(child, h5py.Group):
        raise StoreError(f"{_where(group, name)} is not a group")
    return child


def read_numbers(group: h5py.Group, name: str, shape: tuple[int, ...] | None = None) -> NDArray[np.float64]:
    """The dataset ``name`` as float64; of the given shape, or one-dimensional."""
    dataset = number_dataset(group, name, shape)
    return np.asarray(dataset[...], dtype=np.float64)


def number_dataset(group: h5py.Group, name: str, shape: tuple[int, ...] | None = None) -> h5py.Dataset:
    """The dataset ``name``, of real numbers, of the given shape or one-dimensional, safe to be read."""
    dataset = child_dataset(group, name)
    if dataset.dtype.kind not in "iuf" or dataset.dtype.itemsize > 8:
        raise StoreError(f"{_where(group, name)} does not hold real numbers")
    _check_shape(group, name, dataset, shape)
    return dataset


def read_records(group: h5py.Group, name: str, dtype: np.dtype[np.void]) -> NDArray[np.void]:
    """The one-dimensional dataset ``name`` of records of just that kind."""
    dataset = child_dataset(group, name)
    if dataset.dtype != dtype:
        raise StoreError(f"{_where(group, name)} does not hold the records that belong there")
    _check_shape(group, name, dataset, None)
    return np.asarray(dataset[...])


def read_texts(group: h5py.Group, name: str, shape: tuple[int, ...]) -> NDArray[np.object_]:
    """The dataset ``name`` of strings, as an object array of str."""
    dataset = child_dataset(group, name)
    if h5py.check_string_dtype(dataset.dtype) is None:
        raise StoreError(f"{_where(group, name)} does not hold text")
    _check_shape(group, name, dataset, shape)
    return np.asarray(dataset.asstr("utf-8", errors="replace")[...], dtype=object)


def read_attributes(target: h5py.HLObject) -> dict[str, str | int | float]:
    """The scalar attributes that are text or real numbers; others are passed over."""
    found: dict[str, str | int | float] = {}
    for name in target.attrs:
        try:
            attribute = target.attrs.get_id(name)
            if attribute.shape not in ((), (1,)) or attribute.get_storage_size() > _SMALL:
                continue
            value = target.attrs[name]
        except _READ_ERRORS:
            continue
        value = value.item() if isinstance(value, np.ndarray | np.generic) else value
        value = value.decode("utf-8", "replace") if isinstance(value, bytes) else value
        if isinstance(value, str | int | float) and not isinstance(value, bool):
            found[name] = value
    return found


def _child(group: h5py.Group, name: str) -> Any:
    link = group.get(name, getlink=True)
    if link is None:
        return None
    if not isinstance(link, h5py.HardLink):
        raise StoreError(f"{_where(group, name)} is a link, which is not followed")
    if h5o.get_info(group.id, name.encode()).type not in (h5o.TYPE_GROUP, h5o.TYPE_DATASET):
        raise StoreError(f"{_where(group, name)} is neither a group nor a dataset")
    return group[name]


def child_dataset(group: h5py.Group, name: str) -> h5py.Dataset:
    """The dataset ``name``, whose bytes lie in this file; raises `StoreError` if there is none such."""
    dataset = _child(group, name)
    if not isinstance(dataset, h5py.Dataset):
        raise StoreError(f"{_where(group, name)} is missing or not a dataset")
    plist = dataset.id.get_create_plist()
    if plist.get_layout() == h5d.VIRTUAL or plist.get_external_count():
        raise StoreError(f"{_where(group, name)} keeps its data in another file, which is not read")
    if any(plist.get_filter(i)[0] not in _FILTERS for i in range(plist.get_nfilters())):
        raise StoreError(f"{_where(group, name)} is packed by an unknown filter")
    return dataset


def _check_shape(group: h5py.Group, name: str, dataset: h5py.Dataset, shape: tuple[int, ...] | None) -> None:
    found = dataset.shape
    if found is None or (len(found) != 1 if shape is None else found != shape):
        raise StoreError(f"{_where(group, name)} has the shape {found}, expected {shape or 'one dimension'}")
    stored = dataset.id.get_storage_size() * (
        _EXPANSION if dataset.id.get_create_plist().get_nfilters() else 1
    )
    if dataset.nbytes > max(stored, _SMALL):
        raise StoreError(f"{_where(group, name)} claims {dataset.nbytes} bytes, but only {stored} are stored")


def _where(group: h5py.Group, name: str) -> str:
    return f"{one_line(str(group.file.filename))}: {one_line(str(group.name)).rstrip('/')}/{one_line(name)}"
