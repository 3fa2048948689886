"""Where compiled kernels are kept, so that a machine compiles them once.

The folder is `$TBI_CACHE_DIR`, else the user's cache folder, else one of the user's own in the temporary
folder: the first that can be written to, so a read-only installation or home does no harm.  Inside it, one
folder holds what one state of the integrator's source, numba and Python made for one kind of processor: many
machines may share it, and start at the same time.  A kernel is one file: the SHA-256 of an object file, and
the object file.  The hash tells accidents, not malice: whoever can write to the folder runs code as this
user.  So what another user could have written, but for the system's administrator, is not used.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import sys
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import lru_cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

from tbi_cli.integrator import owned
from tbi_cli.integrator.kernels import KINDS, Call, Function

_DIGEST = 32  # bytes of SHA-256
# Whoever holds the lock for longer than any compiler takes hangs, and is not waited for.
_SECONDS_TO_COMPILE = 300.0
_SECONDS_BETWEEN_LOOKS = 0.05


def compile_kernels(say: Callable[[str], None], kinds: Iterable[str]) -> None:
    """Makes sure that the kernels of some kinds are compiled; says so first if this takes a while.

    When several processes start at once, one compiles and the others wait for it, where the file system has
    locks.
    """
    say_once = lru_cache(say)
    for kind in kinds:
        _load(KINDS[kind], say_once)


def call(name: str, *values: Any) -> Call:
    """A kernel with its arguments, compiled now if it never was."""
    _load((name,), lambda text: None)
    return Call(name, _functions[name], *values)


_functions: dict[str, Function] = {}


def _load(names: Iterable[str], say: Callable[[str], None]) -> None:
    from tbi_cli.integrator.native import Loaded

    wanted = [name for name in names if name not in _functions]
    codes, folder = _find(wanted)
    if missing := [name for name in wanted if name not in codes]:
        codes |= _compiled(missing, folder, say)
    for name in wanted:
        _functions[name] = Loaded(name, codes[name])


def _find(names: Sequence[str]) -> tuple[dict[str, bytes], Path | None]:
    """The object files of kernels that were compiled before, and the folder to keep the others in, if any."""
    codes: dict[str, bytes] = {}
    for folder in _folders() if names else ():
        for name in names if owned.is_ours(folder) else ():
            content = owned.read(folder / name) or b""
            code = content[_DIGEST:]
            if code and hashlib.sha256(code).digest() == content[:_DIGEST]:
                codes.setdefault(name, code)
        if len(codes) == len(names) or _writable(folder):
            return codes, folder
    return codes, None


def _compiled(names: Sequence[str], folder: Path | None, say: Callable[[str], None]) -> dict[str, bytes]:
    """Compiles kernels, unless another process has just done so, and keeps them where that is possible."""
    with _only_one(folder):
        codes, _ = _find(names)
        if missing := [name for name in names if name not in codes]:
            say("compiling kernels, once per machine (about ten seconds)")
            from tbi_cli.integrator.compiler import object_codes

            made = object_codes(missing)
            if folder is not None:
                for name, code in made.items():
                    owned.write(folder / name, hashlib.sha256(code).digest() + code)
            codes |= made
        return codes


def _writable(folder: Path) -> bool:
    try:
        owned.make(folder)
        with tempfile.TemporaryFile(dir=folder):
            return owned.is_ours(folder)
    except OSError:
        return False


def _folders() -> Iterator[Path]:
    """Where the kernels of this processor and this state of the source may be, best first."""
    from tbi_cli.integrator.native import processor

    for base in _candidates():
        yield base / "kernels" / fingerprint() / processor()


def _candidates() -> Iterator[Path]:
    if own := os.environ.get("TBI_CACHE_DIR"):
        yield Path(own)
    if user := _users_cache():
        yield user / "tbi"
    temporary = Path(tempfile.gettempdir()) / f"tbi-{os.getuid() if hasattr(os, 'getuid') else 'cache'}"
    with contextlib.suppress(OSError):  # anyone can make that folder
        owned.make(temporary)
        if owned.is_ours(temporary):
            yield temporary


def _users_cache() -> Path | None:
    """The user's folder for caches.  A path that is not absolute is none, as the XDG specification says."""
    places = [os.environ.get("LOCALAPPDATA", "") if sys.platform == "win32" else ""]
    places.insert(0, os.environ.get("XDG_CACHE_HOME", ""))
    with contextlib.suppress(RuntimeError):
        places.append(str(Path.home() / ".cache"))
    return next((Path(place) for place in places if Path(place).is_absolute()), None)


@lru_cache
def fingerprint() -> str:
    """What a compiled kernel depends on besides the processor."""
    digest = hashlib.sha256()
    for name in ("numba", "llvmlite", "numpy"):  # their settings are those of `compiler`
        digest.update(version(name).encode())
    digest.update(sys.version.encode())
    for source in sorted(Path(__file__).parent.glob("*.py")):
        digest.update(source.read_bytes())
    return digest.hexdigest()[:16]


@contextlib.contextmanager
def _only_one(folder: Path | None) -> Iterator[None]:
    """Waits for whoever compiles into a folder, where there is one that has locks."""
    with contextlib.ExitStack() as held:
        if folder is not None:
            with contextlib.suppress(ImportError, OSError):
                import fcntl

                lock = owned.open_lock(folder / "lock")
                held.callback(os.close, lock)
                end = time.monotonic() + _SECONDS_TO_COMPILE
                while not _locked(fcntl, lock) and time.monotonic() < end:
                    time.sleep(_SECONDS_BETWEEN_LOOKS)
        yield


def _locked(fcntl: Any, lock: int) -> bool:
    """Raises OSError where the file system has no locks."""
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True
