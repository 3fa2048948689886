"""An environment of nonsense, a working directory that is gone, Python without docstrings, little memory."""

from __future__ import annotations

import os
import re
import resource
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from tests.cli.commands import everything_below, tbi
from tests.cluster.runs import command, content, inside

FEW = ("--set", "solver.duration=1", "--set", "sweep={velocity: [150, 160]}")
# What tbi or one of its libraries takes for a number, a name or a path.  Each of them ended a command once,
# but for COLUMNS; a superscript is a digit to Python, and no number.
NONSENSE = {
    "SLURM_CPUS_PER_TASK": "²",
    "COLUMNS": "²",
    "SOURCE_DATE_EPOCH": "yesterday",
    "MPLBACKEND": "paper",
    "TQDM_MININTERVAL": "now",
    "TQDM_FILE": "log",
    "TQDM_POSITION": "above",
    "PILLOW_BLOCK_SIZE": "9" * 30,
    "JOBLIB_MULTIPROCESSING": "yes",
    "JOBLIB_START_METHOD": "begin",
    "LOKY_MAX_DEPTH": "deep",
    "LOKY_PICKLER": "cucumber",
    "HDF5_DRIVER": "car",
    "HDF5_VOL_CONNECTOR": "plug",
    "TYPER_USE_RICH": "no",
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a small results file."""
    folder = tmp_path_factory.mktemp("surroundings")
    assert inside("run", "paper", *FEW, "-q", "-o", "few.h5", folder=folder).code == 0
    return folder


def test_variables_of_nonsense(folder: Path) -> None:
    """The same bits and pictures, and not a word about them."""
    run = ("run", "paper", *FEW, "-o", "odd.h5", "--overwrite")
    processes = tbi(*run, "--backend", "processes", "-j", "2", folder=folder, **NONSENSE)
    assert (processes.code, processes.err) == (0, "")
    assert content(folder / "odd.h5") == content(folder / "few.h5")
    default = tbi(*run, folder=folder, **NONSENSE)  # as many jobs as Slurm says
    assert (default.code, default.err) == (0, "")
    reported = tbi("report", "few.h5", "-o", "odd", folder=folder, **NONSENSE)
    assert (reported.code, reported.err) == (0, "")
    assert inside("report", "few.h5", "-o", "even", folder=folder).code == 0
    odd, even = everything_below(folder / "odd"), everything_below(folder / "even")
    names = [name for name in even if name.endswith((".png", ".pdf", ".svg", ".csv"))]
    assert len(names) > 3
    assert [name for name in names if odd.get(name) != even[name]] == []


@pytest.mark.parametrize("arguments", [("submit", "paper"), ("status", "paper"), ("verify",)], ids=" ".join)
def test_a_working_directory_that_is_gone(arguments: tuple[str, ...], tmp_path: Path) -> None:
    """These hung, or printed a traceback; an empty folder is removed under the shell that stands in it."""
    away = f'cd {tmp_path} && rmdir {tmp_path} && exec "$0" -P -m tbi_cli "$@"'
    done = subprocess.run(
        ["sh", "-c", away, sys.executable, *arguments],
        env=os.environ | {"PYTHONPATH": str(Path(__file__).parents[2])},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == "the working directory cannot be used: No such file or directory\n"


def test_help_without_docstrings(tmp_path: Path) -> None:
    """`python -OO` leaves them out; what a command says of itself does not change, nor does a schema."""
    for arguments in (("--help",), ("run", "--help"), ("schema",)):
        whole = inside(*arguments, folder=tmp_path, COLUMNS="80").out
        assert len(whole) > 500
        assert tbi(*arguments, folder=tmp_path, PYTHONOPTIMIZE="2").out == whole


def limited(folder: Path, megabytes: int, *arguments: str) -> subprocess.CompletedProcess[str]:
    """A tbi process that may have so much address space."""

    def limit() -> None:
        resource.setrlimit(resource.RLIMIT_AS, (megabytes << 20, megabytes << 20))

    return subprocess.run(
        command(*arguments),
        cwd=folder,
        preexec_fn=limit,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )


@pytest.mark.parametrize("megabytes", [200, 520, 570, 620, 670])
def test_little_memory_from_the_start(folder: Path, megabytes: int) -> None:
    """Whatever fails first, be it a library that cannot be loaded: one message, and nothing half-written.

    How far a run gets with how much differs from machine to machine, so it may also be enough.
    """

    done = limited(folder, megabytes, "run", "paper", *FEW, "-q", "-o", "little.h5", "--resume")
    assert done.returncode in (0, 1), done.stderr
    assert done.stderr.count("\n") == done.returncode, done.stderr
    assert (folder / "little.h5").exists() == (done.returncode == 0)


def test_memory_that_runs_out_on_the_way(folder: Path) -> None:
    """A history that has no room: a message of the worker's error, and no results file."""
    history = ("--set", "output.histories=all", "--set", "solver.sampling=0.00001", "--set", "velocity=10")
    done = limited(folder, 900, "run", "paper", *history, "-q", "-o", "large.h5")
    assert done.returncode == 1
    assert re.fullmatch(r"out of memory.*; what was finished is kept .*\n", done.stderr)
    command = shlex.join(["tbi", "run", "paper", *history, "-q", "-o", "large.h5", "--resume"])
    assert done.stderr.endswith(f" (fewer --jobs need less); continue with: {command}\n")
    assert not (folder / "large.h5").exists()
