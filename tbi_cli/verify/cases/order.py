"""Group 7: the order of the integrator, convergence over modes, and the sampling study of Table 4."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tbi_cli.verify.cases.full_train import LOPSIDED, changed, text
from tbi_cli.verify.cases.moving_force import FORCE, LENGTH, V_C, beam
from tbi_cli.verify.check import Curve, Line, Outcome, Tolerance
from tbi_cli.verify.references.crossing import CoupledSystem, crossing_channels
from tbi_cli.verify.references.moving_force import deflection
from tbi_cli.verify.references.parameters import Array, crossing_from_case
from tbi_cli.verify.solved import Solved, Verification

SUBSTEPS = (1, 2, 4, 8)
FORCE_SAMPLING = LENGTH / V_C / 50
TRAIN_SAMPLING = 5e-3
MODES = tuple(range(1, 20, 2))
MODES_ALPHA = 0.25
SAMPLINGS = (0.2, 0.1, 0.01, 0.001)
KMH = (50.0, 300.0)
STUDY = {"contact.static_load": "paper", "solver.duration": 5.0, "solver.substeps": "auto"}

FORCE_CASE = """
title: {title}
train: {{model: moving-load, forces: [100 kN], positions: [0]}}
bridge:
  length: 20 m
  modes: 3
  right: {{youngs_modulus: 30 GPa, second_moment: 0.3, mass_per_length: 10 t/m, damping: {{ratio: 2 %}}}}
