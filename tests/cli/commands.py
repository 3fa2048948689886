"""Runs `tbi` as a user does: a process, a folder, an exit code, two streams."""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Ended:
    """How a command ended."""

    code: int
    out: str
    err: str


def tbi(*arguments: str, folder: Path, patience: float = 120, **environment: str) -> Ended:
    """Runs `python -m tbi_cli` in a folder; a traceback is never right, whatever the exit code."""
    done = subprocess.run(
        [sys.executable, "-m", "tbi_cli", *arguments],
        cwd=folder,
        env=os.environ | {"COLUMNS": "80"} | environment,
        capture_output=True,
        text=True,
        timeout=patience,
        check=False,
    )
    assert "Traceback" not in done.stderr, done.stderr
    return Ended(done.returncode, done.stdout, done.stderr)


def everything_below(folder: Path) -> dict[str, bytes]:
    """Every file below a folder and what is in it."""
    return {str(p.relative_to(folder)): p.read_bytes() for p in folder.rglob("*") if p.is_file()}
