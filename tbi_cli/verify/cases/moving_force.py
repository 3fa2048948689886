"""Group 2: a constant force on a simply supported beam against Fryba's closed form."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from tbi_cli.verify.check import Curve, Line, Outcome, Tolerance
from tbi_cli.verify.references.moving_force import cancellation_speed, critical_speed, deflection
from tbi_cli.verify.references.parameters import Array, Beam, beam_from_mapping
from tbi_cli.verify.solved import Solved, Verification

LENGTH, FORCE = 20.0, 100e3
MODES = (1, 20)
RATIOS = (0.0, 0.02)
SPEEDS = (0.1, 0.25, 0.5, 0.617, 1.0, 2.0)
CANCELLATIONS = (1, 2, 3)


def beam(n: int, ratio: float = 0.0) -> Beam:
    """The beam of these cases with n modes."""
    given = {
        "youngs_modulus": 30e9,
        "second_moment": 0.3,
        "mass_per_length": 10e3,
        "damping": {"ratio": ratio},
    }
    return beam_from_mapping(given, LENGTH, n)


V_C = critical_speed(beam(1))
# The time of crossing at v_c is 1234 samples, so it is a whole number of samples at every one of SPEEDS.
SAMPLING = LENGTH / V_C / 1234
STILL_SAMPLING = LENGTH / V_C / 1000
SUBSTEPS, DURATION = 4, 1.5

TEMPLATE = """
title: Moving force, {title}
train: {{model: moving-load, forces: [100 kN], positions: [0]}}
bridge:
  length: 20 m
  modes: 1
  right: {{youngs_modulus: 30 GPa, second_moment: 0.3, mass_per_length: 10 t/m, damping: {{ratio: 0 %}}}}
