"""Nothing presses on the bridge: what is a ratio to a static value is not a number, and nothing complains."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from tbi_cli.store import open_results


@pytest.mark.parametrize("contact", ["paper", "hertz"])
def test_without_gravity(contact: str, tmp_path: Path) -> None:
    """Zero and everyday gravity in one grid: the one is at rest and has no factors, the other has both."""
    path = tmp_path / "weightless.h5"
    changes = (
        f"contact={{model: {contact}}}",
        "sweep.gravity=[0, 9.81]",
        "solver={duration: 1.2}",
        "output.histories=all",
    )
    command = [sys.executable, "-W", "error", "-m", "tbi_cli", "run", "paper", "-q", "-o", str(path)]
    run = subprocess.run(
        [*command, *(part for change in changes for part in ("--set", change))],
        capture_output=True,
        text=True,
        check=False,
    )
    assert (run.returncode, run.stdout, run.stderr) == (0, "", "")
    with open_results(path) as results:
        assert (results.status == 1).all()
        for name in ("right", "left", "right_static", "left_static"):
            weightless, heavy = results.table("daf", name)
            assert np.isnan(weightless)
            assert 0.01 < heavy < 2
        for channel in (variable.name for variable in results.channels):
            peak = results.table("peak", channel)
            # A wheel without any force on its rail is not in contact, all along.
            assert peak[0] == 0 or channel.endswith("_time_aloft")
            assert np.isfinite(peak[1])
