"""Sprung masses, rigid beams and constant forces in one row over one beam, integrated with DOP853.

With the stretch s = g x - w(xi) of the spring-damper over each support, p = k s + c s' - f_g on the beam:
    q_i'' = (sum phi_i(xi) p - c_i q_i') / mu - omega_i^2 q_i,    M x'' = -sum g (k s + c s').
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from tbi_cli.verify.references.parameters import STANDARD_GRAVITY, Array, Beam
from tbi_cli.verify.references.piecewise import integrate_between_events
from tbi_cli.verify.references.simple_vehicles import RigidBeam, SprungMass


@dataclass(frozen=True)
class Support:
    """What stands on the beam: k, c, load f_g, distance behind the first, weights of the coordinates."""

    stiffness: float
    damping: float
    load: float
    behind: float
    weights: dict[int, float]


def supports_of(
    vehicles: Sequence[SprungMass | RigidBeam | float], fronts: Sequence[float]
) -> tuple[list[Support], list[float], list[str]]:
    """Supports, inertias and names of the coordinates of vehicles (a number: a force in N), front to rear."""
    supports: list[Support] = []
    inertias: list[float] = []
    names: list[str] = []
    for number, (vehicle, front) in enumerate(zip(vehicles, fronts, strict=True), 1):
        at = len(inertias)
        if isinstance(vehicle, SprungMass):
            weight = vehicle.mass * STANDARD_GRAVITY
            supports.append(Support(vehicle.stiffness, vehicle.damping, weight, front, {at: 1.0}))
            inertias.append(vehicle.mass)
            names.append(f"coach_{number}_sprung_mass_y")
        elif isinstance(vehicle, RigidBeam):
            half = vehicle.distance / 2
            for x in (half, -half):
                weight = vehicle.mass * STANDARD_GRAVITY / 2
                weights = {at: 1.0, at + 1: x}
                supports.append(
                    Support(vehicle.stiffness, vehicle.damping, weight, front + half - x, weights)
                )
            inertias += [vehicle.mass, vehicle.pitch_inertia]
            names += [f"coach_{number}_beam_y", f"coach_{number}_beam_pitch"]
        else:
            supports.append(Support(0.0, 0.0, vehicle, front, {}))
    return supports, inertias, names


def mixed_row_crossing(
    beam: Beam,
    vehicles: Sequence[SprungMass | RigidBeam | float],
    fronts: Sequence[float],
    velocity: float,
    times: Array,
) -> dict[str, Array]:
    """`right_midspan`, `right_mode_<i>` and every `coach_<k>_...` displacement at `times`.

    fronts (m): of each vehicle's first support, behind the train's first.
    """
    supports, inertias, names = supports_of(vehicles, fronts)
    n, nv = beam.n, len(inertias)
    g = np.zeros((len(supports), nv))
    for row, support in zip(g, supports, strict=True):
        for place, weight in support.weights.items():
            row[place] = weight
    k, c, load, behind = (
        np.array([getattr(s, key) for s in supports]) for key in ("stiffness", "damping", "load", "behind")
    )
    amplitude, mass = math.sqrt(2 / beam.length), np.array(inertias)

    def rate_between(start: float, stop: float) -> Callable[[float, Array], Array]:
        middle = 0.5 * (start + stop) * velocity - behind
        on = ((middle >= 0) & (middle <= beam.length)).astype(float)

        def rate(t: float, state: Array) -> Array:
            x, q, x_t, q_t = np.split(state, [nv, nv + n, 2 * nv + n])
            phi = amplitude * np.sin(np.outer(velocity * t - behind, beam.wave_numbers)) * on[:, None]
            spring = k * (g @ x - phi @ q) + c * (g @ x_t - phi @ q_t)
            q_tt = (phi.T @ (spring - load) - beam.c * q_t) / beam.mu - beam.omega**2 * q
            return np.concatenate([x_t, q_t, -(g.T @ spring) / mass, q_tt])

        return rate

    events = [(at + end) / velocity for at in behind for end in (0.0, beam.length)]
    state = integrate_between_events(rate_between, 2 * (nv + n), events, times)
    middle = amplitude * np.sin(beam.wave_numbers * beam.length / 2)
    out = {name: state[i] for i, name in enumerate(names)}
    out |= {f"right_mode_{i + 1}": state[nv + i] for i in range(n)}
    return out | {"right_midspan": middle @ state[nv : nv + n]}
