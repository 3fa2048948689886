"""What the channels of a vehicle say of each other, and which way a body turns."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tbi_cli.verify.references.parameters import beam_from_mapping
from tbi_cli.verify.references.simple_vehicles import RigidBeam, rigid_beam_crossing
from tests.core.crossings import case_from, histories, paper

ENDS = (
    "train.front_bogie={primary: {vertical: {damping: 2e4}}}",
    "train.rear_bogie={primary: {vertical: {stiffness: 0.9e6, damping: 7e4}}}",
)


@pytest.mark.parametrize("contact", ["paper", "hertz"])
def test_wheelsets_are_between_their_bogie_and_the_rails(contact: str) -> None:
    """Newton's law for the two wheelsets of each bogie at every sample: to rounding."""
    h = histories(
        paper(
            *ENDS,
            f"contact={{model: {contact}, static_load: physical, convective: true}}",
            "track={approach: 20, irregularity: {dip: {at: -3, length: 7, depth: 3 mm, rails: right}}}",
            "velocity=61",
            "solver={sampling: 0.001, substeps: auto, duration: 1}",
            "output.histories=all",
        )
    )
    for bogie, axles in (("front", (1, 2)), ("rear", (3, 4))):
        rails = sum(h[f"wheel_{axle}_{side}_force"] for axle in axles for side in ("right", "left"))
        inertia = sum(1901.8 * (9.81 + h[f"wheelset_{axle}_y_acceleration"]) for axle in axles)
        above = h[f"{bogie}_bogie_force"]
        assert np.ptp(above) > 0.01 * np.max(above)
        assert np.max(np.abs(rails - inertia - above)) < 1e-10 * np.max(rails)


def test_a_rigid_beam_turns_its_front_down_first(tmp_path: Path) -> None:
    """Against the independent solution, pitch with its sign; ends fall on steps, and z = omega h < 0.06.

    Runge-Kutta is wrong by z^4/120 of a radian per radian: 1e-7 of it, and some more near resonance.
    """
    text = """
train:
  {model: rigid-beam, mass: 31 t, pitch_inertia: 0.7e6, support_distance: 12, stiffness: 4e6, damping: 1e5}
bridge:
  length: 30 m
  modes: 3
  right: {youngs_modulus: 30e9, second_moment: 2, mass_per_length: 12e3, damping: {ratio: 2 %}}
velocity: 40
solver: {sampling: 0.001, substeps: 1, duration: 1.5}
output: {histories: all}
"""
    h = histories(case_from(text, tmp_path))
    given = {
        "youngs_modulus": 30e9,
        "second_moment": 2.0,
        "mass_per_length": 12e3,
        "damping": {"ratio": 0.02},
    }
    vehicle = RigidBeam(31e3, 0.7e6, 12.0, 4e6, 1e5)
    reference = rigid_beam_crossing(beam_from_mapping(given, 30.0, 3), vehicle, 40.0, h["time"])
    early = (h["time"] > 0) & (h["time"] < 0.2)
    assert h["beam_pitch"][early].min() < -0.5 * np.abs(h["beam_pitch"][early]).max()
    for name in ("beam_y", "beam_pitch", "right_midspan"):
        size = np.max(np.abs(reference[name]))
        assert np.max(np.abs(h[name] - reference[name])) < 1e-5 * size, name


def test_rails_keep_their_last_level() -> None:
    """A ramp on one rail: far behind the end of the rails each wheelset is at half of its height."""
    h = histories(
        paper(
            "bridge.length=15",
            "contact.static_load=physical",
            "track={approach: 6, irregularity: {ramp: {at: 17, length: 4, height: 3 mm, rails: left}}}",
            "solver={sampling: 0.002, substeps: auto, duration: 2}",
            "output.histories=all",
        )
    )
    behind = 83.3 * h["time"] - 20.0 > 15 + 6 + 1
    assert behind.sum() > 50
    for axle in (1, 2, 3, 4):
        assert h[f"wheelset_{axle}_y"][:5] == pytest.approx(np.zeros(5), abs=1e-15)
        assert h[f"wheelset_{axle}_y"][behind] == pytest.approx(np.full(behind.sum(), 1.5e-3), rel=1e-12)
