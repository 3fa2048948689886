"""Runs `tbi` in a child of this process: whatever it dies of is seen, and no second is lost to imports.

Root passes every permission by.  The child gives that power up, so that modes of files mean to it what they
mean to a user.
"""

from __future__ import annotations

import ctypes
import os
import signal
import tempfile
import traceback
import warnings
from dataclasses import dataclass
from pathlib import Path

from tbi_cli.cli import run_command_line

_PASSES_PERMISSIONS_BY = (1, 2)  # CAP_DAC_OVERRIDE and CAP_DAC_READ_SEARCH of linux/capability.h
_CAPABILITY_VERSION = 0x20080522


@dataclass(frozen=True)
class Died:
    """How a command ended: an exit code, or the negative number of a signal; the bytes of both streams."""

    code: int
    out: bytes
    err: bytes

    @property
    def text(self) -> str:
        """Both streams; bytes that are not UTF-8 are escaped."""
        return (self.out + self.err).decode("utf-8", "backslashreplace")


def forked(*arguments: str, folder: Path, patience: int = 60, as_user: bool = True) -> Died:
    """Runs a command in a folder; one that takes longer than `patience` seconds dies of SIGALRM."""
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        with warnings.catch_warnings():  # from Python 3.12 on: that there are threads
            warnings.simplefilter("ignore", DeprecationWarning)
            child = os.fork()
        if child == 0:
            code = 70
            try:
                os.dup2(out.fileno(), 1)
                os.dup2(err.fileno(), 2)
                code = _run(arguments, folder, patience, as_user)
            except BaseException:
                os.write(2, traceback.format_exc().encode("utf-8", "backslashreplace"))
            finally:
                os._exit(code)
        _, status = os.waitpid(child, 0)
        for stream in (out, err):
            stream.seek(0)
        return Died(os.waitstatus_to_exitcode(status), out.read(), err.read())


def _run(arguments: tuple[str, ...], folder: Path, patience: int, as_user: bool) -> int:
    import sys

    os.chdir(folder)
    if as_user and os.geteuid() == 0:
        obey_permissions()
    signal.signal(signal.SIGALRM, signal.SIG_DFL)
    signal.alarm(patience)
    # As Python makes them where the locale is UTF-8; pytest has put its own in their place.
    with (
        open(1, "w", encoding="utf-8", errors="strict", closefd=False) as sys.stdout,
        open(2, "w", encoding="utf-8", errors="backslashreplace", closefd=False) as sys.stderr,
    ):
        return run_command_line(arguments)


def obey_permissions() -> None:
    """Gives up, for good, what lets root read and write where modes forbid it."""
    libc = ctypes.CDLL(None, use_errno=True)
    header = (ctypes.c_uint32 * 2)(_CAPABILITY_VERSION, 0)
    sets = (ctypes.c_uint32 * 6)()  # effective, permitted and inheritable; twice 32 bits of each
    if libc.capget(header, sets):
        raise OSError(ctypes.get_errno(), "capget")
    for kind in range(3):
        for capability in _PASSES_PERMISSIONS_BY:
            sets[kind] &= ~(1 << capability) & 0xFFFFFFFF
    if libc.capset(header, sets):
        raise OSError(ctypes.get_errno(), "capset")
