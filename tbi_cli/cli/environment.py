"""Variables of the environment that are settings of libraries, and that a run should not depend on."""

from __future__ import annotations

import os

from tbi_cli.errors import RunFailedError, UserError

# What draws files only, shows its own progress and starts its own workers takes none of these, whatever they
# say; nonsense in them would end it.  NumPy's choice of instructions and HDF5's of drivers would change
# results, or where they are.
_IGNORED = (
    *("MPLBACKEND", "SOURCE_DATE_EPOCH", "TYPER_USE_RICH"),
    *("JOBLIB_MULTIPROCESSING", "JOBLIB_START_METHOD", "LOKY_MAX_DEPTH", "LOKY_PICKLER"),
    *("NPY_ENABLE_CPU_FEATURES", "NPY_DISABLE_CPU_FEATURES"),
    *("HDF5_DRIVER", "HDF5_DRIVER_CONFIG", "HDF5_VOL_CONNECTOR"),
)
_IGNORED_BEGINNINGS = ("TQDM_", "PILLOW_")


# Paths that are not absolute are none, as the XDG specification says; libraries make folders of them here.
_ABSOLUTE = ("HOME", "XDG_CACHE_HOME", "XDG_CONFIG_HOME", "XDG_DATA_HOME")
# With less address space than this, NumPy's library for linear algebra waits for memory without end.
_LEAST_MEMORY = 512 << 20  # bytes


def settle_environment() -> None:
    """Takes such variables out of the environment of this process, and so of those that it starts."""
    for name, value in [*os.environ.items()]:
        ignored = name in _IGNORED or name.startswith(_IGNORED_BEGINNINGS)
        if ignored or (name in _ABSOLUTE and not os.path.isabs(value)):  # noqa: PTH117 - pathlib takes long
            del os.environ[name]
    if memory_limit() is not None:  # every thread of that library takes a share, and none is needed
        os.environ["OPENBLAS_NUM_THREADS"] = "1"


def memory_limit() -> int | None:
    """The bytes of address space that this process may have (`ulimit -v`); None for no limit."""
    try:
        import resource
    except ImportError:  # Windows
        return None
    limit, _ = resource.getrlimit(resource.RLIMIT_AS)
    return None if limit == resource.RLIM_INFINITY else limit


def check_surroundings() -> None:
    """Raises UserError where no command can work: with hardly any memory, or in a folder that is gone."""
    limit = memory_limit()
    if limit is not None and limit < _LEAST_MEMORY:
        raise RunFailedError(
            f"out of memory: expected a limit (ulimit -v) of {_LEAST_MEMORY >> 20} MiB at least, "
            f"got {limit >> 20} MiB"
        )
    try:
        os.getcwd()  # noqa: PTH109 - pathlib takes long
    except OSError as error:
        raise UserError(f"the working directory cannot be used: {error.strerror}") from None
