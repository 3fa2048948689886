"""A short run of scripts/fuzz.py: broken case files end in a message, never in a traceback."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def test_broken_case_files_end_in_a_message() -> None:
    command = [sys.executable, str(ROOT / "scripts" / "fuzz.py"), "--count", "500"]
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    run = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
    assert run.returncode == 0, run.stdout + run.stderr
    assert run.stdout.startswith("500 files: ")
