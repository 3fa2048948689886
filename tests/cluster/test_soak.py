"""A short version of scripts/soak.py; what it leaves out has tests of its own beside this one."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path


def test_short_soak() -> None:
    script = Path(__file__).parents[2] / "scripts" / "soak.py"
    done = subprocess.run(
        [sys.executable, str(script), "--short"], capture_output=True, text=True, timeout=600, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "kills: holds" in done.stdout
    assert "disk: holds" in done.stdout
    assert "paths: holds" in done.stdout
    assert "strangers: holds" in done.stdout
