"""Group 6: balance laws of the full coupled system, and the residuals of the equations as printed."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tbi_cli.verify.cases.full_train import LOPSIDED, changed, text
from tbi_cli.verify.check import Curve, Line, Outcome, Tolerance
from tbi_cli.verify.references.balance import (
    energy_balance,
    lateral_momentum,
    roll_momentum,
    wheel_force_sum,
)
from tbi_cli.verify.references.parameters import Array, Crossing
from tbi_cli.verify.references.printed import (
    bogie_and_body_forces,
    wheel_force_residual,
    wheel_points,
    wheelset_torque,
)
from tbi_cli.verify.references.sampled import derivative, pieces, with_modal_rates
from tbi_cli.verify.references.statics import forces_of_bodies
from tbi_cli.verify.solved import Solved, Verification

KINDS = {"as printed": False, "convective": True}
CASES = {
    f"balance-{name.replace(' ', '-')}": text(
        changed({**LOPSIDED, "contact.convective": convective, "solver.duration": 2.5}),
        f"Balance laws, {name}",
    )
    for name, convective in KINDS.items()
}
LAW = "balance law"
ZERO = "identically zero by Eqs. (12)"
ENERGY = Tolerance(
    1e-9,
    "Runge-Kutta loses (omega h)^6/72 of a mode's energy a step: 4e-7 over the window at 80 rad/s, of modes "
    "that hold less than 1e-3 of the energy",
)
MOMENTUM = Tolerance(1e-11, "rounding: Runge-Kutta keeps linear invariants; some thousand steps of 1e-16")
ROUNDING = Tolerance(1e-11, "rounding: both follow from the same accelerations")
MODAL = Tolerance(
    1e-6,
    "modal accelerations differenced twice by a spline of degree 7: (omega dt)^6 = 7e-7 at 94 rad/s of "
    "that mode",
)
RATES = Tolerance(
    1e-10,
    "the beams' rates by a spline of degree 7: (omega dt)^7 = 7e-8 at 94 rad/s of the dampers' share, 1e-3",
)
DIFFERENCED = Tolerance(
    1e-9, "accelerations by a spline of degree 7: (omega dt)^7 = 7e-8 at 94 rad/s of the dynamic share, 1e-2"
)


def compare(solved: Mapping[str, Solved]) -> Outcome:
    """Energy, momenta, wheel forces and printed equations, for the damper as printed and convective."""
    outcome = Outcome()
    for kind, name in zip(KINDS, CASES, strict=True):
        crossing, h = solved[name].crossing, solved[name].history()
        t = h["time"]
        h = with_modal_rates(crossing, t, h)
        _energy(outcome, kind, crossing, t, h)
        _momenta(outcome, kind, crossing, h)
        _forces(outcome, kind, crossing, t, h)
        _printed(outcome, kind, crossing, t, h)
    return outcome


def _energy(outcome: Outcome, kind: str, crossing: Crossing, t: Array, h: Mapping[str, Array]) -> None:
    energy = energy_balance(crossing, t, h)
    quantity = "stored + dissipated - driven energy / largest stored"
    outcome.zero(kind, quantity, "J", energy.error, float(energy.stored.max()), LAW, ENERGY)
    outcome.curves.append(
        Curve(
            f"Energy balance, {kind}",
            "time (s)",
            "energy (J)",
            (
                Line("driven", t, energy.driven, reference=True),
                Line("stored + dissipated", t, energy.stored + energy.dissipated),
                Line("stored", t, energy.stored),
            ),
        )
    )


def _momenta(outcome: Outcome, kind: str, crossing: Crossing, h: Mapping[str, Array]) -> None:
    for name, units, (momentum, scale) in (
        ("lateral momentum", "kg m/s", lateral_momentum(crossing, h)),
        ("roll momentum", "kg m2/s", roll_momentum(crossing, h)),
    ):
        outcome.zero(kind, f"{name} / sum of its terms' sizes", units, momentum, scale, LAW, MOMENTUM)


def _forces(outcome: Outcome, kind: str, crossing: Crossing, t: Array, h: Mapping[str, Array]) -> None:
    forces, inertia = wheel_force_sum(crossing, h)
    quantity = "sum of the eight wheel forces"
    outcome.history(kind, quantity, "N", forces, inertia, "weight + sum of m r''", ROUNDING)
    for name, force in forces_of_bodies(crossing.train, crossing.gravity, h).items():
        outcome.history(kind, name, "N", h[name], force, "Newton and Euler for car body and bogies", ROUNDING)
    under = wheel_points(crossing, t, h)
    residuals = wheel_force_residual(crossing, h, under, t)
    largest = np.array(list(residuals.values()))
    scale = max(float(np.abs(h[f"wheel_{k}_right_force"]).max()) for k in (1, 2, 3, 4))
    scale *= (2 / crossing.right.length) ** 0.5
    quantity = "residual of the beams under wheel force - m_w r''/2 / one wheel"
    outcome.zero(kind, quantity, "N m0.5", largest, scale, "Eq. (12b)", MODAL)


def _printed(outcome: Outcome, kind: str, crossing: Crossing, t: Array, h: Mapping[str, Array]) -> None:
    """Eqs. (29), (32)-(34), with the results' own accelerations and with differenced velocities."""
    under, between = wheel_points(crossing, t, h), pieces(crossing, t)
    differenced = dict(h) | {
        f"{name.removesuffix('_velocity')}_acceleration": derivative(t, h[name], between)
        for name in h
        if name.endswith("_velocity")
    }
    everywhere = np.ones(len(t), dtype=bool)
    # Velocities that have a kink on an event have no derivative there.
    smooth = everywhere.copy()
    smooth[[end for piece in between for end in (piece.start, piece.stop - 1)]] = False
    weight = crossing.train.car_mass * crossing.gravity
    for how, histories, keep, tolerance in (
        ("", h, everywhere, RATES),
        (", accelerations differenced", differenced, smooth, DIFFERENCED),
    ):
        for name, residual in bogie_and_body_forces(crossing, histories, under).items():
            quantity = f"{name}{how} / weight of the body"
            outcome.zero(kind, quantity, "N", residual[keep], weight, ZERO, tolerance)
        torques = np.array(list(wheelset_torque(crossing, histories, under).values()))
        quantity = f"Eq. (29), all wheelsets{how} / weight of the body x d"
        outcome.zero(kind, quantity, "N m", torques[:, keep], weight * crossing.train.d, ZERO, tolerance)


VERIFICATION = Verification(
    6,
    "Balance laws and the printed equations",
    "The full train at 50 m/s, where every entry and exit falls on a millisecond: energy, momenta, the sum "
    "of the wheel forces, and Eqs. (29), (32)-(34) evaluated on histories.",
    CASES,
    compare,
)
