"""Compiles kernels in a process of their own, in which nothing but tbi says how.

Numba takes its settings from the environment and from a file in the working folder; some of them change the
code that it makes.  And where memory is limited, LLVM ends its process.
"""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from collections.abc import Sequence
from multiprocessing.spawn import get_executable
from pathlib import Path

from tbi_cli.errors import RunFailedError

# Settings of numba, LLVM's bindings and Python; PYTHONHOME is where Python is.
_SETTINGS = ("NUMBA_", "LLVMLITE_", "PYTHON")
_START = "import sys; sys.path[:] = {path}; from tbi_cli.integrator.compiler import child; child({names})"


def object_codes(names: Sequence[str]) -> dict[str, bytes]:
    """The object files of kernels.  Raises RunFailedError where they cannot be made."""
    python = os.fsdecode(get_executable() or "")
    if not Path(python).name.lower().startswith("py"):  # Python inside another program
        from tbi_cli.integrator import machine_code

        return {name: machine_code.object_code(name) for name in names}
    root = Path(__file__).resolve().parents[2]
    path = [str(root), *(folder for folder in sys.path if Path(folder).is_absolute())]
    done = subprocess.run(
        [python, "-c", _START.format(path=ascii(path), names=ascii([*names]))],
        env={key: value for key, value in os.environ.items() if _is_kept(key)},
        cwd=Path(__file__).parent,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        start_new_session=True,  # Ctrl-C is for this process, which knows what to do
        check=False,
    )
    if done.returncode or not done.stdout:
        raise RunFailedError(f"kernels ({', '.join(names)}) could not be compiled: {_reason(done)}")
    codes: dict[str, bytes] = pickle.loads(done.stdout)
    return codes


def _is_kept(key: str) -> bool:
    return key == "PYTHONHOME" or not key.startswith(_SETTINGS)


def _reason(done: subprocess.CompletedProcess[bytes]) -> str:
    said = " ".join((done.stderr.decode("utf-8", "replace").strip().splitlines() or [""])[-1].split())
    ended = f"the compiler was ended by signal {-done.returncode} (out of memory?)"
    return ": ".join(filter(None, [ended if done.returncode < 0 else "", said])) or "no reason was given"


def child(names: Sequence[str]) -> None:
    """What the process does: writes the object files to standard output, to which nothing else is written."""
    output = os.dup(1)
    os.dup2(2, 1)
    try:
        from tbi_cli.integrator import machine_code

        codes = {name: machine_code.object_code(name) for name in names}
    except Exception as error:
        from tbi_cli.shortage import shortage

        print(shortage(error) or f"{type(error).__name__}: {error}", file=sys.stderr)
        sys.exit(1)
    with open(output, "wb") as file:  # noqa: PTH123 - a descriptor
        pickle.dump(codes, file)