velocity: {velocity!r}
solver: {{sampling: {sampling!r}, substeps: {substeps}, duration: {duration}}}
sweep: {{{axis}}}
output: {{histories: {{channels: [right_midspan]}}}}
"""
CASES = {
    "order-force": FORCE_CASE.format(
        title="Order over the substeps",
        velocity=0.5 * V_C,
        sampling=FORCE_SAMPLING,
        substeps=1,
        duration=1.5,
        axis=f"solver.substeps: {list(SUBSTEPS)}",
    ),
    "order-train": text(
        changed(
            {
                **LOPSIDED,
                "solver": {"sampling": TRAIN_SAMPLING, "substeps": 1, "duration": 1.5},
                "sweep": {"solver.substeps": list(SUBSTEPS)},
            }
        ),
        "Order over the substeps, full train with unequal ends",
    ),
    "order-modes": FORCE_CASE.format(
        title="Convergence over modes",
        velocity=MODES_ALPHA * V_C,
        sampling=LENGTH / V_C / 250,
        substeps=16,
        duration=1,
        axis=f"modes: {list(range(1, 21))}",
    ),
    "order-sampling": text(
        changed(
            {
                **STUDY,
                "sweep": {"velocity": [f"{v:g} km/h" for v in KMH], "sampling": list(SAMPLINGS)},
                "output": {"histories": "none"},
            }
        ),
        "Sampling study of Table 4",
    ),
}
CHANNELS = (
    "right_midspan",
    "left_midspan",
    "car_body_y",
    "car_body_pitch",
    "car_body_roll",
    "front_bogie_y_acceleration",
    "rear_bogie_roll",
    "wheelset_2_z",
    "wheel_1_right_force",
)


ORACLE = "31-DOF crossing, DOP853"
FOURTH = Tolerance(
    0.05, "higher-order terms at the largest step, omega h = 0.5 of the fastest mode: (omega h)^2/6"
)
LEFT_OUT = Tolerance(
    0.035,
    "of mode 3, the first left out: amplification (alpha/3)^2 = 0.7 % at alpha = 0.25, and free "
    "vibration alpha/3 damped to a third, 2.7 %",
)
THIRD = Tolerance(0.03, "the static tail has slope -2.96 over these modes; dynamics add (alpha/i)^2")
BITS = Tolerance(1e-12, "rounding: the modes of a constant force are independent")
RMS = Tolerance(
    1e-6,
    "auto substeps: omega h <= 0.3, phase error 7e-5 per radian of modes that hold 1e-3 of the RMS, damped",
)


def compare(solved: Mapping[str, Solved]) -> Outcome:
    """Slopes of the error over steps and over modes; RMS at four sampling intervals."""
    outcome = Outcome()
    _force_order(outcome, solved["order-force"])
    _train_order(outcome, solved["order-train"])
    _modes(outcome, solved["order-modes"])
    _sampling(outcome, solved["order-sampling"])
    return outcome


def _slope(x: Array, y: Array) -> float:
    return float(np.polyfit(np.log(x), np.log(y), 1)[0])


def _force_order(outcome: Outcome, solved: Solved) -> None:
    errors, steps = [], FORCE_SAMPLING / np.array(SUBSTEPS)
    for i in range(len(SUBSTEPS)):
        h = solved.history(i)
        closed = deflection(beam(3, 0.02), [FORCE], [0.0], 0.5 * V_C, h["time"])
        errors.append(float(np.abs(h["right_midspan"] - closed).max() / np.abs(closed).max()))
    _order_check(outcome, "moving force, 3 modes", steps, np.array(errors), "Fryba's closed form")


def _train_order(outcome: Outcome, solved: Solved) -> None:
    histories = [solved.history(i) for i in range(len(SUBSTEPS))]
    t = histories[0]["time"]
    reference = crossing_channels(solved.case, t)
    for name in CHANNELS:
        scale = np.abs(reference[name]).max()
        errors = [np.abs(h[name] - reference[name]).max() / scale for h in histories]
        steps = TRAIN_SAMPLING / np.array(SUBSTEPS)
        _order_check(outcome, f"31-DOF train, {name}", steps, np.array(errors), ORACLE)


def _order_check(outcome: Outcome, case: str, steps: Array, errors: Array, source: str) -> None:
    slope = _slope(steps, errors)
    outcome.at_least(case, "slope of the error over the step", slope, 4.0, f"order of RK4; {source}", FOURTH)
    guide = errors[-1] * (steps / steps[-1]) ** 4
    outcome.curves.append(
        Curve(
            f"Error over the step: {case}",
            "step (s)",
            "largest error / largest value",
            (Line("fourth order", steps, guide, reference=True), Line("tbi", steps, errors)),
            logarithmic=True,
        )
    )


def _modes(outcome: Outcome, solved: Solved) -> None:
    """With n modes the deflection lacks the odd modes above n: sum of i^-4, about n^-3 / 6.

    With the force at mid-span every mode left out is at its largest, near its static share.
    """
    t = solved.history(0)["time"]
    full = deflection(beam(400, 0.02), [FORCE], [0.0], MODES_ALPHA * V_C, t)
    static = FORCE * LENGTH**3 / (48 * beam(1).EI) / float(np.abs(full).max())
    w = [solved.history(n - 1)["right_midspan"] for n in range(1, 21)]
    errors = np.array([float(np.abs(w[n - 1] - full).max() / np.abs(full).max()) for n in MODES])
    for n, error in zip(MODES, errors, strict=True):
        if n in (1, 3, 19):
            tail = sum(i**-4.0 for i in range(n + 2, 401, 2)) * 96 / np.pi**4 * static
            case, quantity = f"{n} mode{'s' * (n > 1)}", "largest error of right_midspan over its peak"
            outcome.number(
                case, quantity, "1", float(error), tail, "static share of the modes left out", LEFT_OUT
            )
    even = max((2 * m for m in range(1, 11)), key=lambda m: np.abs(w[m - 1] - w[m - 2]).max())
    quantity, source = "right_midspan (worst of 2, 4, .. 20)", "an even mode is still at mid-span"
    outcome.history(f"{even} modes", quantity, "m", w[even - 1], w[even - 2], source, BITS)
    x = np.array(MODES) + 1.0
    slope = _slope(x[2:], errors[2:])
    quantity, source = "slope of the error over the modes + 1", "sum of i^-4 over odd i > n"
    outcome.number("5 to 19 modes", quantity, "1", slope, -3.0, source, THIRD)
    outcome.curves.append(
        Curve(
            "Error over the modes: mid-span deflection under a force",
            "modes + 1",
            "largest error / largest deflection",
            (Line("third order", x, errors[-1] * (x / x[-1]) ** -3, reference=True), Line("tbi", x, errors)),
            logarithmic=True,
        )
    )


def _sampling(outcome: Outcome, solved: Solved) -> None:
    finest = SAMPLINGS[-1]
    for i, kmh in enumerate(KMH):
        crossing = crossing_from_case(changed({**STUDY, "velocity": kmh / 3.6}))
        window = 5 * 70 / crossing.velocity
        t = np.arange(0.0, int(window / finest + 1e-9) + 1) * finest
        system = CoupledSystem(crossing)
        reference = system.displacements(system.integrate(t)[0])
        for channel in ("right_midspan", "car_body_y"):
            for j, sampling in enumerate(SAMPLINGS):
                every, last = round(sampling / finest), int(window / sampling + 1e-9)
                samples = reference[channel][: last * every + 1 : every]
                rms = float(np.sqrt(np.mean(samples**2)))
                ours = float(solved.table("rms", channel)[i, j])
                case, source = f"{kmh:g} km/h, sampling {sampling:g} s", f"{ORACLE}, same samples"
                outcome.number(case, f"RMS of {channel}", "m", ours, rms, source, RMS)


VERIFICATION = Verification(
    7,
    "Order of the integrator, modes and sampling",
    "Runge-Kutta's error falls with the fourth power of the step where events fall on steps; the mid-span "
    "deflection converges with the third power of the number of modes; RMS values at the sampling intervals "
    "of Table 4.",
    CASES,
    compare,
)
