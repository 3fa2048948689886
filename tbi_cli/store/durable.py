"""Files that are either there as a whole or not at all, whatever happens while they are written.

A new file grows under a temporary name, is synced, takes its name by `os.replace`, and then its folder is
synced: at any instant a crash leaves the old state or the new one.
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import h5py
import numpy as np
from h5py import h5f, h5fd, h5p
from numpy.typing import NDArray

from tbi_cli.store.errors import StoreError
from tbi_cli.store.interrupts import Interrupts

#: How the name of a file that is not finished yet ends; never ``.h5``, so that nobody takes it for one.
UNFINISHED = ".unfinished"

#: Characters of a file's name in that of its temporary file: of four bytes each with room to spare.
_NAME = 40
_SYNC_EVERY = 32 << 20  # bytes; keeps the disk busy while HDF5 is, instead of one long wait at the end
_sync_data = getattr(os, "fdatasync", os.fsync)  # macOS has no fdatasync

_METADATA_BLOCK = 1 << 18  # bytes; object headers side by side instead of strewn among the data


class _RecordingFile:
    """The file object that HDF5 writes through.  It never fails: it remembers the first error instead.

    HDF5 cannot close a file that it failed to write (it tries again at exit, and may abort).  So from the
    first error on (no space, a size limit) what HDF5 writes is kept in memory, where it must find it again,
    and whoever closes the file looks at ``error``.
    """

    def __init__(self, path: Path) -> None:
        self.error: OSError | None = None
        self._fd = os.open(path, os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_CLOEXEC, 0o666)
        self._position = 0
        self._kept: list[tuple[int, bytes]] = []
        self._unsynced = 0
        self._background = ThreadPoolExecutor(1)

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        if whence == os.SEEK_SET:
            self._position = offset
        elif whence == os.SEEK_CUR:
            self._position += offset
        else:
            self._position = os.fstat(self._fd).st_size + offset
        return self._position

    def tell(self) -> int:
        return self._position

    def readinto(self, buffer: memoryview) -> int:
        view = memoryview(buffer).cast("B")
        start, end = self._position, self._position + len(view)
        found = os.preadv(self._fd, [view], start)
        view[found:] = bytes(len(view) - found)
        for offset, data in self._kept:
            a, b = max(start, offset), min(end, offset + len(data))
            if a < b:
                view[a - start : b - start] = data[a - offset : b - offset]
        self._position = end
        return len(view)

    def write(self, data: bytes | memoryview) -> int:
        self.write_at(self._position, memoryview(data))
        if self.error is not None:
            self._kept.append((self._position, bytes(data)))
        self._position += len(data)
        return len(data)

    def write_at(self, offset: int, view: memoryview) -> None:
        """Write bytes at ``offset``."""
        if self.error is not None:
            return
        try:
            written = os.pwrite(self._fd, view, offset)
            while written < len(view):  # a disk that is nearly full takes a part, and fails the next time
                written += os.pwrite(self._fd, view[written:], offset + written)
            self._unsynced += len(view)
            if self._unsynced >= _SYNC_EVERY:
                self._unsynced = 0
                self._background.submit(self._sync_data)
        except OSError as error:
            self.error = error

    def _sync_data(self) -> None:
        try:
            _sync_data(self._fd)
        except OSError as error:
            self.error = self.error or error

    def truncate(self, size: int | None = None) -> int:
        size = self._position if size is None else size
        if self.error is None:
            try:
                os.ftruncate(self._fd, size)
            except OSError as error:
                self.error = error
        return size

    def flush(self) -> None:
        pass

    def sync(self) -> None:
        """Wait until everything is on the disk; raises the first error of the file's life."""
        self._background.shutdown()
        if self.error is not None:
            raise self.error
        os.fsync(self._fd)

    def close(self) -> None:
        self._background.shutdown(cancel_futures=True)
        os.close(self._fd)


class NewFile:
    """An HDF5 file that is being written: ``file`` for h5py, `check` to stop early when the disk is full."""

    def __init__(self, file: h5py.File, raw: _RecordingFile, interrupts: Interrupts) -> None:
        self.file = file
        self._raw = raw
        self._interrupts = interrupts

    def write_at(self, offset: int, block: NDArray[np.float64]) -> None:
        """Write a C-contiguous block, past HDF5, as data of datasets at ``offset`` of the file."""
        if block.size:
            self._raw.write_at(offset, block.data.cast("B"))

    def check(self) -> None:
        """Raise the `OSError` that a write has met so far, if any; a place where Ctrl-C may take effect."""
        if self._raw.error is not None:
            raise self._raw.error
        self._interrupts.deliver()


@contextlib.contextmanager
def new_h5(path: Path, scratch: Path, kept: str = "") -> Iterator[NewFile]:
    """A new HDF5 file that becomes ``path`` when the block ends well; else ``path`` stays what it was.

    It is written in the folder ``scratch``, on the same file system, in HDF5's earliest file version, so that
    programs built on HDF5 1.8 and later read it.  Signals wait for `NewFile.check` or the end.  Raises
    `StoreError` for whatever the operating system refuses, with what is ``kept``, so that the run can go on.
    """
    temporary = scratch / f"{path.name[:_NAME]}{UNFINISHED}"  # no longer than a name may be
    with Interrupts() as interrupts:
        try:
            raw = _RecordingFile(temporary)
            try:
                file = _open_for_writing(raw)
                try:
                    yield NewFile(file, raw, interrupts)
                except BaseException:
                    with contextlib.suppress(Exception):  # the first error is the one to tell
                        file.close()
                    if raw.error is not None:  # what HDF5 makes of it is of no interest
                        raise raw.error from None
                    raise
                file.close()
                raw.sync()
            finally:
                raw.close()
            temporary.replace(path)
            sync_folder(path.parent)
        except OSError as error:
            refused = StoreError.from_os(path, error, kept)
            raise (refused.kept() if kept else refused) from error
        finally:
            with contextlib.suppress(OSError):
                temporary.unlink()


def _open_for_writing(raw: _RecordingFile) -> h5py.File:
    access = h5p.create(h5p.FILE_ACCESS)
    access.set_fileobj_driver(h5fd.fileobj_driver, raw)
    access.set_libver_bounds(h5f.LIBVER_EARLIEST, h5f.LIBVER_V110)
    access.set_meta_block_size(_METADATA_BLOCK)
    access.set_fclose_degree(h5f.CLOSE_STRONG)
    create = h5p.create(h5p.FILE_CREATE)
    create.set_obj_track_times(False)
    return h5py.File(h5f.create(b"tbi", h5f.ACC_TRUNC, fcpl=create, fapl=access))


def write_text(path: Path, text: str) -> None:
    """Replace ``path`` by a file that holds ``text``, as durably as `new_h5`; raises `OSError`."""
    temporary = path.with_name(path.name + UNFINISHED)
    try:
        with temporary.open("w", encoding="utf-8") as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        temporary.replace(path)
    finally:
        with contextlib.suppress(OSError):
            temporary.unlink()
    sync_folder(path.parent)


def sync_folder(folder: Path) -> None:
    """Make the names in ``folder`` durable, where the file system can do that for a folder."""
    fd = os.open(folder, os.O_RDONLY)
    try:
        with contextlib.suppress(OSError):  # EINVAL on some network file systems, which need no such sync
            os.fsync(fd)
    finally:
        os.close(fd)
