"""Group 14: trains of constant forces, solved exactly and by Runge-Kutta, and the trains HSLM-A."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from tbi_cli.verify.check import Curve, Line, Outcome, Tolerance
from tbi_cli.verify.references.hslm import hslm_a
from tbi_cli.verify.references.moving_force import critical_speed, deflection
from tbi_cli.verify.references.parameters import Array, Beam, beam_from_mapping
from tbi_cli.verify.solved import Solved, Verification

LENGTH, MODES = 20.0, 5
RATIOS = (0.0, 0.01, 1.5)
FORCES, POSITIONS = (100e3, 80e3, 120e3), (0.0, 3.3, 24.7)
# Two intervals that no entry or exit falls on; the coarse one is longer than the shortest period.
SAMPLINGS = (0.0007, 0.013)
HSLM_SPEED = 75.0


def beam(ratio: float) -> Beam:
    """The beam of these cases."""
    given = {"youngs_modulus": 30e9, "second_moment": 0.3, "mass_per_length": 10e3}
    return beam_from_mapping({**given, "damping": {"ratio": ratio}}, LENGTH, MODES)


SPEEDS = (23.7, critical_speed(beam(0.0)))
BRIDGE = """
bridge:
  length: 20 m
  modes: 5
  right: {youngs_modulus: 30 GPa, second_moment: 0.3, mass_per_length: 10 t/m, damping: {ratio: 1 %}}
"""
CASES = {
    "exact-forces": f"""
title: Three forces, solved exactly
train: {{model: axle-forces, forces: [100 kN, 80 kN, 120 kN], positions: [0, 3.3, 24.7]}}
{BRIDGE}
solver: {{method: exact, sampling: 0.001, duration: 1.3}}
sweep:
  damping: [0 %, 1 %, 150 %]
  sampling: {list(SAMPLINGS)}
  velocity: {list(SPEEDS)}
output: {{histories: {{channels: [right_midspan]}}}}
""",
    "exact-hslm-a": f"""
title: The ten trains HSLM-A, solved exactly
train: {{model: hslm-a, number: 1}}
{BRIDGE}
velocity: {HSLM_SPEED}
solver: {{method: exact, sampling: 0.01, duration: 1.1}}
sweep: {{train.number: {list(range(1, 11))}}}
output: {{histories: {{channels: [right_midspan]}}}}
""",
    # 20 m and 3.5 m are multiples of 1/4 m: at 50 m/s every entry and exit is a sample.
    "exact-order": f"""
title: Forces by Runge-Kutta, to be compared with the exact solution
train: {{model: moving-load, forces: [100 kN, 80 kN], positions: [0, 3.5]}}
{BRIDGE}
velocity: 50 m/s
solver: {{sampling: 0.005, duration: 1.2}}
sweep: {{solver.substeps: [20, 40, 80]}}
output: {{histories: {{channels: [right_midspan]}}}}
""",
}
FRYBA = "Fryba's closed form, superposed"
ROUNDING = Tolerance(
    2e-12, "rounding of the phases: eps omega_5 t = 1e-16 * 2e3 rad/s * 3 s = 6e-13 of either solution"
)
LONG = Tolerance(
    1e-11, "rounding, eps omega_5 t = 1e-16 * 2e3 rad/s * 9 s = 2e-12, of fifty forces of which few count"
)
SLOPE = Tolerance(0.05, "higher orders at the largest step")


def compare(solved: Mapping[str, Solved]) -> Outcome:
    """Any sampling, any damping, at and off the critical speed; ten long trains; Runge-Kutta's order."""
    outcome = Outcome()
    for i, ratio in enumerate(RATIOS):
        for j, sampling in enumerate(SAMPLINGS):
            for k, speed in enumerate(SPEEDS):
                h = solved["exact-forces"].history(i, j, k)
                closed = deflection(beam(ratio), FORCES, POSITIONS, speed, h["time"])
                at = "v_c" if k else f"{speed:g} m/s"
                case = f"three forces, {at}, damping {ratio:.0%}, samples {1e3 * sampling:g} ms apart"
                outcome.history(
                    case, "history of right_midspan", "m", h["right_midspan"], closed, FRYBA, ROUNDING
                )
    _hslm(outcome, solved["exact-hslm-a"])
    _order(outcome, solved["exact-order"])
    return outcome


def _hslm(outcome: Outcome, solved: Solved) -> None:
    for number in range(1, 11):
        h = solved.history(number - 1)
        positions, force = hslm_a(number)
        t, w = h["time"], h["right_midspan"]
        closed = deflection(beam(0.01), [force] * len(positions), positions, HSLM_SPEED, t)
        case = f"HSLM-A{number} at {HSLM_SPEED:g} m/s"
        outcome.history(case, "history of right_midspan", "m", w, closed, FRYBA, LONG)
        if number == 1:
            lines = (
                Line("closed form", t, closed * 1e3, reference=True),
                Line("tbi", t, w * 1e3),
            )
            outcome.curves.append(Curve(case, "time (s)", "mid-span deflection (mm)", lines))


def _order(outcome: Outcome, solved: Solved) -> None:
    substeps = solved.axis("solver_substeps")
    errors: list[float] = []
    for i in range(len(substeps)):
        h = solved.history(i)
        closed: Array = deflection(beam(0.01), (100e3, 80e3), (0.0, 3.5), 50.0, h["time"])
        errors.append(float(np.abs(h["right_midspan"] - closed).max()))
    slope = math.log(errors[0] / errors[-1]) / math.log(substeps[-1] / substeps[0])
    outcome.at_least("forces by Runge-Kutta, 50 m/s", "order", slope, 4.0, FRYBA, SLOPE)


VERIFICATION = Verification(
    14,
    "Forces solved exactly",
    "`solver: {method: exact}` against Fryba's closed form, undamped, damped and overdamped, below and at "
    "the critical speed, with samples far apart; the ten trains HSLM-A of EN 1991-2, put together once more; "
    "Runge-Kutta tends to the same with its fourth order.",
    CASES,
    compare,
)
