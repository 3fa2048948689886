"""Errors that are the system's shortage of something: memory, threads, open files."""

from __future__ import annotations

import contextlib
import errno
from collections.abc import Iterator
from pathlib import Path

_MEMORY = "out of memory"
_THREADS = "no thread can be started (a limit on memory or on the number of threads?)"
_FILES = "too many open files"
_OF_SYSTEM = {errno.ENOMEM: _MEMORY, errno.EMFILE: _FILES, errno.ENFILE: _FILES, errno.EAGAIN: _THREADS}
# What libraries say, each in an exception of its own kind.
_WORDS = {
    "cannot allocate memory": _MEMORY,
    "failed to map segment": _MEMORY,
    "memory allocation failed": _MEMORY,
    "unable to allocate": _MEMORY,
    "can't start new thread": _THREADS,
    "too many open files": _FILES,
}
# As near to a limit on memory as this, whatever fails fails for want of memory.
_NEAR = 48 << 20  # bytes


def shortage(error: BaseException) -> str | None:
    """What the system was short of when this was raised; None if it was not that."""
    for one in _chain(error):
        if isinstance(one, MemoryError):
            return f"{_MEMORY}: {one}" if str(one) else _MEMORY
        if isinstance(one, OSError) and one.errno in _OF_SYSTEM:
            return _OF_SYSTEM[one.errno]
        said = str(one).lower()
        for words, meaning in _WORDS.items():
            if words in said:
                return meaning
    return _MEMORY if _near_the_limit() else None


def _chain(error: BaseException | None) -> Iterator[BaseException]:
    """An error and those that led to it."""
    seen = set()
    while error is not None and id(error) not in seen:
        yield error
        seen.add(id(error))
        error = error.__cause__ or error.__context__


def _near_the_limit() -> bool:
    """Whether this process has at some time had nearly all of the address space that it may have."""
    with contextlib.suppress(ImportError, OSError, ValueError, StopIteration):
        import resource

        limit, _ = resource.getrlimit(resource.RLIMIT_AS)
        if limit != resource.RLIM_INFINITY:
            status = Path("/proc/self/status").read_text(encoding="ascii").splitlines()
            most = next(int(line.split()[1]) for line in status if line.startswith("VmPeak:"))
            return limit - 1024 * most < _NEAR
    return False
