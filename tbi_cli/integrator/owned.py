"""Files of machine code that this user alone can have written, whose code runs as this user."""

from __future__ import annotations

import contextlib
import os
import stat
from pathlib import Path
from uuid import uuid4

_MODE, _FOLDER_MODE = 0o644, 0o755
_OTHERS_WRITE = 0o022


def read(path: Path) -> bytes | None:
    """What is in a file; None if it is not there, no plain file, or may have been written by someone else."""
    # Of a named pipe that nobody writes to, opening alone would wait for ever.
    with contextlib.suppress(OSError), open(_descriptor(path, os.O_RDONLY), "rb") as file:
        found = os.fstat(file.fileno())
        if stat.S_ISREG(found.st_mode) and _is_ours(found):
            return file.read()
    return None


def write(path: Path, content: bytes) -> None:
    """Writes a file whole or not at all."""
    begun = path.with_name(f"{path.name}.{uuid4().hex}")
    try:
        with open(_descriptor(begun, os.O_WRONLY | os.O_CREAT | os.O_EXCL), "wb") as file:
            file.write(content)
        begun.replace(path)
    except OSError:
        with contextlib.suppress(OSError):
            begun.unlink()


def open_lock(path: Path) -> int:
    """A descriptor of a file to lock, made if need be.  Raises OSError if it is no plain file of ours."""
    descriptor = _descriptor(path, os.O_RDWR | os.O_CREAT)
    found = os.fstat(descriptor)
    if stat.S_ISREG(found.st_mode) and _is_ours(found):
        return descriptor
    os.close(descriptor)
    raise OSError(f"{path}: is no plain file of this user's")


def is_ours(folder: Path) -> bool:
    """Whether only this user, or the system's administrator, can make files in a folder."""
    try:
        found = folder.lstat()
    except OSError:
        return False
    return stat.S_ISDIR(found.st_mode) and _is_ours(found)


def make(folder: Path) -> None:
    """Makes a folder and those above it that are missing, for this user alone to write to."""
    missing = []
    while not folder.exists():
        missing.append(folder)
        folder = folder.parent
    for one in reversed(missing):
        with contextlib.suppress(FileExistsError):
            one.mkdir(mode=_FOLDER_MODE)


def _descriptor(path: Path, flags: int) -> int:
    more = getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_CLOEXEC", 0) | getattr(os, "O_BINARY", 0)
    return os.open(path, flags | more, _MODE)


def _is_ours(found: os.stat_result) -> bool:
    """Windows gives every user a cache folder of his own, and no such numbers."""
    if not hasattr(os, "getuid"):
        return True
    return found.st_uid in (os.getuid(), 0) and not found.st_mode & _OTHERS_WRITE
