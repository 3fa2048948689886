"""Group 1: the paper's verification cases (section 3.1) and their moving-force companions."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tbi_cli.verify.check import Curve, Line, Outcome, Tolerance
from tbi_cli.verify.references.moving_force import deflection
from tbi_cli.verify.references.parameters import STANDARD_GRAVITY, Array, Beam, beam_from_mapping
from tbi_cli.verify.references.simple_vehicles import (
    RigidBeam,
    SprungMass,
    rigid_beam_crossing,
    sprung_mass_crossing,
)
from tbi_cli.verify.solved import Solved, Verification

VELOCITY = 27.78
MODES = (1, 4)
ELASTICITIES = (2.943e9, 29.43e9)
WEIGHT_1, WEIGHT_2 = 5750.0 * STANDARD_GRAVITY, 540e3 * STANDARD_GRAVITY

# Mid-span peaks [mm] with the vehicle and under constant forces, from an independent implementation.
PEAKS_1 = {1: (2.3840, 2.3766), 4: (2.4080, 2.3966)}
PEAKS_2 = {
    (2.943e9, 1): (82.63, 91.79),
    (2.943e9, 4): (84.29, 92.36),
    (29.43e9, 1): (7.911, 8.137),
    (29.43e9, 4): (7.888, 8.020),
}

SPRUNG_MASS = "{model: sprung-mass, mass: 5750, stiffness: 1595 kN/m, damping: 0}"
FORCE = f"{{model: moving-load, forces: [{WEIGHT_1!r}], positions: [0]}}"
RIGID_BEAM = (
    "{model: rigid-beam, mass: 540 t, pitch_inertia: 13.8e6, support_distance: 17.5, "
    "stiffness: 41.35e6, damping: 0}"
)
FORCES = f"{{model: moving-load, forces: [{WEIGHT_2 / 2!r}, {WEIGHT_2 / 2!r}], positions: [0, 17.5]}}"


def _case_1(title: str, train: str, channels: str) -> str:
    # 900 samples over the span: the exit falls on one
    return f"""
title: Verification case 1, {title}
train: {train}
bridge:
  length: 25 m
  right: {{youngs_modulus: 2.87 GPa, second_moment: 2.9, mass_per_length: 2303, damping: 0}}
velocity: 27.78 m/s
solver: {{sampling: {25.0 / VELOCITY / 900!r}, substeps: 8, duration: 1.5}}
sweep: {{modes: [1, 4]}}
output: {{histories: {{channels: [{channels}]}}}}
"""


def _case_2(title: str, train: str, channels: str) -> str:
    # 100 samples over 2.5 m, of which the span and the supports' distance are multiples
    return f"""
title: Verification case 2, {title}
train: {train}
bridge:
  length: 30 m
  right: {{youngs_modulus: 2.943 GPa, second_moment: 8.65, mass_per_length: 36 t/m, damping: 0}}
velocity: 27.78 m/s
solver: {{sampling: {2.5 / VELOCITY / 100!r}, substeps: 8, duration: 1.25}}
sweep:
  bridge.right.youngs_modulus: [2.943 GPa, 29.43 GPa]
  modes: [1, 4]
