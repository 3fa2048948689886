"""Group 15: what is read off along the beams, and low-passed accelerations."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from tbi_cli.verify.cases.full_train import LOPSIDED, changed, text
from tbi_cli.verify.check import Curve, Line, Outcome, Tolerance, worst_channel
from tbi_cli.verify.references.crossing import CoupledSystem
from tbi_cli.verify.references.moving_force import critical_speed, deflection, modal_coordinates
from tbi_cli.verify.references.parameters import Array, Beam, beam_from_mapping
from tbi_cli.verify.references.stations import (
    counted_by_en_1990,
    low_passed,
    modal_shares,
    moment_and_shear,
    moment_line,
    shear_line,
)
from tbi_cli.verify.solved import Solved, Verification

LENGTH, FORCE, VELOCITY, MODES = 20.0, 100e3, 50.0, 8
PLACES = (0.0, 5.0, 10.0, 13.7, 20.0)
BEAM = {"youngs_modulus": 30e9, "second_moment": 0.3, "mass_per_length": 10e3, "damping": {"ratio": 0.02}}
SLOW = 5e-4


def beam(length: float = LENGTH, n: int = MODES) -> Beam:
    """The beam of these cases."""
    return beam_from_mapping(BEAM, length, n)


TRAIN_PLACES = (12.5, 25.0, 50.0)
TEMPLATE = """
title: {title}
train: {{model: moving-load, forces: [100 kN], positions: [0]}}
bridge:
  length: 20 m
  modes: 8
  {more}
  right: {{youngs_modulus: 30 GPa, second_moment: 0.3, mass_per_length: 10 t/m, damping: {{ratio: 2 %}}}}
