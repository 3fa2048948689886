"""Surroundings that no one would choose: variables of nonsense, streams that fail, little of everything."""

from __future__ import annotations

import os
import random
import resource
import shutil
import signal
import subprocess
import time
from collections.abc import Callable

from soaking.common import HISTORIES, Soak

from tests.cluster.runs import command, content

DOCUMENTED = (0, 1, 2, 75, 130, 141)
FEW = ("--set", "sweep={velocity: [40, 50, 60]}")
RUN = ("run", "case.yaml", "-o", "r.h5", "--overwrite", "-j", "2", *FEW)
COMMANDS: tuple[tuple[str, ...], ...] = (
    *(("list",), ("schema",), ("--help",), ("run", "--help"), ("--version",), ("list", "nothing")),
    *(("info", "few.h5"), ("info", "few.h5", "-v"), ("info", "few.h5", "--diff", "few.h5")),
    *(
        ("validate", "case.yaml"),
        ("validate", "nowhere.yaml"),
        ("status", "few.h5"),
        ("merge", "x", "-o", "y"),
    ),
    *(("export", "few.h5", "-o", "tables", "--overwrite"), RUN, (*RUN, "--backend", "processes")),
    *(("report", "few.h5", "-o", "few-report", "--formats", "png"), ("report", "few.h5", "-o", "few-report")),
)
# Variables that some part of tbi or of its libraries reads when a command runs.
VARIABLES = (
    *(
        "SLURM_CPUS_PER_TASK",
        "SLURM_JOB_ID",
        "SLURM_ARRAY_JOB_ID",
        "SLURM_ARRAY_TASK_ID",
        "SLURM_CLUSTER_NAME",
    ),
    *("SLURM_RESTART_COUNT", "XDG_CACHE_HOME", "XDG_CONFIG_HOME", "HOME", "TMPDIR", "COLUMNS", "LINES"),
    *("NO_COLOR", "FORCE_COLOR", "TERM", "TERMINAL_WIDTH", "LANG", "LC_ALL", "LANGUAGE", "SOURCE_DATE_EPOCH"),
    *("MPLBACKEND", "MATPLOTLIBRC", "TQDM_MININTERVAL", "TQDM_DISABLE", "TQDM_ASCII"),
    *("TQDM_FILE", "TQDM_NROWS", "TQDM_POSITION", "NUMBA_OPT", "NUMBA_DISABLE_JIT", "NUMBA_CPU_NAME"),
    *(
        "NUMBA_NUM_THREADS",
        "NUMBA_DUMP_IR",
        "NUMBA_DEBUGINFO",
        "JOBLIB_MULTIPROCESSING",
        "JOBLIB_START_METHOD",
    ),
    *("JOBLIB_TEMP_FOLDER", "LOKY_MAX_DEPTH", "LOKY_PICKLER", "LOKY_MAX_CPU_COUNT", "HDF5_DRIVER"),
    *("HDF5_VOL_CONNECTOR", "HDF5_USE_FILE_LOCKING", "HDF5_PLUGIN_PATH", "NPY_DISABLE_CPU_FEATURES"),
    *("NPY_ENABLE_CPU_FEATURES", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "OPENBLAS_VERBOSE"),
    *(
        "XDG_DATA_HOME",
        "PILLOW_ALIGNMENT",
        "PILLOW_BLOCK_SIZE",
        "PILLOW_BLOCKS_MAX",
        "TYPER_USE_RICH",
        "SCIPY_ARRAY_API",
    ),
    *("PYTHONWARNINGS", "PYTHONOPTIMIZE", "PYTHONUNBUFFERED", "PYTHONDEVMODE", "GIT_DIR", "GIT_TRACE"),
    *("PYDANTIC_DISABLE_PLUGINS", "DASK_CONFIG", "LLVMLITE_ENABLE_IR_LAYER_TYPED_POINTERS", "EDITOR"),
)
VALUES = (
    "",
    "0",
    "1",
    "-1",
    "²",
    "9" * 30,
    "9" * 5000,
    "nan",
    "1e9",
    "nonsense",
    "a/b",
    ".",
    "/",
    "/dev/null",
    "é\t",
)
# Values under which Python itself does not start, or says something that it is asked to say.
LEFT_OUT = {("PYTHONDEVMODE", "1"), ("OPENBLAS_VERBOSE", "2")}
ENCODINGS: tuple[dict[str, str], ...] = (
    *(
        {"PYTHONIOENCODING": name}
        for name in ("ascii", "latin-1", "cp1252", "ascii:strict", "utf-16", "utf-8")
    ),
    {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"},
)


def environment(soak: Soak) -> None:
    """Up to five variables of nonsense at a time: the same bits, and a line where something is refused."""
    draw, first = random.Random(1), _few(soak)
    tries = 5 if soak.short else 300
    print(f"environment: {tries} draws of {len(VARIABLES)} variables and {len(VALUES)} values")
    same = 0
    for _ in range(tries):
        names = draw.sample(VARIABLES, draw.randint(1, 5))
        given = {name: draw.choice(VALUES) for name in names}
        given = {name: value for name, value in given.items() if (name, value) not in LEFT_OUT}
        arguments = draw.choice(COMMANDS)
        ended = soak.tbi(*arguments, **given)
        _check(soak, arguments, given, ended)
        if arguments[:1] == ("run",) and "-o" in arguments:
            made = soak.folder / "r.h5"
            soak.expect(f"the bits under {given}", made.exists() and content(made) == first)
            same += 1
        left = sorted({path.name for path in soak.folder.iterdir()} - KNOWN)
        soak.expect(f"no files made here by {' '.join(arguments)} under {given}: {left}", not left)
        for name in left:
            shutil.rmtree(soak.folder / name, ignore_errors=True)
    soak.holds(f"{tries} commands ended as documented, {same} of them runs", not soak.failed)


KNOWN = {"case.yaml", "few.h5", "r.h5", "tables", "few-report"}


def streams(soak: Soak) -> None:
    """Every command with standard streams that are full, closed or left, in every encoding."""
    _few(soak)
    draw = random.Random(2)
    tries = 5 if soak.short else 200
    print(f"streams: {tries} draws of {len(COMMANDS)} commands, two streams and {len(ENCODINGS)} encodings")
    for _ in range(tries):
        arguments, given = draw.choice(COMMANDS), draw.choice(ENCODINGS)
        out, err = (draw.choice(("kept", "full", "closed", "left")) for _ in range(2))
        ended = with_streams(soak, arguments, out, err, given)
        _check(soak, arguments, {"out": out, "err": err, **given}, ended)
        silent = ended.returncode in (0, 141) or err != "kept"
        soak.expect(f"a message of {arguments} to {out}, {err}", silent or bool(ended.stderr))
    soak.holds(f"{tries} commands ended as documented", not soak.failed)


def with_streams(
    soak: Soak, arguments: tuple[str, ...], out: str, err: str, given: dict[str, str]
) -> subprocess.CompletedProcess[bytes]:
    """A command whose streams are full, closed, or of a reader that has gone."""
    reading, writing = os.pipe()
    os.close(reading)
    full = os.open("/dev/full", os.O_WRONLY)
    targets: dict[str, int | None] = {"kept": subprocess.PIPE, "full": full, "left": writing, "closed": None}

    def close() -> None:
        for descriptor, kind in ((1, out), (2, err)):
            if kind == "closed":
                os.close(descriptor)

    try:
        return subprocess.run(
            command(*arguments),
            cwd=soak.folder,
            env=os.environ | given,
            stdout=targets[out],
            stderr=targets[err],
            preexec_fn=close,
            check=False,
        )
    finally:
        os.close(writing)
        os.close(full)


def shortages(soak: Soak) -> None:
    """Little address space, few open files, few threads: one message, and what was finished is kept."""
    draw, _ = random.Random(3), _few(soak)
    tries = 4 if soak.short else 150
    soak.tbi("run", "case.yaml", "-o", "whole.h5", "-q", "--overwrite", *HISTORIES)
    whole = content(soak.folder / "whole.h5")
    limits: dict[str, Callable[[], tuple[int, int]]] = {
        "address space": lambda: (resource.RLIMIT_AS, draw.randint(200, 1000) << 20),
        "open files": lambda: (resource.RLIMIT_NOFILE, draw.randint(5, 40)),
    }
    print(f"shortages: {tries} draws of limits on {', '.join(limits)}")
    refused = 0
    for _ in range(tries):
        what = draw.choice(list(limits))
        kind, size = limits[what]()
        backend = ("--backend", draw.choice(("threads", "threads", "processes")))
        run = ("run", "case.yaml", "-o", "r.h5", "-q", "-j", draw.choice("124"), *HISTORIES, *backend)
        arguments = draw.choice((run, run, *COMMANDS[6:]))
        if arguments is run:
            (soak.folder / "r.h5").unlink(missing_ok=True)
        done = subprocess.run(
            command(*arguments),
            cwd=soak.folder,
            preexec_fn=lambda: resource.setrlimit(kind, (size, size)),  # noqa: B023
            capture_output=True,
            check=False,
        )
        _check(soak, arguments, {what: str(size)}, done)
        if done.returncode == 1:
            refused += 1
            lines = [line for line in done.stderr.decode().splitlines() if "compiling" not in line]
            soak.expect(f"one message from {arguments} at {what} {size}: {lines}", len(lines) == 1)
        if arguments is run:
            soak.tbi("run", "case.yaml", "-o", "r.h5", "-q", "--resume", *HISTORIES)
            soak.expect(f"the same bits after {what} {size}", content(soak.folder / "r.h5") == whole)
    soak.holds(f"{refused} of {tries} commands had too little: one message each", not soak.failed)


def interrupts(soak: Soak) -> None:
    """Ctrl-C at random moments, most of them while Python imports: 130, and not a word too much."""
    _few(soak)
    draw = random.Random(4)
    tries = 5 if soak.short else 200
    codes: dict[int, int] = {}
    print(f"interrupts: {tries} of {len(COMMANDS)} commands, at most two seconds after their start")
    for _ in range(tries):
        arguments = draw.choice(COMMANDS)
        process = subprocess.Popen(
            command(*arguments),
            cwd=soak.folder,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            start_new_session=True,
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),  # ignored in the background
        )
        time.sleep(draw.choice((0.3, 1.0, 2.0)) * draw.random() + 0.15)
        os.killpg(process.pid, signal.SIGINT)
        out, err = process.communicate()
        # Before Python has a handler, the signal itself ends it, which a shell calls 130 as well.
        code = 130 if process.returncode == -signal.SIGINT else process.returncode
        _check(soak, arguments, {}, subprocess.CompletedProcess(arguments, code, out, err))
        codes[process.returncode] = codes.get(process.returncode, 0) + 1
    soak.holds(f"{tries} commands ended as documented: {codes}", not soak.failed)


def _few(soak: Soak) -> dict[str, bytes]:
    soak.tbi("run", "case.yaml", "-o", "few.h5", "-q", "--overwrite", *FEW)
    return dict(content(soak.folder / "few.h5"))


def _check(
    soak: Soak,
    arguments: tuple[str, ...],
    given: dict[str, str],
    ended: subprocess.CompletedProcess[bytes] | subprocess.CompletedProcess[str],
) -> None:
    """An exit code that is documented, and no traceback."""
    said = ended.stderr or ""
    text = said.decode("utf-8", "replace") if isinstance(said, bytes) else said
    fine = ended.returncode in DOCUMENTED and "Traceback" not in text and "Exception ignored" not in text
    where = f"{' '.join(arguments)} under {given}"
    soak.expect(f"{where} ended with {ended.returncode}: {text[-1500:]}", fine)