velocity: {velocity!r}
solver: {{sampling: {sampling!r}, substeps: {substeps}, duration: {duration}}}
sweep:
{sweep}
output: {{histories: {histories}}}
"""


def _velocities(relative: tuple[float, ...]) -> str:
    return f"  velocity: [{', '.join(repr(a * V_C) for a in relative)}]"


PEAK_SPEEDS = tuple(float(x) for x in np.round(np.arange(0.6, 0.6351, 0.001), 3))
CASES = {
    "moving-force": TEMPLATE.format(
        title="speeds",
        velocity=V_C,
        sampling=SAMPLING,
        substeps=SUBSTEPS,
        duration=DURATION,
        sweep=f"  modes: [1, 20]\n  damping: [0, 2 %]\n{_velocities(SPEEDS)}",
        histories="{channels: [right_midspan]}",
    ),
    "moving-force-largest": TEMPLATE.format(
        title="largest dynamic deflection",
        velocity=V_C,
        sampling=LENGTH / V_C / 2000,
        substeps=1,
        duration=1,
        sweep=_velocities(PEAK_SPEEDS),
        histories="none",
    ),
    "moving-force-cancellation": TEMPLATE.format(
        title="cancellation",
        velocity=V_C,
        sampling=STILL_SAMPLING,
        substeps=SUBSTEPS,
        duration=2,
        sweep="  modes: [1, 20]\n"
        f"  velocity: [{', '.join(repr(cancellation_speed(beam(1), i)) for i in CANCELLATIONS)}]",
        histories="{channels: [right_midspan]}",
    ),
}

FRYBA = "Fryba's closed form"
MAXIMUM = "Fryba's closed form, maximised"
LAST_DIGIT = Tolerance(3e-4, "half of the last digit given, 2.9e-4")
SPEED = Tolerance(1.7e-3, "half of the last digit given and half of the sweep's step, together 0.001")


def phase_error(n: int, ratio: float, alpha: float, h: float, duration: float) -> float:
    """Estimate of Runge-Kutta's error over the peak: the modes' free vibrations run out of step.

    The phase of mode i falls behind by (omega_i h)^4 / 120 per radian. Its free vibration is about alpha / i,
    alpha = v / v_c, of its static share, i^-4; near its own resonance the whole share.
    """
    omega_1 = math.pi * V_C / LENGTH
    window = duration * LENGTH / (alpha * V_C)
    total = 0.0
    for i in range(1, n + 1, 2):
        omega = i**2 * omega_1
        lasting = min(window, 1 / (ratio * omega)) if ratio else window
        total += max(alpha, 0.1) / i**5 * min(2.0, omega * lasting * (omega * h) ** 4 / 120)
    return total


def _phase_tolerance(estimate: float) -> Tolerance:
    return Tolerance(
        max(3 * estimate, 1e-12),
        f"Runge-Kutta's phase error summed over the modes, {estimate:.0e}, times 3; at least 1e-12 for "
        "rounding",
    )


def compare(solved: Mapping[str, Solved]) -> Outcome:
    """Histories below, at and above the critical speed; the largest deflection; stillness after the exit."""
    outcome = Outcome()
    for i, n in enumerate(MODES):
        for j, ratio in enumerate(RATIOS):
            for k, alpha in enumerate(SPEEDS):
                _speed(outcome, solved["moving-force"].history(i, j, k), n, ratio, alpha)
    _largest(outcome, solved["moving-force-largest"])
    _stillness(outcome, solved["moving-force-cancellation"])
    return outcome


def _speed(outcome: Outcome, h: Mapping[str, Array], n: int, ratio: float, alpha: float) -> None:
    """One history, with n modes, a damping ratio and a speed alpha = v / v_c."""
    t, w = h["time"], h["right_midspan"]
    closed = deflection(beam(n, ratio), [FORCE], [0.0], alpha * V_C, t)
    case = f"v/v_c = {alpha:g}, {n} mode{'s' * (n > 1)}, damping {ratio:.0%}"
    tolerance = _phase_tolerance(phase_error(n, ratio, alpha, SAMPLING / SUBSTEPS, DURATION))
    outcome.history(case, "history of right_midspan", "m", w, closed, FRYBA, tolerance)
    if n == MODES[-1]:
        scale = 48 * beam(n).EI / (FORCE * LENGTH**3)
        x = t * alpha * V_C / LENGTH
        outcome.curves.append(
            Curve(
                f"Moving force: v/v_c = {alpha:g}, damping {ratio:.0%}, 20 modes",
                "v t / L",
                "mid-span deflection / (P L³/48EI)",
                (
                    Line("closed form", x, closed * scale, reference=True),
                    Line("tbi", x, w * scale),
                ),
            )
        )


def _largest(outcome: Outcome, solved: Solved) -> None:
    peaks = solved.table("peak", "right_midspan") * 48 * beam(1).EI / (FORCE * LENGTH**3)
    at = int(np.argmax(peaks))
    largest, speed = float(peaks[at]), float(solved.axis("velocity")[at]) / V_C
    case = "largest over the speeds, 1 mode"
    outcome.number(case, "peak over P L^3/48EI", "1", largest, 1.743, MAXIMUM, LAST_DIGIT)
    one_mode = largest * math.pi**4 / 96
    outcome.number(case, "peak over the one-mode static one", "1", one_mode, 1.768, MAXIMUM, LAST_DIGIT)
    outcome.number(case, "v/v_c of the largest peak", "1", speed, 0.617, MAXIMUM, SPEED)


def _stillness(outcome: Outcome, solved: Solved) -> None:
    for i, n in enumerate(MODES):
        for j, order in enumerate(CANCELLATIONS):
            h = solved.history(i, j)
            v = cancellation_speed(beam(1), order)
            w = h["right_midspan"]
            after = w[h["time"] > LENGTH / v * (1 + 1e-9)]
            case = f"v/v_c = 1/{2 * order + 1}, {n} mode{'s' * (n > 1)}, undamped"
            tolerance = _phase_tolerance(phase_error(n, 0.0, v / V_C, STILL_SAMPLING / SUBSTEPS, 2.0))
            peak = float(np.abs(w).max())
            outcome.zero(case, "mid-span after the exit / peak", "m", after, peak, FRYBA, tolerance)


VERIFICATION = Verification(
    2,
    "Moving constant force",
    "One force on a simply supported beam, undamped and damped, below, at and above the critical speed "
    "v_c = 2 f1 L, with 1 and with 20 modes. Fryba's solution is exact for every mode.",
    CASES,
    compare,
)
