"""A first look at a file in a process of its own, where it can do no harm.

The HDF5 library itself loops without end on some damaged files (a global heap object of size 0, for one), and
nothing in Python can stop it then.  So a child process reads the file first; if that dies or does not come
to an end, the file is refused.
"""

from __future__ import annotations

import contextlib
import os
import sys
import warnings
from collections.abc import Callable
from pathlib import Path

from tbi_cli.store.errors import StoreError

_CPU_SECONDS = 10  # of reading, without waiting for the disk; a grid of a million cases takes two
_FILES_A_SECOND = 50  # that are opened; ten times as many on a usual machine
_MEMORY = 8 << 30  # bytes of address space on top of what this process has; a guard against absurd sizes


def vet(path: Path, look: Callable[[], object], *, files: int = 1) -> None:
    """Raise `StoreError` if ``look``, which reads the file ``path``, or ``files`` in it, does harm.

    Exceptions that it raises are no harm.  Where there is no `os.fork` (Windows) nothing is tried.
    """
    if sys.platform != "linux":
        return
    with warnings.catch_warnings():  # from Python 3.12 on: that there are threads; h5py looks after its lock
        warnings.simplefilter("ignore", DeprecationWarning)
        child = os.fork()
    if child == 0:
        try:
            _limit(_CPU_SECONDS + files // _FILES_A_SECOND)
            with contextlib.suppress(Exception):
                look()
        finally:
            os._exit(0)
    _, status = os.waitpid(child, 0)
    if os.WIFSIGNALED(status):
        raise StoreError(f"{path}: is damaged in a way that the HDF5 library cannot bear")


def _limit(seconds: int) -> None:
    import resource  # not on Windows

    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    for kind, limit in ((resource.RLIMIT_CPU, seconds), (resource.RLIMIT_AS, _used() + _MEMORY)):
        _, hard = resource.getrlimit(kind)
        value = limit if hard == resource.RLIM_INFINITY else min(limit, hard)
        resource.setrlimit(kind, (value, hard))
    null = os.open(os.devnull, os.O_WRONLY)
    os.dup2(null, 2)  # what a dying library has to say helps nobody


def _used() -> int:
    """The address space of this process, in bytes."""
    return int(Path("/proc/self/statm").read_text().split()[0]) * os.sysconf("SC_PAGE_SIZE")
