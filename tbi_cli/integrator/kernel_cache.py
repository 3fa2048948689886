"""Where compiled kernels are kept, so that a machine compiles them once.

The folder is `$TBI_CACHE_DIR`, else the user's cache folder, else the temporary one: the first that can be
written to, so a read-only installation or home does no harm.  Inside it, one folder holds what one state of
the integrator's source, numba and Python made for one kind of processor: many machines may share it, and
start at the same time.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import pickle
import sys
import tempfile
from collections.abc import Callable, Iterable, Iterator
from functools import lru_cache
from importlib.metadata import version
from pathlib import Path

_SETTING = "CACHE_DIR"  # of numba.config, made at run time


def settle() -> None:
    """Tells numba where to keep compiled kernels; to be called before a kernel's module is imported."""
    import numba

    if not os.environ.get("NUMBA_CACHE_DIR"):
        setattr(numba.config, _SETTING, str(folder()))


def folder() -> Path:
    """The folder of this state of the source, made if need be."""
    for base in _candidates():
        kept = base / "kernels" / f"{fingerprint()}-{_place()}" / _processor()
        try:
            kept.mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryFile(dir=kept):
                return kept
        except OSError:
            continue
    return Path(tempfile.mkdtemp(prefix="tbi-kernels-"))


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
    yield Path(tempfile.gettempdir()) / f"tbi-{os.getuid() if hasattr(os, 'getuid') else 'cache'}"


@lru_cache
def fingerprint() -> str:
    """What a compiled kernel depends on besides the processor.

    Numba watches only the file that a kernel stands in; the kernels here are made of several.
    """
    digest = hashlib.sha256()
    for name in ("numba", "llvmlite", "numpy"):
        digest.update(version(name).encode())
    digest.update(sys.version.encode())
    for source in sorted(Path(__file__).parent.glob("*.py")):
        digest.update(source.read_bytes())
    return digest.hexdigest()[:16]


def _place() -> str:
    """Where the source lies: numba keeps what two copies of it made apart."""
    return hashlib.sha256(str(Path(__file__).resolve().parent).encode()).hexdigest()[:8]


def _processor() -> str:
    import llvmlite.binding as llvm

    features = llvm.get_host_cpu_features().flatten()
    return f"{llvm.get_host_cpu_name()}-{hashlib.sha256(features.encode()).hexdigest()[:8]}"


def compile_kernels(say: Callable[[str], None], kinds: Iterable[str]) -> None:
    """Makes sure that the kernels of some kinds are compiled; says so first if this takes a while.

    When several processes start at once, one compiles and the others wait for it, where the file system has
    locks.
    """
    import numba

    kept = Path(getattr(numba.config, _SETTING) or folder())
    for kind in kinds:
        mark = kept / f"compiled-{kind}"
        if not mark.exists():
            with _only_one(kept / "lock"):
                if not mark.exists():
                    say("compiling kernels, once per machine (about ten seconds)")
                    _warm_up(kept, kind)
                    with contextlib.suppress(OSError):
                        mark.touch()
        _warm_up(kept, kind)


def _warm_up(kept: Path, kind: str) -> None:
    """Compiles or loads kernels; what is kept may be damaged, or there may be no room to keep more."""
    from tbi_cli.integrator.warm_up import warm_up

    try:
        warm_up(kind)
    except (OSError, EOFError, ValueError, pickle.PickleError):
        for file in kept.rglob("*.nb[ci]"):
            with contextlib.suppress(OSError):
                file.unlink()
        with contextlib.suppress(OSError):
            warm_up(kind)
        warm_up(kind)  # in memory by now, even where it could not be kept


@contextlib.contextmanager
def _only_one(lock: Path) -> Iterator[None]:
    try:
        import fcntl

        with lock.open("a") as held:
            with contextlib.suppress(OSError):
                fcntl.flock(held, fcntl.LOCK_EX)
            yield
    except (ImportError, OSError):
        yield
