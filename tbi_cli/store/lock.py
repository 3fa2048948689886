"""One process at a time writes a results file, also on file systems without file locks.

The lock is a small file that says who holds it.  A lock whose process is gone (killed, or before a restart of
the machine) is recognised and taken over.  The lock of another machine cannot be checked and is honoured, but
for that of an earlier start of the same Slurm job: Slurm has queued it again because that one ended.
"""

from __future__ import annotations

import contextlib
import json
import os
import secrets
import socket
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path

from tbi_cli.printable import one_line
from tbi_cli.store.errors import StoreError
from tbi_cli.store.plain import read_plain

try:
    import fcntl
except ImportError:  # not on Windows; the lock file alone serves there
    fcntl = None  # type: ignore[assignment]

LOCK_FILE = "lock"


@dataclass(frozen=True)
class Holder:
    """Who holds a lock: a process id means nothing without its start, and its host's boot and namespace.

    `job` is the Slurm job that the process belongs to, if any, and `restart` how often that was queued again.
    """

    host: str
    boot: str
    namespace: str
    pid: int
    start: str
    job: str = ""
    restart: str = ""

    @classmethod
    def this_process(cls) -> Holder:
        """The running process."""
        host, pid = socket.gethostname(), os.getpid()
        return cls(host, _boot(), _namespace(), pid, _start(pid) or "", *_slurm_job())

    def is_gone(self) -> bool:
        """True if the process surely no longer runs; False if it does, or where that cannot be told."""
        job, restart = _slurm_job()
        if job and self.job == job and self.restart != restart:
            return True
        if self.host != socket.gethostname():
            return False
        if self.boot != _boot():
            return True
        if self.namespace != _namespace():
            return False
        if not _runs(self.pid):
            return True
        start = _start(self.pid)
        return bool(self.start and start) and self.start != start


class Lock:
    """The lock on the results whose parts folder is ``folder``; raises `StoreError` if another holds it."""

    def __init__(self, folder: Path, results: Path) -> None:
        self.path = folder / LOCK_FILE
        self._text = json.dumps({**asdict(Holder.this_process()), "token": secrets.token_hex(8)})
        self._acquire(results)

    def _acquire(self, results: Path) -> None:
        with _one_at_a_time(self.path.parent):
            refuse_if_held(self.path.parent, results)
            with contextlib.suppress(FileNotFoundError):
                self.path.unlink()
            self._create(results)

    def _create(self, results: Path) -> None:
        """Make the lock with its text in it, in one step, unless one has appeared meanwhile."""
        own = self.path.with_name(f"{LOCK_FILE}.{secrets.token_hex(8)}")
        try:
            own.write_text(self._text, encoding="utf-8")
            try:
                os.link(own, self.path)
            except FileExistsError:
                raise StoreError(f"{results}: another process has just begun to write it") from None
            except OSError:  # a file system without hard links
                own.replace(self.path)
        finally:
            own.unlink(missing_ok=True)

    def touch(self) -> None:
        """Show that the holder is alive: the lock's age is told to whoever asks from another machine."""
        with contextlib.suppress(OSError):
            os.utime(self.path)

    def is_held(self) -> bool:
        """Whether the lock is still this process's own."""
        try:
            return read_plain(self.path, 4096) == self._text
        except (OSError, StoreError):
            return False

    def release(self) -> None:
        """Give the lock up, if it is still ours."""
        if self.is_held():
            with contextlib.suppress(OSError):
                self.path.unlink()


def refuse_if_held(folder: Path, results: Path) -> None:
    """Raise `StoreError` if a process that may be alive holds the lock in ``folder``."""
    holder = read_holder(folder / LOCK_FILE)
    if holder is not None and not holder.is_gone():
        raise StoreError(_refusal(results, folder / LOCK_FILE, holder))


def read_holder(path: Path) -> Holder | None:
    """Who holds the lock file ``path``; None if nobody does, or if it does not say so.

    Raises `StoreError` where it may not be read.
    """
    try:
        data = json.loads(read_plain(path, 4096))
        return Holder(
            host=str(data["host"]),
            boot=str(data["boot"]),
            namespace=str(data["namespace"]),
            pid=int(data["pid"]),
            start=str(data["start"]),
            job=str(data.get("job", "")),
            restart=str(data.get("restart", "")),
        )
    except PermissionError as error:  # of somebody else: that it says nothing to us does not make it free
        raise StoreError.from_os(path, error) from error
    except (OSError, StoreError, ValueError, KeyError, TypeError, RecursionError):
        return None


def _refusal(results: Path, lock: Path, holder: Holder) -> str:
    who = f"{results}: is being written by process {holder.pid} on {one_line(holder.host)}"
    if holder.host == socket.gethostname() and holder.namespace == _namespace():
        return who
    try:
        age = time.time() - lock.stat().st_mtime
    except OSError:
        age = 0.0
    return f"{who}, last heard of {_words(age)} ago; if that run is dead, delete {lock}"


def _words(seconds: float) -> str:
    for unit, length in (("days", 86400.0), ("hours", 3600.0), ("minutes", 60.0)):
        if seconds >= 2 * length:
            return f"{seconds / length:.0f} {unit}"
    return f"{max(0.0, seconds):.0f} seconds"


@contextlib.contextmanager
def _one_at_a_time(folder: Path) -> Iterator[None]:
    """Keeps processes of one machine from taking over a dead lock together, where folders can be locked."""
    fd = os.open(folder, os.O_RDONLY)
    try:
        if fcntl is not None:
            with contextlib.suppress(OSError):
                fcntl.flock(fd, fcntl.LOCK_EX)
        yield
    finally:
        os.close(fd)


def _slurm_job() -> tuple[str, str]:
    """The Slurm job of this process, of which cluster, and how often it was queued again; empty if none."""
    if not (job := os.environ.get("SLURM_JOB_ID")):
        return "", ""
    return f"{os.environ.get('SLURM_CLUSTER_NAME', '')}:{job}", os.environ.get("SLURM_RESTART_COUNT", "0")


def _boot() -> str:
    return _read("/proc/sys/kernel/random/boot_id")


def _namespace() -> str:
    try:
        return str(Path("/proc/self/ns/pid").readlink())
    except OSError:
        return ""


def _start(pid: int) -> str | None:
    """When the process started, in clock ticks since boot; None where the system does not say."""
    fields = _stat(pid)
    return fields[19] if len(fields) > 19 else None


def _runs(pid: int) -> bool:
    fields = _stat(pid)
    if fields:
        return fields[0] not in ("Z", "X")  # a process that was killed but not waited for is gone too
    try:
        os.kill(pid, 0)
    except (ProcessLookupError, OverflowError, ValueError):
        return False
    except OSError:
        return True
    return pid > 0


def _stat(pid: int) -> list[str]:
    """The fields of /proc/PID/stat after the program's name, which may hold blanks and brackets."""
    return _read(f"/proc/{pid}/stat").rpartition(")")[2].split()


def _read(path: str) -> str:
    try:
        return Path(path).read_text(encoding="utf-8", errors="replace").strip()
    except OSError:
        return ""
