"""Many processes that start at once where no kernel was ever compiled, as the tasks of an array do."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

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
    kernels = sorted(file.name.split("-")[0] for file in cache.rglob("*.nbc"))
    assert kernels == ["kernel.advance"], "those that the case needs, each compiled once"


def test_a_cache_that_cannot_be_written(folder: Path) -> None:
    """A file where the folder should be: the next place serves."""
    (folder / "occupied").write_text("")
    home = {"TBI_CACHE_DIR": str(folder / "occupied"), "XDG_CACHE_HOME": os.environ.get("XDG_CACHE_HOME", "")}
    ended = tbi("run", "case.yaml", *FEW, folder=folder, **home)
    assert (ended.code, ended.err) == (0, "")