velocity: {velocity!r}
solver: {solver}
output: {{histories: {{channels: [{channels}]}}}}
"""
QUANTITIES = ("deflection", "acceleration", "moment", "shear")
ALL_STATIONS = ", ".join(f"right_station_{s + 1}_{q}" for s in range(len(PLACES)) for q in QUANTITIES)
STATIONS = f"stations: {list(PLACES)}"
LOW_PASS = "right_midspan_acceleration, right_midspan_acceleration_low_pass"
CASES = {
    "stations-crawling": TEMPLATE.format(
        title="A force at crawling speed",
        more=STATIONS,
        velocity=SLOW * critical_speed(beam()),
        solver="{method: exact, sampling: 0.5, duration: 1}",
        channels=ALL_STATIONS,
    ),
    "stations-force": TEMPLATE.format(
        title="A force at 50 m/s",
        more=STATIONS,
        velocity=VELOCITY,
        solver="{method: exact, sampling: 0.0013, duration: 2}",
        channels=ALL_STATIONS,
    ),
    "stations-train": text(
        changed(
            {
                **LOPSIDED,
                "bridge.stations": list(TRAIN_PLACES),
                "solver": {"sampling": 2.5e-3, "substeps": 8, "duration": 1.0},
                "output.histories": {
                    "channels": [
                        f"{side}_station_{s + 1}_{quantity}"
                        for side in ("right", "left")
                        for s in range(len(TRAIN_PLACES))
                        for quantity in ("moment", "shear")
                    ]
                },
            }
        ),
        "The full train, unequal ends, bridge 50 m",
    ),
    "low-pass": TEMPLATE.format(
        title="Low-passed acceleration",
        more="low_pass: en-1990",
        velocity=VELOCITY,
        solver="{method: exact, sampling: 0.001, duration: 2}",
        channels=LOW_PASS,
    ).replace("output:", "sweep: {span: [10, 20, 50]}\noutput:"),
}
LINES, ELASTIC, FRYBA = "influence lines", "deflection instead of inertia", "Fryba's closed form"
ORACLE = "31-DOF crossing, DOP853 to 1e-10, deflection instead of inertia"
CRAWL = Tolerance(1e-3, "what is left of the dynamics, v/v_c = 5e-4 of the peak, times 2 for a sum of modes")
ROUNDING = Tolerance(1e-11, "rounding, eps omega_8^2 q over the terms that cancel")
TRAIN = Tolerance(2e-6, "the phase error of the train's histories")
FILTER = Tolerance(1e-11, "rounding, magnified by poles up to 1 - |p| = 0.05")
PASSES = Tolerance(0.02, "Butterworth's filter at 1/1.5 of its cut-off: 1 - 1/sqrt(1 + 1.5^-8) = 1.9 %")
SPANS = (10.0, 20.0, 50.0)


def compare(solved: Mapping[str, Solved]) -> Outcome:
    """Influence lines, moments and shear from deflections, equilibrium, and the filter."""
    outcome = Outcome()
    _crawling(outcome, solved["stations-crawling"].history())
    _force(outcome, solved["stations-force"].history())
    _train(outcome, solved["stations-train"])
    for i, span in enumerate(SPANS):
        h = solved["low-pass"].history(i)
        t, y = h["time"], h["right_midspan_acceleration"]
        counted = counted_by_en_1990(beam(span))
        theirs = low_passed(y, 1.5 * counted, float(t[1] - t[0]))
        case, name = f"span {span:g} m, up to {counted:.4g} Hz", "right_midspan_acceleration_low_pass"
        outcome.history(case, name, "m/s2", h[name], theirs, "scipy.signal.butter, sosfilt", FILTER)
        free = t > 1.1 * span / VELOCITY
        odd = np.arange(MODES) % 2 == 0
        seen = modal_shares(h[name][free], y[free], beam(span), odd, t[free])
        share = float(seen[beam(span).omega[odd] <= 2.001 * math.pi * counted].min())
        outcome.at_least(case, "least share of a mode that counts", share, 1.0, "EN 1990", PASSES)
    return outcome


def _crawling(outcome: Outcome, h: Mapping[str, Array]) -> None:
    xi = h["time"] * SLOW * critical_speed(beam())
    for s, x in enumerate(PLACES):
        case = f"crawling force, station at {x:g} m"
        for quantity, units, line in (("moment", "N m", moment_line), ("shear", "N", shear_line)):
            ours, exact = h[f"right_station_{s + 1}_{quantity}"], FORCE * line(LENGTH, x, xi)
            at_end = x in (0.0, LENGTH) and quantity == "moment"
            # A force right above the station stands just before it or just behind it.
            clear = np.abs(xi - x) > 1e-6
            if at_end:
                quantity_over = f"{quantity} / F L"
                outcome.zero(case, quantity_over, units, ours, FORCE * LENGTH, "supports", ROUNDING)
            else:
                outcome.history(case, quantity, units, ours[clear], exact[clear], LINES, CRAWL)
            if (x, quantity) == (10.0, "moment"):
                lines = (
                    Line("influence line", xi, exact / 1e3, reference=True),
                    Line("tbi", xi, ours / 1e3),
                )
                title = "Crawling force: bending moment at mid-span"
                outcome.curves.append(Curve(title, "place of the force (m)", "moment (kN m)", lines))


def _force(outcome: Outcome, h: Mapping[str, Array]) -> None:
    t = h["time"]
    q, q_t = modal_coordinates(beam(), FORCE, VELOCITY, t)
    xi = VELOCITY * t[None, :]
    b, amplitude = beam(), math.sqrt(2 / LENGTH)
    push = -FORCE * amplitude * np.sin(np.outer(b.wave_numbers, xi)) * (xi <= LENGTH)
    q_tt = (push - b.c[:, None] * q_t) / b.mu - b.omega[:, None] ** 2 * q
    for s, x in enumerate(PLACES):
        case, name = f"50 m/s, station at {x:g} m", f"right_station_{s + 1}"
        moment, shear = moment_and_shear(beam(), x, q, np.full_like(xi, FORCE), xi)
        if x in (0.0, LENGTH):
            ours = h[f"{name}_moment"]
            outcome.zero(case, "moment / F L", "N m", ours, FORCE * LENGTH, "supports", ROUNDING)
        else:
            w = deflection(beam(), [FORCE], [0.0], VELOCITY, t, x)
            outcome.history(case, "deflection", "m", h[f"{name}_deflection"], w, FRYBA, ROUNDING)
            a = amplitude * np.sin(b.wave_numbers * x) @ q_tt
            outcome.history(case, "acceleration", "m/s2", h[f"{name}_acceleration"], a, FRYBA, ROUNDING)
            outcome.history(case, "moment", "N m", h[f"{name}_moment"], moment, ELASTIC, ROUNDING)
        clear = np.abs(xi[0] - x) > 1e-6
        outcome.history(case, "shear", "N", h[f"{name}_shear"][clear], shear[clear], ELASTIC, ROUNDING)


def _train(outcome: Outcome, solved: Solved) -> None:
    h = solved.history()
    t = h.pop("time")
    crossing = solved.crossing
    system = CoupledSystem(crossing)
    motion = system.motion(t)
    pushes = system.static_loads[:, None] - motion.force
    xi = np.where(motion.on > 0, system.positions(t), -1.0)
    # An axle that stands on a support up to rounding is on the bridge.
    xi = np.where(motion.on > 0, np.clip(xi, 0.0, crossing.right.length), xi)
    pairs: dict[str, tuple[Array, Array]] = {}
    for side, b, first in (("right", crossing.right, 0), ("left", crossing.left, 4)):
        q = motion.q[: b.n] if side == "right" else motion.q[b.n :]
        for s, x in enumerate(TRAIN_PLACES):
            found = moment_and_shear(b, x, q, pushes[first : first + 4], xi)
            clear = (np.abs(xi - x) > 1e-6).all(axis=0)
            for quantity, theirs in zip(("moment", "shear"), found, strict=True):
                if x == b.length and quantity == "moment":
                    continue
                name = f"{side}_station_{s + 1}_{quantity}"
                pairs[name] = h[name][clear], theirs[clear]
    worst = worst_channel(pairs)
    quantity = f"{len(pairs)} moments and shear forces (worst: {worst})"
    outcome.history("31-DOF train, unequal ends", quantity, "SI", *pairs[worst], ORACLE, TRAIN)


VERIFICATION = Verification(
    15,
    "Along the beams",
    "Deflection, bending moment and shear force at stations: influence lines at crawling speed, and at speed "
    "the same from deflections where the program takes inertia; nothing at the supports but their push. "
    "Low-passed accelerations against scipy's filter.",
    CASES,
    compare,
)
