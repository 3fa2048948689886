"""Many processes that start at once where no kernel was ever compiled, as the tasks of an array do."""

from __future__ import annotations

import hashlib
import os
import subprocess
from pathlib import Path

from tbi_cli.integrator.kernel_cache import fingerprint
from tbi_cli.integrator.native import processor
from tests.cli.commands import tbi
from tests.cluster.runs import command, content

FEW = ("--set", "sweep={velocity: [40, 50, 60]}", "-q")


def test_eight_processes_with_an_empty_cache(folder: Path) -> None:
    """One compiles, the others wait; all work, with the same bits."""
    cache = folder / "cache"
    environment = os.environ | {"TBI_CACHE_DIR": str(cache)}

    started = [
        subprocess.Popen(
            command("run", "case.yaml", "-o", f"{number}.h5", *FEW),
            cwd=folder,
            env=environment,
            stderr=subprocess.PIPE,
        )
        for number in range(8)
    ]
    for process in started:
        _, err = process.communicate(timeout=300)
        assert (process.returncode, err) == (0, b"")
    first = content(folder / "0.h5")
    assert all(content(folder / f"{number}.h5") == first for number in range(1, 8))
    kept = sorted(file.name for file in cache.rglob("*") if file.is_file())
    assert kept == ["advance", "lock"], "the kernel that the case needs, and nothing half-written"


def test_a_damaged_kernel(folder: Path) -> None:
    """What is not what was compiled is compiled anew, not run."""
    kernel = folder / "cache" / "kernels" / fingerprint() / processor() / "advance"
    kernel.parent.mkdir(parents=True)
    kernel.write_bytes(bytes(32) + b"\x7fELF" * 1000)
    ended = tbi("run", "case.yaml", *FEW, folder=folder, TBI_CACHE_DIR=str(folder / "cache"))
    assert (ended.code, ended.err) == (0, "")
    healed = kernel.read_bytes()
    assert hashlib.sha256(healed[32:]).digest() == healed[:32]


def test_a_temporary_folder_that_anyone_can_write_to(folder: Path) -> None:
    """Code of strangers is not run: nothing is read from there, and nothing kept."""
    (folder / "occupied").write_text("")
    open_to_all = folder / f"tbi-{os.getuid()}"
    open_to_all.mkdir()
    open_to_all.chmod(0o777)
    occupied = str(folder / "occupied")
    places = {"TBI_CACHE_DIR": occupied, "XDG_CACHE_HOME": occupied, "TMPDIR": str(folder)}
    ended = tbi("run", "case.yaml", *FEW, folder=folder, **places)
    assert (ended.code, ended.err) == (0, "")
    assert not list(open_to_all.iterdir())


def test_a_cache_that_cannot_be_written(folder: Path) -> None:
    """A file where the folder should be: the next place serves."""
    (folder / "occupied").write_text("")
    home = {"TBI_CACHE_DIR": str(folder / "occupied"), "XDG_CACHE_HOME": os.environ.get("XDG_CACHE_HOME", "")}
    ended = tbi("run", "case.yaml", *FEW, folder=folder, **home)
    assert (ended.code, ended.err) == (0, "")
