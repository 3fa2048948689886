"""Short runs of scripts/fuzz.py: broken case files and keys at their ends, never a traceback."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


def fuzzed(*arguments: str) -> str:
    """What scripts/fuzz.py says at its end."""
    command = [sys.executable, str(ROOT / "scripts" / "fuzz.py"), *arguments]
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    run = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
    assert run.returncode == 0, run.stdout + run.stderr
    return run.stdout


@pytest.mark.parametrize(("of", "what"), [([], "files"), (["--tables"], "tables")], ids=["files", "tables"])
def test_broken_files_end_in_a_message(of: list[str], what: str) -> None:
    """And whole tables are read as what they say, whatever form they have."""
    assert fuzzed("--count", "250", *of).startswith(f"250 {what}: ")


def test_keys_at_their_ends() -> None:
    """A sample of them; zeros and largest values are solved, planned, or end in a message."""
    assert fuzzed("--engine", "ends", "--count", "80").startswith("80 of ")
