"""Group 3: trains of equally spaced forces, at resonance and where they cancel."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from tbi_cli.verify.check import Curve, Line, Outcome, Tolerance
from tbi_cli.verify.references.moving_force import (
    deflection,
    equal_forces_deflection,
    resonant_speed,
    spacing_cancellation_speed,
)
from tbi_cli.verify.references.parameters import Array, Beam, beam_from_mapping
from tbi_cli.verify.solved import Solved, Verification

LENGTH, SPACING, COUNT, FORCE = 20.0, 25.0, 10, 100e3
RATIO = 0.01
ORDERS = (1, 2, 3)
CANCEL_COUNT, CANCEL_ORDERS = 4, (5, 6, 7)


def beam(ratio: float, n: int = 1) -> Beam:
    """The beam of these cases."""
    given = {
        "youngs_modulus": 30e9,
        "second_moment": 0.3,
        "mass_per_length": 10e3,
        "damping": {"ratio": ratio},
    }
    return beam_from_mapping(given, LENGTH, n)


PERIOD = 2 * math.pi / float(beam(0.0).omega[0])
TEMPLATE = """
title: {title}
train: {{model: moving-load, forces: [{forces}], positions: [{positions}]}}
bridge:
  length: 20 m
  modes: 1
  right:
    {{youngs_modulus: 30 GPa, second_moment: 0.3, mass_per_length: 10 t/m, damping: {{ratio: {ratio!r}}}}}
velocity: 50 m/s
solver: {{sampling: {sampling!r}, substeps: 4, duration: 1.1}}
sweep: {{velocity: [{velocities}]}}
output: {{histories: {{channels: [right_midspan]}}}}
"""


def _case(title: str, count: int, ratio: float, velocities: list[float], sampling: float) -> str:
    return TEMPLATE.format(
        title=title,
        forces=", ".join(["100 kN"] * count),
        positions=", ".join(repr(SPACING * k) for k in range(count)),
        ratio=ratio,
        velocities=", ".join(repr(v) for v in velocities),
        sampling=sampling,
    )


# A crossing takes 0.8 i periods and the spacing i periods: 500 samples a period hold every event.
RESONANT = [resonant_speed(beam(0.0), SPACING, i) for i in ORDERS]
CANCELLING = [spacing_cancellation_speed(beam(0.0), SPACING, CANCEL_COUNT, m) for m in CANCEL_ORDERS]
CASES = {
    "force-train-resonance": _case("Equal forces at resonance", COUNT, RATIO, RESONANT, PERIOD / 500),
    # Here the spacing is m/4 periods and the crossing 0.2 m.
    "force-train-cancellation": _case(
        "Equal forces that cancel", CANCEL_COUNT, 0.0, CANCELLING, PERIOD / 500
    ),
}

SERIES = "closed form, geometric series"
SUM = "superposed closed forms"
HISTORY = Tolerance(
    1e-10, "Runge-Kutta's phase error: omega T (omega h)^4/120 with omega h = 0.0031 over 30 periods is 1e-10"
)
GROWTH = Tolerance(
    1e-9,
    "the history's error, 1e-10, over the amplitude after one force, which is a fifth of the peak and more",
)


def compare(solved: Mapping[str, Solved]) -> Outcome:
    """The whole history, the growth from one force to the next, and stillness at the cancellation speeds."""
    outcome = Outcome()
    for j, i in enumerate(ORDERS):
        _resonance(outcome, solved["force-train-resonance"].history(j), i, RESONANT[j])
    for j, m in enumerate(CANCEL_ORDERS):
        _cancellation(outcome, solved["force-train-cancellation"].history(j), m, CANCELLING[j])
    return outcome


def _resonance(outcome: Outcome, h: Mapping[str, Array], i: int, v: float) -> None:
    damped = beam(RATIO)
    t, w = h["time"], h["right_midspan"]
    case = f"v = f1 D/{i}, {COUNT} forces, damping {RATIO:.0%}"
    series = equal_forces_deflection(damped, FORCE, SPACING, COUNT, v, t)
    outcome.history(case, "history of right_midspan", "m", w, series, SERIES, HISTORY)
    # Free vibration from an exit to the next entry, after one force and after all, at the same place of the
    # cycle: the amplitudes are as |1 - e^N| to |1 - e|, e = exp(lambda D / v).
    exit_time, gap, omega = LENGTH / v, SPACING / v, float(damped.omega[0])
    e = np.exp(complex(-RATIO * omega, omega * math.sqrt(1 - RATIO**2)) * gap)
    first = _amplitude(t, w, exit_time, gap, damped)
    last = _amplitude(t, w, exit_time + (COUNT - 1) * gap, gap, damped)
    growth = float(abs((1 - e**COUNT) / (1 - e)))
    quantity = f"amplitude after {COUNT} forces over that after 1"
    outcome.number(case, quantity, "1", last / first, growth, SERIES, GROWTH)
    outcome.curves.append(
        Curve(
            f"Equal forces at resonance, v = f1 D/{i}",
            "time / period",
            "mid-span deflection (mm)",
            (
                Line("geometric series", t / PERIOD, series * 1e3, reference=True),
                Line("tbi", t / PERIOD, w * 1e3),
            ),
        )
    )


def _cancellation(outcome: Outcome, h: Mapping[str, Array], m: int, v: float) -> None:
    t, w = h["time"], h["right_midspan"]
    case = f"v = {CANCEL_COUNT} f1 D/{m}, {CANCEL_COUNT} forces, undamped"
    positions = [SPACING * k for k in range(CANCEL_COUNT)]
    closed = deflection(beam(0.0), [FORCE] * CANCEL_COUNT, positions, v, t)
    outcome.history(case, "history of right_midspan", "m", w, closed, SUM, HISTORY)
    after = w[t > (LENGTH + positions[-1]) / v * (1 + 1e-9)]
    peak = float(np.abs(w).max())
    outcome.zero(case, "mid-span after the last force / peak", "m", after, peak, SERIES, HISTORY)


def _amplitude(t: Array, w: Array, start: float, gap: float, b: Beam) -> float:
    """Amplitude at `start` of the free vibration of mode 1 fitted to a history until the next entry."""
    omega = float(b.omega[0])
    zeta = float(b.c[0]) / (2 * b.mu * omega)
    inside = (t >= start) & (t <= start + gap * (1 - LENGTH / SPACING))
    since = t[inside] - start
    decay, phase = np.exp(-zeta * omega * since), omega * math.sqrt(1 - zeta**2) * since
    basis = np.stack([decay * np.cos(phase), decay * np.sin(phase)], axis=1)
    fitted = np.linalg.lstsq(basis, w[inside], rcond=None)[0]
    return float(np.hypot(*fitted))


VERIFICATION = Verification(
    3,
    "Trains of equally spaced forces",
    "Forces that follow each other by a whole number of periods of the first mode: each adds to what the "
    "last one left, less damping, a geometric series. At other speeds they leave the beam still.",
    CASES,
    compare,
)
