"""A short run of scripts/fuzz.py: broken case files end in a message, never in a traceback."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.parametrize(("of", "what"), [([], "files"), (["--tables"], "tables")], ids=["files", "tables"])
def test_broken_files_end_in_a_message(of: list[str], what: str) -> None:
    """And whole tables are read as what they say, whatever form they have."""
    command = [sys.executable, str(ROOT / "scripts" / "fuzz.py"), "--count", "500", *of]
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    run = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
    assert run.returncode == 0, run.stdout + run.stderr
    assert run.stdout.startswith(f"500 {what}: ")
