"""Standard streams that are full, closed, left by their reader, or unable to spell what is printed."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from tests.cli.commands import tbi
from tests.cluster.runs import command, content, inside

FEW = ("--set", "solver.duration=1", "--set", "sweep={velocity: [150, 160]}")
# Commands that print; `sweep`, `report`, `reproduce`, `verify`, `merge` and `submit` do it in the same way.
PRINTING = [
    *(("list",), ("schema",), ("--help",), ("--version",), ("info", "few.h5"), ("validate", "paper")),
    *(("status", "few.h5"), ("export", "few.h5", "--overwrite"), ("run", "paper", *FEW, "--overwrite")),
    *(("info", "few.h5", "--diff", "few.h5"), ("--show-completion", "bash")),
]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a small results file."""
    folder = tmp_path_factory.mktemp("streams")
    assert inside("run", "paper", *FEW, "-q", "-o", "few.h5", folder=folder).code == 0
    return folder


@contextmanager
def stream(kind: str) -> Iterator[int]:
    """A descriptor that is full, or whose reader has gone."""
    if kind == "full":
        descriptor = os.open("/dev/full", os.O_WRONLY)
    else:
        reading, descriptor = os.pipe()
        os.close(reading)
    yield descriptor
    os.close(descriptor)


def ended(folder: Path, *arguments: str, out: str = "", err: str = "") -> tuple[int, bytes, bytes]:
    """Exit code, output and messages of a command whose streams are "full", "left", "closed" or kept."""

    def close() -> None:
        for descriptor, kind in ((1, out), (2, err)):
            if kind == "closed":
                os.close(descriptor)

    with stream("full") as full, stream("left") as left:
        targets = {"full": full, "left": left, "closed": None, "": subprocess.PIPE}
        done = subprocess.run(
            command(*arguments),
            cwd=folder,
            stdout=targets[out],
            stderr=targets[err],
            preexec_fn=close,
            timeout=120,
            check=False,
        )
    return done.returncode, done.stdout or b"", done.stderr or b""


@pytest.mark.parametrize("arguments", PRINTING, ids=" ".join)
def test_output_that_is_full(folder: Path, arguments: tuple[str, ...]) -> None:
    message = b"standard output: No space left on device\n"
    assert ended(folder, *arguments, out="full") == (2, b"", message)


@pytest.mark.parametrize("unbuffered", ["", "1"])
@pytest.mark.parametrize(
    ("kind", "code", "message"), [("closed", 2, b"standard output: is closed\n"), ("left", 141, b"")]
)
def test_output_that_is_closed_or_left(
    folder: Path, kind: str, code: int, message: bytes, unbuffered: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PYTHONUNBUFFERED", unbuffered)
    assert ended(folder, "list", out=kind) == (code, b"", message)


def test_nothing_else_is_written_where_closed_streams_were(folder: Path) -> None:
    """The work is done all the same, and no file that tbi opens is standard output to a library in C."""
    run = ("run", "paper", *FEW, "-o", "closed.h5")
    assert ended(folder, *run, out="closed", err="closed") == (2, b"", b"")
    assert content(folder / "closed.h5") == content(folder / "few.h5")
    opening = (
        "import os, sys; from tbi_cli.cli.streams import set_up_streams; set_up_streams();"
        "os._exit(os.open('new', os.O_CREAT | os.O_WRONLY))"
    )
    opened = subprocess.run(
        [sys.executable, "-c", opening], cwd=folder, preexec_fn=lambda: os.closerange(0, 3), check=False
    )
    assert opened.returncode >= 3, "the descriptor of the first file"


@pytest.mark.parametrize("kind", ["full", "closed", "left"])
def test_messages_that_nobody_reads(folder: Path, kind: str) -> None:
    """They do not go to standard output instead, and do not end the work."""
    assert ended(folder, "run", "nowhere.yaml", err=kind) == (2, b"", b"")
    odd = ("--set", "train.car_body.mass=4 t")
    code, out, _ = ended(folder, "run", "paper", *FEW, *odd, "--overwrite", err=kind)
    assert code == 0
    assert b"scenarios solved" in out and b"4" in out


ENCODINGS = {
    "ascii": {"PYTHONIOENCODING": "ascii"},
    "strict": {"PYTHONIOENCODING": "ascii:strict"},
    "C": {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0", "PYTHONIOENCODING": ""},
}


@pytest.mark.parametrize("name", ENCODINGS)
def test_signs_that_an_encoding_lacks(folder: Path, name: str) -> None:
    """The micro sign of a prefix is a u, as engineers write it."""
    told = tbi("info", "few.h5", "-v", folder=folder, PYTHONIOENCODING="utf-8").out
    assert "µm" in told
    assert tbi("info", "few.h5", "-v", folder=folder, **ENCODINGS[name]).out == told.replace("µ", "u")


def test_signs_of_a_message(folder: Path) -> None:
    ascii_only = {"PYTHONIOENCODING": "ascii"}
    ended = tbi("run", "Frýba µ 桥.yaml", folder=folder, **ascii_only)
    assert ended.err.startswith("Fryba u \\u6865.yaml: no such file")
