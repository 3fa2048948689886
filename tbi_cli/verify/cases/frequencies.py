"""Group 5: natural frequencies of the train on rigid track and of the beams; Tables 2 and 5."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from tbi_cli.verify.assembled import assembled
from tbi_cli.verify.cases.full_train import CASE, LOPSIDED, changed, text
from tbi_cli.verify.check import Curve, Line, Outcome, Tolerance
from tbi_cli.verify.references.frequencies import (
    TABLE_2_MODE_4,
    TABLE_5,
    body_bounce,
    body_pitch,
    body_roll,
    sprung_mass_bounce,
    vehicle_frequencies,
)
from tbi_cli.verify.references.parameters import Array, crossing_from_case
from tbi_cli.verify.solved import Solved, Verification

MASS, STIFFNESS = 5750.0, 1595e3
SPRUNG_MASS = f"""
title: Bounce of a sprung mass after it has left the bridge
train: {{model: sprung-mass, mass: {MASS!r}, stiffness: {STIFFNESS!r}, damping: 0}}
bridge:
  length: 25 m
  right: {{youngs_modulus: 2.87 GPa, second_moment: 2.9, mass_per_length: 2303, damping: 0}}
velocity: 25 m/s
solver: {{sampling: 0.001, substeps: 4, duration: 4}}
output: {{histories: {{channels: [sprung_mass_y]}}}}
"""
CASES = {"bounce": SPRUNG_MASS}
STIFF = (1e8, 1e9, 1e10)
EIGEN = "generalised eigenvalues, assembled from Eqs. (1a, b)"
ROUNDING = Tolerance(
    1e-12, "rounding of an eigenvalue solution: 1e-16 of the largest eigenvalue, some ten times over"
)
FREE = Tolerance(
    1e-6, "a zero eigenvalue is good to 1e-15 of the largest, its root to 3e-8, some ten times over"
)
BOUNCE = Tolerance(
    1e-9, "phase error omega T (omega h)^4/120 = 2e-11 and loss omega T (omega h)^5/144, over 3 s"
)
STIFF_ERROR = Tolerance(
    5.2e-5, "first order in the stiffness of the secondary over the primary springs, 5.2e-5"
)
STIFF_SLOPE = Tolerance(
    0.01, "second-order terms at the softest primary spring, 5.2e-3 of the first-order ones"
)
TABLE_2 = Tolerance(4e-5, "half of the last of five digits")


def compare(solved: Mapping[str, Solved]) -> Outcome:
    """The train's frequencies, those of its body in closed form, the beams' and the critical velocities."""
    outcome = Outcome()
    _train(outcome)
    _bounce(outcome, solved["bounce"])
    _stiff_bogies(outcome)
    _tables(outcome)
    return outcome


def _ours(changes: Mapping[str, object]) -> Array:
    """Natural frequencies [rad/s] of the package's own matrices, the train on rigid track."""
    system = assembled(text(changed(changes), "frequencies"))
    scale = 1 / np.sqrt(system.M)
    squares = np.linalg.eigvalsh(system.K * np.outer(scale, scale))
    frequencies: Array = np.sqrt(np.clip(squares, 0.0, None))
    return frequencies


def _train(outcome: Outcome) -> None:
    for name, changes in (("paper's train", {}), ("train with unequal ends", LOPSIDED)):
        case = f"{name} on rigid track"
        reference, ours = vehicle_frequencies(crossing_from_case(changed(changes)).train), _ours(changes)
        outcome.history(case, "24 natural frequencies", "rad/s", ours[3:], reference[3:], EIGEN, ROUNDING)
        quantity = "sideways, yaw and roll of the whole train / largest frequency"
        source = "nothing holds them: no creep forces, wheelsets free to roll"
        outcome.zero(case, quantity, "rad/s", ours[:3], float(ours[-1]), source, FREE)


