"""Where compiled kernels are kept, so that a machine compiles them once.

The folder is `$TBI_CACHE_DIR`, else the user's cache folder, else one of the user's own in the temporary
folder: the first that can be written to, so a read-only installation or home does no harm.  Inside it, one
folder holds what one state of the integrator's source, numba and Python made for one kind of processor: many
machines may share it, and start at the same time.  A kernel is one file: the SHA-256 of an object file, and
the object file.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import stat
import sys
import tempfile
from collections.abc import Callable, Iterable, Iterator
from functools import lru_cache
from importlib.metadata import version
from pathlib import Path
from typing import Any
from uuid import uuid4

from tbi_cli.integrator.kernels import KINDS, Call, Function

_DIGEST = 32  # bytes of SHA-256


def compile_kernels(say: Callable[[str], None], kinds: Iterable[str]) -> None:
    """Makes sure that the kernels of some kinds are compiled; says so first if this takes a while.

    When several processes start at once, one compiles and the others wait for it, where the file system has
    locks.
    """
    say_once = lru_cache(say)
    for kind in kinds:
        for name in KINDS[kind]:
            _function(name, say_once)


def call(name: str, *values: Any) -> Call:
    """A kernel with its arguments, compiled now if it never was."""
    return Call(name, _function(name, lambda text: None), *values)


_functions: dict[str, Function] = {}


def _function(name: str, say: Callable[[str], None]) -> Function:
    if name not in _functions:
        from tbi_cli.integrator.native import Loaded

        code, folder = _find(name)
        _functions[name] = Loaded(name, code or _compiled(name, folder, say))
    return _functions[name]


def _find(name: str) -> tuple[bytes | None, Path | None]:
    """The object file of a kernel that was compiled before, else the folder to keep it in if there is any."""
    for folder in _folders():
        with contextlib.suppress(OSError):
            content = (folder / name).read_bytes()
            code = content[_DIGEST:]
            if code and hashlib.sha256(code).digest() == content[:_DIGEST]:
                return code, folder
        if _writable(folder):
            return None, folder
    return None, None


def _compiled(name: str, folder: Path | None, say: Callable[[str], None]) -> bytes:
    """Compiles a kernel, unless another process has just done so, and keeps it where that is possible."""
    with _only_one(folder):
        code, _ = _find(name)
        if code is not None:
            return code
        say("compiling kernels, once per machine (about ten seconds)")
        from tbi_cli.integrator.machine_code import object_code

        code = object_code(name)
        if folder is not None:
            _keep(folder / name, hashlib.sha256(code).digest() + code)
        return code


def _keep(file: Path, content: bytes) -> None:
    """Writes a file whole or not at all."""
    begun = file.with_name(f"{file.name}.{uuid4().hex}")
    try:
        begun.write_bytes(content)
        begun.replace(file)
    except OSError:
        with contextlib.suppress(OSError):
            begun.unlink()


def _writable(folder: Path) -> bool:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return True
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
    if cache := os.environ.get("XDG_CACHE_HOME"):
        yield Path(cache) / "tbi"
    elif sys.platform == "win32" and (local := os.environ.get("LOCALAPPDATA")):
        yield Path(local) / "tbi"
    else:
        with contextlib.suppress(RuntimeError):
            yield Path.home() / ".cache" / "tbi"
    temporary = Path(tempfile.gettempdir()) / f"tbi-{os.getuid() if hasattr(os, 'getuid') else 'cache'}"
    if _is_ours(temporary):
        yield temporary


def _is_ours(folder: Path) -> bool:
    """Whether a folder in a place where anyone can make one is ours alone: code is loaded from it."""
    try:
        with contextlib.suppress(FileExistsError):
            folder.mkdir(mode=0o700)
        found = folder.lstat()
    except OSError:
        return False
    if not hasattr(os, "getuid"):
        return True
    return stat.S_ISDIR(found.st_mode) and found.st_uid == os.getuid() and not found.st_mode & 0o022


@lru_cache
def fingerprint() -> str:
    """What a compiled kernel depends on besides the processor."""
    digest = hashlib.sha256()
    for name in ("numba", "llvmlite", "numpy"):
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

                fcntl.flock(held.enter_context((folder / "lock").open("a")), fcntl.LOCK_EX)
        yield
