"""Folders for what is being made: gone at the end, and swept at the next start where a kill left them behind.

A folder is locked for as long as its process lives, whatever ends that; a sweep takes only folders of this
user that nobody has locked.  Where folders cannot be locked nothing is swept.
"""

from __future__ import annotations

import contextlib
import os
import re
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

try:
    import fcntl
except ImportError:  # not on Windows
    fcntl = None  # type: ignore[assignment]

_UNLOCKED = "~"
_RANDOM = "[a-z0-9_]{8}"  # what tempfile appends


@contextmanager
def scratch_folder(parent: Path, prefix: str) -> Iterator[Path]:
    """A new folder in ``parent`` whose name begins with ``prefix``, and nothing left of dead ones beside it.

    Raises OSError where none can be made.
    """
    _sweep(parent, prefix)
    made = tempfile.mkdtemp(prefix=prefix, suffix=_UNLOCKED, dir=parent)
    lock = _lock(Path(made))
    # It takes the name under which others may sweep it when it is locked.
    folder = Path(made).rename(made.removesuffix(_UNLOCKED))
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)
        if lock is not None:
            os.close(lock)


def _sweep(parent: Path, prefix: str) -> None:
    with contextlib.suppress(OSError):
        for entry in list(os.scandir(parent)):
            if not (re.fullmatch(re.escape(prefix) + _RANDOM, entry.name) and _is_own_folder(entry)):
                continue
            lock = _lock(Path(entry.path))
            if lock is not None:
                shutil.rmtree(entry.path, ignore_errors=True)
                os.close(lock)


def _is_own_folder(entry: os.DirEntry[str]) -> bool:
    return entry.is_dir(follow_symlinks=False) and entry.stat(follow_symlinks=False).st_uid == os.geteuid()


def _lock(folder: Path) -> int | None:
    """The descriptor that locks a folder; None where another has it, or where folders cannot be locked."""
    if fcntl is None:
        return None
    descriptor = -1
    try:
        descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW | os.O_CLOEXEC)
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        if descriptor >= 0:
            os.close(descriptor)
        return None
    return descriptor
