"""Variables of the environment that are settings of libraries, and that a run should not depend on."""

from __future__ import annotations

import os

# What draws files only, shows its own progress and starts its own workers takes none of these, whatever they
# say; nonsense in them would end it.  NumPy's choice of instructions and HDF5's of drivers would change
# results, or where they are.
_IGNORED = (
    *("MPLBACKEND", "SOURCE_DATE_EPOCH", "TYPER_USE_RICH"),
    *("JOBLIB_MULTIPROCESSING", "JOBLIB_START_METHOD", "LOKY_MAX_DEPTH", "LOKY_PICKLER"),
    *("NPY_ENABLE_CPU_FEATURES", "NPY_DISABLE_CPU_FEATURES"),
    *("HDF5_DRIVER", "HDF5_DRIVER_CONFIG", "HDF5_VOL_CONNECTOR"),
)
_IGNORED_BEGINNINGS = ("TQDM_",)


def ignore_settings_of_libraries() -> None:
    """Takes them out of the environment of this process, and so of those that it starts."""
    for name in [*os.environ]:
        if name in _IGNORED or name.startswith(_IGNORED_BEGINNINGS):
            del os.environ[name]
