"""Which channels decide on the speeds of a refined sweep where nothing is said: those of both beams."""

from __future__ import annotations

from pathlib import Path

import h5py

from tbi_cli.runner import Options, run
from tests.core.crossings import paper

STIFF = "{youngs_modulus: 207e9, second_moment: 2.2, mass_per_length: 12e3, damping: {ratio: 3 %}}"
SOFT = "{youngs_modulus: 207e9, second_moment: 0.09, mass_per_length: 12e3, damping: {ratio: 0.6 %}}"
CHANNELS = [f"{side}_midspan{what}" for what in ("_acceleration", "") for side in ("left", "right")]


def test_both_beams_decide(tmp_path: Path) -> None:
    """The left one is soft and little damped: it takes more speeds than the right one."""
    speeds = []
    for channels in ("", f", channels: {CHANNELS}".replace("'", ""), ", channels: [right_midspan]"):
        case = paper(
            f"bridge={{length: 24, modes: 1, right: {STIFF}, left: {SOFT}}}",
            "contact.static_load=physical",
            "sweep={velocity: {from: 50, to: 90, step: 10, refine: resonance, tolerance: 5 %"
            f"{channels}}}}}",
            "solver={sampling: 0.004, duration: 1}",
        )
        path = run(case, Options(output=tmp_path / "r.h5", overwrite=True)).path
        with h5py.File(path) as file:
            speeds.append(file["velocity"][...].tolist())
    assert speeds[0] == speeds[1]
    assert len(speeds[0]) > len(speeds[2])