def _bounce(outcome: Outcome, solved: Solved) -> None:
    """Fit the closed form's free vibration to what follows the exit: what is left over is the error."""
    h = solved.history()
    after = h["time"] >= 1.0
    t, y = h["time"][after] - 1.0, h["sprung_mass_y"][after]
    omega = sprung_mass_bounce(MASS, STIFFNESS)
    basis = np.stack([np.cos(omega * t), np.sin(omega * t)], axis=1)
    fitted = basis @ np.linalg.lstsq(basis, y, rcond=None)[0]
    case = "sprung mass after its exit"
    outcome.history(case, "free vibration at sqrt(k/m)", "m", y, fitted, "closed form", BOUNCE)


def _stiff_bogies(outcome: Outcome) -> None:
    errors: dict[str, list[float]] = {}
    for stiffness in STIFF:
        changes: dict[str, object] = {
            "train.primary.vertical": {"stiffness": stiffness, "damping": 0.0},
            "train.geometry.car_body_to_secondary": 0.0,
            "train.geometry.secondary_to_bogie": 0.0,
            "train.geometry.bogie_to_axle": 0.0,
        }
        train, ours = crossing_from_case(changed(changes)).train, _ours(changes)
        for name, value in (
            ("bounce", body_bounce(train)),
            ("pitch", body_pitch(train)),
            ("roll", body_roll(train)),
        ):
            errors.setdefault(name, []).append(float(np.min(np.abs(ours / value - 1))))
    case = "body on stiff bogies"
    for name, values in errors.items():
        quantity = f"{name}: relative error at k = {STIFF[-1]:g} N/m"
        outcome.zero(case, quantity, "1", values[-1], 1.0, "closed form", STIFF_ERROR)
        slope = float(np.polyfit(np.log(STIFF), np.log(values), 1)[0])
        quantity = f"{name}: slope of the error over the stiffness"
        outcome.number(case, quantity, "1", slope, -1.0, "first order in 1/k", STIFF_SLOPE)
    x = np.array(STIFF)
    outcome.curves.append(
        Curve(
            "Body on stiff bogies: error of the closed forms",
            "primary stiffness (N/m)",
            "relative error of the frequency",
            (
                Line("1/k", x, errors["bounce"][0] * x[0] / x, reference=True),
                *(Line(name, x, np.array(values)) for name, values in errors.items()),
            ),
            logarithmic=True,
        )
    )


def _tables(outcome: Outcome) -> None:
    system = assembled(text(CASE, "Table 2"))
    for beam, (side, (frequency, velocity)) in zip(system.beams, TABLE_2_MODE_4.items(), strict=True):
        f_4 = float(beam.omega[3]) / (2 * math.pi)
        case = f"Table 2, {side} beam"
        outcome.number(case, "f4", "Hz", f_4, frequency, "Table 2", TABLE_2)
        source = "Table 2" + (" (prints 299.745, a misprint)" if side == "left" else "")
        outcome.number(case, "v_cr4", "m/s", f_4 * system.axle_distance, velocity, source, TABLE_2)
    for length, velocities in TABLE_5.items():
        system = assembled(text(changed({"bridge.length": length}), "Table 5"))
        ours = system.axle_distance * system.beams[1].omega / (2 * math.pi)
        for j, velocity in enumerate(velocities):
            tolerance = Tolerance(
                0.007 / velocity,
                "half of the last digit, 0.005 m/s, and frequencies cut off after four decimals, 20 m "
                "x 0.0001 Hz",
            )
            outcome.number(
                f"Table 5, L = {length:g} m",
                f"v_cr{j + 1}",
                "m/s",
                float(ours[j]),
                velocity,
                "Table 5",
                tolerance,
            )


VERIFICATION = Verification(
    5,
    "Frequencies and critical velocities",
    "The assembled train on rigid track against an independent eigenvalue solution and closed forms; the "
    "beams against Tables 2 and 5 of the paper.",
    CASES,
    compare,
)
