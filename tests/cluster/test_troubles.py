"""What may happen to the place where results go: one message, nothing lost that was there before."""

from __future__ import annotations

import os
import resource
import shutil
import signal
import subprocess
import time
from collections.abc import Iterator, Mapping
from pathlib import Path

import pytest

from tests.cli.commands import everything_below
from tests.cluster.runs import ENDLESS, command, content, inside, parts, start

SECONDS = 300.0


def limited(folder: Path, kilobytes: int, *arguments: str) -> subprocess.CompletedProcess[str]:
    """A tbi process that may write no file larger than that."""

    def limit() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (1024 * kilobytes, 1024 * kilobytes))
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)

    return subprocess.run(
        command(*arguments), cwd=folder, preexec_fn=limit, capture_output=True, text=True, check=False
    )


@pytest.mark.parametrize("kilobytes", [1, 60, 700])
def test_a_limit_on_file_size(folder: Path, whole: Mapping[str, bytes], kilobytes: int) -> None:
    """In the layout, in a part, in the results file: a resumed run without the limit ends well."""
    ended = limited(folder, kilobytes, "run", "case.yaml", "-q", "-j", "1")
    assert ended.returncode == 2
    assert "File too large" in ended.stderr
    assert ended.stderr.count("\n") == 1
    assert not (folder / "results.h5").exists()
    assert inside("run", "case.yaml", "-q", "--resume", folder=folder).code == 0
    assert content(folder / "results.h5") == whole
    assert sorted(path.name for path in folder.iterdir()) == ["case.yaml", "results.h5"]


def test_an_older_file_outlives_a_full_disk(folder: Path) -> None:
    """--overwrite replaces it when the new one is complete, not before."""
    few = ("--set", "sweep={velocity: [40, 50, 60]}", "-q")
    assert inside("run", "case.yaml", *few, folder=folder).code == 0
    before = (folder / "results.h5").read_bytes()
    ended = limited(folder, 700, "run", "case.yaml", "-q", "--overwrite")
    assert ended.returncode == 2
    assert (folder / "results.h5").read_bytes() == before


@pytest.mark.parametrize("what", ["folder", "parts"])
def test_the_output_folder_vanishes(folder: Path, what: str) -> None:
    (folder / "out").mkdir()
    process = start("run", "case.yaml", "-o", "out/results.h5", *ENDLESS, folder=folder)
    end = time.monotonic() + SECONDS
    while not parts(folder / "out" / "results.h5"):
        assert time.monotonic() < end
        time.sleep(0.02)
    gone = folder / "out" if what == "folder" else folder / "out" / "results.h5.parts"
    while gone.exists():  # the run may be just adding a file
        shutil.rmtree(gone, ignore_errors=True)
    out, err = process.communicate(timeout=SECONDS)
    assert process.returncode == 2, err
    message = f"{folder / 'out' / 'results.h5.parts'}: was removed or taken over while the run went on\n"
    assert "".join(line for line in err.splitlines(keepends=True) if "scenarios," not in line) == message
    assert out == ""


@pytest.fixture
def read_only(folder: Path) -> Iterator[Path]:
    """A folder in which nothing can be made; root may write wherever the file system itself allows it."""
    out = folder / "out"
    out.mkdir()
    if os.geteuid() != 0:
        out.chmod(0o500)
        yield out
        return
    mount = ["mount", "-t", "tmpfs", "-o", "ro,size=1m", "tmpfs", str(out)]
    done = subprocess.run(mount, capture_output=True, text=True, check=False)
    if done.returncode:
        pytest.skip(f"cannot mount a read-only file system here: {done.stderr.strip()}")
    yield out
    subprocess.run(["umount", str(out)], check=True)


def refused(folder: Path, message: str) -> None:
    """One message before anything is solved."""
    before = everything_below(folder)
    ended = inside("run", "case.yaml", "-o", "out/results.h5", folder=folder)
    assert (ended.code, ended.out) == (2, "")
    assert ended.err == f"{folder / 'out' / 'results.h5'}: {message}\n"
    assert everything_below(folder) == before


def test_a_read_only_folder(folder: Path, read_only: Path) -> None:
    refused(folder, f"the folder {read_only} cannot be written to")


def test_no_folder(folder: Path) -> None:
    refused(folder, f"the folder {folder / 'out'} does not exist")
    (folder / "out").touch()
    refused(folder, f"{folder / 'out'} is not a folder")
