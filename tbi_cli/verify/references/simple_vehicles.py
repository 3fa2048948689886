"""Sprung mass and suspended rigid beam on a beam: the modal equations written out, one line each.

Section 3.1 of the paper. Integrated with DOP853 to 1e-10, restarted at every axle event.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from tbi_cli.verify.references.parameters import STANDARD_GRAVITY, Array, Beam
from tbi_cli.verify.references.piecewise import integrate_between_events


@dataclass(frozen=True)
class SprungMass:
    """Mass [kg] on one spring-damper [N/m, N s/m]."""

    mass: float
    stiffness: float
    damping: float = 0.0


@dataclass(frozen=True)
class RigidBeam:
    """Rigid body [kg, kg m2] on two spring-dampers [N/m, N s/m], `distance` [m] apart."""

    mass: float
    pitch_inertia: float
    distance: float
    stiffness: float
    damping: float = 0.0


def sprung_mass_crossing(
    beam: Beam,
    vehicle: SprungMass,
    velocity: float,
    times: Array,
    gravity: float = STANDARD_GRAVITY,
    convective: bool = False,
) -> dict[str, Array]:
    """Channels `right_midspan`, `sprung_mass_y` (and derivatives) and `right_mode_<i>` at `times`.

    With s = y - w(xi) and p = k s + c s' - m g on the beam:
        q_i'' = (phi_i(xi) p - c_i q_i') / mu - omega_i^2 q_i,    y'' = -(k s + c s') / m.
    """
    n, k, c, m = beam.n, vehicle.stiffness, vehicle.damping, vehicle.mass
    weight = m * gravity
    shapes = _shapes_at(beam)

    def rate_between(start: float, stop: float) -> Callable[[float, Array], Array]:
        on = 0.5 * (start + stop) * velocity <= beam.length

        def rate(t: float, state: Array) -> Array:
            q, y, q_t, y_t = state[:n], state[n], state[n + 1 : -1], state[-1]
            phi, phi_x = shapes(t * velocity) if on else (np.zeros(n), np.zeros(n))
            w, w_t = _sum(phi, q), _sum(phi, q_t)
            if convective:
                w_t += velocity * _sum(phi_x, q)
            spring = k * (y - w) + c * (y_t - w_t)
            q_tt = [
                (phi[i] * (spring - weight) - beam.damping[i] * q_t[i]) / beam.mu - beam.omega[i] ** 2 * q[i]
                for i in range(n)
            ]
            return np.array([*q_t, y_t, *q_tt, -spring / m])

        return rate

    state = integrate_between_events(rate_between, 2 * n + 2, [beam.length / velocity], times)
    rates = _rates(rate_between, state, times, [beam.length / velocity])
    return _channels(beam, state, rates, ["sprung_mass_y"])


def rigid_beam_crossing(
    beam: Beam,
    vehicle: RigidBeam,
    velocity: float,
    times: Array,
    gravity: float = STANDARD_GRAVITY,
    convective: bool = False,
) -> dict[str, Array]:
    """Channels `right_midspan`, `beam_y`, `beam_pitch` (and derivatives) and `right_mode_<i>` at `times`.

    Supports at X = +d/2 (first on the bridge) and -d/2, each carrying m g / 2:
        s_1 = y + theta d/2 - w(xi_1),   s_2 = y - theta d/2 - w(xi_2),   p_j = k s_j + c s_j'
        q_i'' = (phi_i(xi_1)(p_1 - m g/2) + phi_i(xi_2)(p_2 - m g/2) - c_i q_i') / mu - omega_i^2 q_i
        y'' = -(p_1 + p_2)/m,   theta'' = -(p_1 - p_2) d/2 / J.
    """
    n, k, c, m, J = beam.n, vehicle.stiffness, vehicle.damping, vehicle.mass, vehicle.pitch_inertia
    half, load = vehicle.distance / 2, m * gravity / 2
    lag = vehicle.distance / velocity
    shapes = _shapes_at(beam)
    zero = (np.zeros(n), np.zeros(n))

    def rate_between(start: float, stop: float) -> Callable[[float, Array], Array]:
        middle = 0.5 * (start + stop) * velocity
        on_1 = middle <= beam.length
        on_2 = 0 <= middle - vehicle.distance <= beam.length

        def rate(t: float, state: Array) -> Array:
            q, y, theta = state[:n], state[n], state[n + 1]
            q_t, y_t, theta_t = state[n + 2 : -2], state[-2], state[-1]
            phi_1, slope_1 = shapes(t * velocity) if on_1 else zero
            phi_2, slope_2 = shapes((t - lag) * velocity) if on_2 else zero
            w_1_t, w_2_t = _sum(phi_1, q_t), _sum(phi_2, q_t)
            if convective:
                w_1_t += velocity * _sum(slope_1, q)
                w_2_t += velocity * _sum(slope_2, q)
            p_1 = k * (y + half * theta - _sum(phi_1, q)) + c * (y_t + half * theta_t - w_1_t)
            p_2 = k * (y - half * theta - _sum(phi_2, q)) + c * (y_t - half * theta_t - w_2_t)
            q_tt = [
                (phi_1[i] * (p_1 - load) + phi_2[i] * (p_2 - load) - beam.damping[i] * q_t[i]) / beam.mu
                - beam.omega[i] ** 2 * q[i]
                for i in range(n)
            ]
            return np.array([*q_t, y_t, theta_t, *q_tt, -(p_1 + p_2) / m, -(p_1 - p_2) * half / J])

        return rate

    crossing = beam.length / velocity
    events = [lag, crossing, crossing + lag]
    state = integrate_between_events(rate_between, 2 * n + 4, events, times)
    rates = _rates(rate_between, state, times, events)
    return _channels(beam, state, rates, ["beam_y", "beam_pitch"])


def _shapes_at(beam: Beam) -> Callable[[float], tuple[Array, Array]]:
    """phi_i(x) and phi_i'(x) by the sine itself."""
    kappa, a = beam.wave_numbers, math.sqrt(2 / beam.length)
    return lambda x: (a * np.sin(kappa * x), a * kappa * np.cos(kappa * x))


def _sum(a: Array, b: Array) -> float:
    return float(a @ b)


def _rates(
    rate_between: Callable[[float, float], Callable[[float, Array], Array]],
    state: Array,
    times: Array,
    events: Sequence[float],
) -> Array:
    """The right-hand side at every sample; a sample on an event takes the stretch that ends there."""
    cuts = np.array([0.0, *sorted(events), max(float(times[-1]), max(events)) + 1.0])
    out = np.empty_like(state)
    for j, t in enumerate(times):
        piece = max(int(np.searchsorted(cuts, t, side="left")) - 1, 0)
        out[:, j] = rate_between(float(cuts[piece]), float(cuts[piece + 1]))(float(t), state[:, j])
    return out


def _channels(beam: Beam, state: Array, rates: Array, names: list[str]) -> dict[str, Array]:
    n, size = beam.n, len(state) // 2
    middle = math.sqrt(2 / beam.length) * np.sin(beam.wave_numbers * beam.length / 2)
    out: dict[str, Array] = {}
    for suffix, x in (("", state[:size]), ("_velocity", state[size:]), ("_acceleration", rates[size:])):
        out[f"right_midspan{suffix}"] = middle @ x[:n]
        out |= {f"right_mode_{i + 1}{suffix}": x[i] for i in range(n)}
        out |= {f"{name}{suffix}": x[n + i] for i, name in enumerate(names)}
    return out
