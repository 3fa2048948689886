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


def test_the_order_of_the_axes_does_not_matter(tmp_path: Path) -> None:
    """Dampings and masses of a beam ahead of the velocity or behind it: the same speeds, the same numbers."""
    velocity = "velocity: {from: 50, to: 90, step: 10, refine: resonance, tolerance: 10 %}"
    damping, mass = "damping: [1 %, 2 %, 4 %]", "bridge.right.mass_per_length: [11e3, 12e3]"
    found = []
    for axes in ((velocity, damping, mass), (damping, velocity, mass), (mass, damping, velocity)):
        case = paper(
            "train={model: hslm-a, number: 4}",
            f"bridge={{length: 24, modes: 1, right: {SOFT}}}",
            "contact={model: paper}",
            f"sweep={{{', '.join(axes)}}}",
            "solver={method: exact, sampling: 0.01, duration: 1}",
        )
        path = run(case, Options(output=tmp_path / "r.h5", overwrite=True)).path
        names = [axis.partition(":")[0].replace(".", "_") for axis in axes]
        order = [names.index(name) for name in ("velocity", "damping", "bridge_right_mass_per_length")]
        with h5py.File(path) as file:
            peaks = file["peak/right_midspan"][...].transpose(order)
            found.append((file["velocity"][...].tolist(), peaks.tobytes()))
    assert len(found[0][0]) > 20
    assert found[0] == found[1] == found[2]