output: {{histories: {{channels: [{channels}]}}}}
"""


CASES = {
    "sprung-mass": _case_1("sprung mass", SPRUNG_MASS, "right_midspan, sprung_mass_y"),
    "sprung-mass-force": _case_1("moving force", FORCE, "right_midspan"),
    "rigid-beam": _case_2("suspended rigid beam", RIGID_BEAM, "right_midspan, beam_y, beam_pitch"),
    "rigid-beam-forces": _case_2("moving forces", FORCES, "right_midspan"),
}

INDEPENDENT = "an independent implementation"
DOP853 = "modal equations, DOP853 to 1e-10"
FRYBA = "Fryba's closed form"
PEAK = Tolerance(
    2e-4, "half of the last digit given, 6e-5, and a peak missed by half a sample, (omega_1 dt)^2/8 = 1.1e-4"
)
HISTORY = Tolerance(
    2e-8,
    "Runge-Kutta's phase error in the free vibration of the fourth mode: omega T (omega h)^4/120 = 7e-5 of "
    "its share, 1.1e-4 of the peak; doubled",
)


def compare(solved: Mapping[str, Solved]) -> Outcome:
    """Peaks against the independent numbers; histories against the semi-analytical solutions."""
    outcome = Outcome()
    for j, n in enumerate(MODES):
        _compare_case_1(outcome, solved, j, n)
    for i, E in enumerate(ELASTICITIES):
        for j, n in enumerate(MODES):
            _compare_case_2(outcome, solved, (i, j), E, n)
    return outcome


def _modes(n: int) -> str:
    return "1 mode" if n == 1 else f"{n} modes"


def _beam(length: float, E: float, second_moment: float, mu: float, n: int) -> Beam:
    given = {"youngs_modulus": E, "second_moment": second_moment, "mass_per_length": mu}
    return beam_from_mapping(given, length, n)


def _compare_case_1(outcome: Outcome, solved: Mapping[str, Solved], j: int, n: int) -> None:
    beam = _beam(25.0, 2.87e9, 2.9, 2303.0, n)
    vehicle, force = solved["sprung-mass"].history(j), solved["sprung-mass-force"].history(j)
    case = f"case 1, {_modes(n)}"
    for name, h, peak in (
        ("sprung mass", vehicle, PEAKS_1[n][0]),
        ("moving force", force, PEAKS_1[n][1]),
    ):
        ours = float(np.abs(h["right_midspan"]).max()) * 1e3
        outcome.number(case, f"{name}: mid-span peak", "mm", ours, peak, INDEPENDENT, PEAK)
    reference = sprung_mass_crossing(beam, SprungMass(5750.0, 1595e3), VELOCITY, vehicle["time"])
    for name in ("right_midspan", "sprung_mass_y"):
        quantity = f"sprung mass: history of {name}"
        outcome.history(case, quantity, "m", vehicle[name], reference[name], DOP853, HISTORY)
    closed = deflection(beam, [WEIGHT_1], [0.0], VELOCITY, force["time"])
    quantity = "moving force: history of right_midspan"
    outcome.history(case, quantity, "m", force["right_midspan"], closed, FRYBA, HISTORY)
    if n == MODES[-1]:
        outcome.curves.append(
            _curve("Case 1, four modes", "sprung mass", vehicle, reference["right_midspan"], force, closed)
        )


def _compare_case_2(
    outcome: Outcome, solved: Mapping[str, Solved], index: tuple[int, int], E: float, n: int
) -> None:
    beam = _beam(30.0, E, 8.65, 36e3, n)
    vehicle, force = solved["rigid-beam"].history(*index), solved["rigid-beam-forces"].history(*index)
    case = f"case 2, E = {E / 1e9:g} GPa, {_modes(n)}"
    for name, h, peak in (
        ("rigid beam", vehicle, PEAKS_2[E, n][0]),
        ("moving forces", force, PEAKS_2[E, n][1]),
    ):
        ours = float(np.abs(h["right_midspan"]).max()) * 1e3
        outcome.number(case, f"{name}: mid-span peak", "mm", ours, peak, INDEPENDENT, PEAK)
    reference = rigid_beam_crossing(beam, RigidBeam(540e3, 13.8e6, 17.5, 41.35e6), VELOCITY, vehicle["time"])
    for name, units in (("right_midspan", "m"), ("beam_y", "m"), ("beam_pitch", "rad")):
        quantity = f"rigid beam: history of {name}"
        outcome.history(case, quantity, units, vehicle[name], reference[name], DOP853, HISTORY)
    closed = deflection(beam, [WEIGHT_2 / 2] * 2, [0.0, 17.5], VELOCITY, force["time"])
    quantity = "moving forces: history of right_midspan"
    outcome.history(case, quantity, "m", force["right_midspan"], closed, FRYBA, HISTORY)
    if n == MODES[-1]:
        title = f"Case 2, four modes, E = {E / 1e9:g} GPa"
        outcome.curves.append(_curve(title, "rigid beam", vehicle, reference["right_midspan"], force, closed))


def _curve(
    title: str,
    name: str,
    vehicle: Mapping[str, Array],
    reference: Array,
    force: Mapping[str, Array],
    closed: Array,
) -> Curve:
    t = vehicle["time"]
    return Curve(
        f"{title}: mid-span deflection",
        "time (s)",
        "deflection (mm)",
        (
            Line(f"{name}, DOP853", t, reference * 1e3, reference=True),
            Line(f"{name}, tbi", t, vehicle["right_midspan"] * 1e3),
            Line("constant force, closed form", t, closed * 1e3, reference=True),
            Line("constant force, tbi", t, force["right_midspan"] * 1e3),
        ),
    )


VERIFICATION = Verification(
    1,
    "Sprung mass and suspended rigid beam",
    "The paper's verification cases (section 3.1) and the same loads as constant forces, with one and with "
    "four modes; case 2 for both readings of Young's modulus.",
    CASES,
    compare,
)
