"""Vehicles on irregular rails, and wheels with mass on springs that may let go, integrated with DOP853.

The equations are Lagrange's, from the energies of Eqs. (1a-c) with the wheelsets' own y and roll as
coordinates; the contact force of a wheel on its rail is

    Q = max(0, f_g + k_H (w + r - u) + c_H (w' + r' - u')),

u the displacement of the wheel, w of the beam and r of the rail under it, every rate a total one.  DOP853
is restarted wherever an axle enters or leaves the bridge, a wheel crosses a corner of its rail, lifts off or
comes down.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from tbi_cli.verify.references.energies import COORDINATES, KINEMATIC, train_matrices
from tbi_cli.verify.references.parameters import STANDARD_GRAVITY, Array, Beam, Crossing, crossing_from_case
from tbi_cli.verify.references.rail_shapes import BESIDE, LEVEL, Rail
from tbi_cli.verify.references.simple_vehicles import SprungMass
from tbi_cli.verify.references.statics import forces_of_bodies, static_wheel_loads

RELATIVE, ABSOLUTE = 1e-10, 1e-14


@dataclass(frozen=True)
class HertzSpring:
    """The contact of one wheel: N/m, N s/m, and the distance of its running circle from the middle (m).

    What a case leaves out: 1.4 GN/m, no damping, and half of 1.5 m between the running circles.
    """

    stiffness: float = 1.4e9
    damping: float = 0.0
    running_circle: float = 0.75


def sprung_mass_on_rails(
    beam: Beam,
    vehicle: SprungMass,
    velocity: float,
    times: Array,
    rail: Rail = LEVEL,
    gravity: float = STANDARD_GRAVITY,
    convective: bool = False,
) -> dict[str, Array]:
    """`sprung_mass_y`, its acceleration and `right_midspan` at `times`, of which the first is the start.

    With s = y - w(xi) - r(xi), xi = v t, and p = k s + c s' - m g on the beam:
        q_i'' = phi_i(xi) p / mu - c_i q_i' / mu - omega_i^2 q_i,    y'' = -(k s + c s') / m.
    """
    n, k, c, m = beam.n, vehicle.stiffness, vehicle.damping, vehicle.mass
    kappa, norm = beam.wave_numbers, math.sqrt(2 / beam.length)

    def rate(t: float, state: Array, inside: float) -> Array:
        x = velocity * t
        # On the bridge, and on which side of a corner: as at `inside`, a time of the same smooth stretch.
        on = 0 <= velocity * inside <= beam.length
        phi = norm * np.sin(kappa * x) * on
        q, y, q_t, y_t = state[:n], state[n], state[n + 1 : -1], state[-1]
        w, w_t = phi @ q, phi @ q_t
        if convective:
            w_t += velocity * norm * (kappa * np.cos(kappa * x) * on) @ q
        slope = rail.slope(x + (BESIDE if t < inside else -BESIDE))
        spring = k * (y - w - rail.level(x)) + c * (y_t - w_t - velocity * slope)
        q_tt = phi * (spring - m * gravity) / beam.mu - beam.c * q_t / beam.mu - beam.omega**2 * q
        return np.concatenate([q_t, [y_t], q_tt, [-spring / m]])

    events = [0.0, beam.length / velocity, *(x / velocity for x in rail.corners)]
    state, rates = piecewise(rate, 2 * n + 2, events, times)
    middle = norm * np.sin(kappa * beam.length / 2)
    return {
        "sprung_mass_y": state[n],
        "sprung_mass_y_acceleration": rates[-1],
        "right_midspan": middle @ state[:n],
    }


def piecewise(
    rate: Callable[[float, Array, float], Array], size: int, events: Sequence[float], times: Array
) -> tuple[Array, Array]:
    """State and its rate (size, nt) at `times`, from rest at the first of them, restarted at the events."""
    from scipy.integrate import solve_ivp

    start, end = float(times[0]), float(times[-1])
    cuts = [start, *sorted({float(t) for t in events if start < t < end}), end]
    state, states, rates = np.zeros(size), np.zeros((size, len(times))), np.zeros((size, len(times)))
    for begin, stop in pairwise(cuts):
        inside, middle = (times >= begin) & (times <= stop), (begin + stop) / 2
        at = np.union1d(times[inside], [stop])
        found = solve_ivp(
            rate, (begin, stop), state, "DOP853", at, args=(middle,), rtol=RELATIVE, atol=ABSOLUTE
        )
        if not found.success:
            raise ArithmeticError(f"reference integration failed: {found.message}")
        states[:, inside] = found.y[:, np.isin(at, times[inside])]
        rates[:, inside] = np.array(
            [rate(t, y, middle) for t, y in zip(times[inside], states[:, inside].T, strict=True)]
        ).T
        state = found.y[:, -1]
    return states, rates


class HertzSystem:
    """The 31 equations of the train and those of the modes: M x'' = F(t, x, x'), x = (31 train, 2n modal)."""

    def __init__(self, crossing: Crossing, spring: HertzSpring, rails: tuple[Rail, Rail]) -> None:
        self.crossing, self.spring, self.rails = crossing, spring, rails
        matrices, n = train_matrices(crossing.train), crossing.right.n
        self.n, self.distances = n, crossing.train.axle_distances
        self.loads = np.tile(static_wheel_loads(crossing), 2)
        # The primary springs now stand on the wheelsets: less their own y.
        rows = matrices.wheel_rows.copy()
        for wheel in range(8):
            rows[wheel, KINEMATIC[wheel % 4]] -= 1.0
        k, c = matrices.wheel_k[:, None], matrices.wheel_c[:, None]
        size = len(COORDINATES) + 2 * n
        self.K, self.C = np.zeros((size, size)), np.zeros((size, size))
        train, beams = slice(0, len(COORDINATES)), slice(len(COORDINATES), size)
        self.K[train, train] = matrices.K + rows.T @ (k * rows)
        self.C[train, train] = matrices.C + rows.T @ (c * rows)
        right, left = crossing.right, crossing.left
        stiffness = [beam.EI * beam.wave_numbers**4 for beam in (right, left)]
        self.K[beams, beams] = np.diag(np.concatenate(stiffness))
        self.C[beams, beams] = np.diag(np.concatenate([right.c, left.c]))
        self.mass = np.concatenate([matrices.M, np.full(n, right.mu), np.full(n, left.mu)])
        # A wheel is a point of its wheelset at Z = +-b: r_wy -+ theta_wx b.
        self.wheels = np.zeros((8, len(COORDINATES)))
        for wheel in range(8):
            self.wheels[wheel, KINEMATIC[wheel % 4]] = 1.0
            side = -1.0 if wheel < 4 else 1.0
            roll = COORDINATES.index(f"wheelset_{wheel % 4 + 1}_roll")
            self.wheels[wheel, roll] = side * spring.running_circle

    def squeeze(self, t: float, x: Array, x_t: Array, inside: float) -> tuple[Array, Array]:
        """phi (8, 2n) and the force (8,) of each contact if it could pull: right 1-4, then left 1-4."""
        v, beam, n = self.crossing.velocity, self.crossing.right, self.n
        xi, there = v * t - self.distances, v * inside - self.distances
        on = ((there >= 0) & (there <= beam.length))[:, None]
        norm, kappa = math.sqrt(2 / beam.length), beam.wave_numbers
        phase = np.outer(xi, kappa)
        phi, phi_x = np.zeros((8, 2 * n)), np.zeros((8, 2 * n))
        for side in (0, 1):
            rows, columns = slice(4 * side, 4 * side + 4), slice(n * side, n * side + n)
            phi[rows, columns] = norm * np.sin(phase) * on
            phi_x[rows, columns] = norm * kappa * np.cos(phase) * on
        q, q_t = x[len(COORDINATES) :], x_t[len(COORDINATES) :]
        beside = BESIDE if t < inside else -BESIDE
        r = np.concatenate([rail.level(xi) for rail in self.rails])
        slope = np.concatenate([rail.slope(xi + beside) for rail in self.rails])
        w, w_t = phi @ q + r, phi @ q_t + v * (phi_x @ q) + v * slope
        u, u_t = self.wheels @ x[: len(COORDINATES)], self.wheels @ x_t[: len(COORDINATES)]
        spring = self.spring
        return phi, self.loads + spring.stiffness * (w - u) + spring.damping * (w_t - u_t)

    def rate(self, t: float, state: Array, inside: float, aloft: Array) -> Array:
        """(x', x'') with the wheels that are aloft (8,) on nothing."""
        size = len(self.mass)
        x, x_t = state[:size], state[size:]
        phi, force = self.squeeze(t, x, x_t, inside)
        force = np.where(aloft, 0.0, force)
        F = -self.K @ x - self.C @ x_t
        F[: len(COORDINATES)] += self.wheels.T @ (force - self.loads)
        F[len(COORDINATES) :] -= phi.T @ force
        return np.concatenate([x_t, F / self.mass])

    def events(self) -> list[float]:
        """Times (s) at which an axle enters or leaves the bridge, or crosses a corner of a rail."""
        v, L = self.crossing.velocity, self.crossing.right.length
        corners = [x for rail in self.rails for x in rail.corners]
        return [float((x + d) / v) for x in (0.0, L, *corners) for d in self.distances]

    def integrate(self, times: Array) -> tuple[Array, Array, Array, Array]:
        """x, x', x'' (31 + 2n, nt) and the forces Q (8, nt) at `times`, from rest at the first of them."""
        from scipy.integrate import solve_ivp

        size = len(self.mass)
        start, end = float(times[0]), float(times[-1])
        cuts = [start, *sorted({t for t in self.events() if start < t < end}), end]
        state, aloft = np.zeros(2 * size), np.zeros(8, dtype=bool)
        states, rates = np.zeros((2 * size, len(times))), np.zeros((2 * size, len(times)))
        forces = np.zeros((8, len(times)))
        for begin, stop in pairwise(cuts):
            middle, t = (begin + stop) / 2, begin
            while t < stop:
                changes = [self._change(wheel, middle, bool(aloft[wheel])) for wheel in range(8)]
                found = solve_ivp(
                    self.rate,
                    (t, stop),
                    state,
                    "DOP853",
                    dense_output=True,
                    events=changes,
                    args=(middle, aloft),
                    rtol=RELATIVE,
                    atol=ABSOLUTE,
                    max_step=2e-3,
                )
                if not found.success or found.sol is None or found.t_events is None:
                    raise ArithmeticError(f"reference integration failed: {found.message}")
                inside = (times >= t) & (times <= found.t[-1])
                for j in np.flatnonzero(inside):
                    states[:, j] = found.sol(times[j])
                    rates[:, j] = self.rate(times[j], states[:, j], middle, aloft)
                    _, force = self.squeeze(times[j], states[:size, j], states[size:, j], middle)
                    forces[:, j] = np.where(aloft, 0.0, force)
                t, state = float(found.t[-1]), found.y[:, -1]
                aloft = aloft.copy()
                for wheel, when in enumerate(found.t_events):
                    if len(when):
                        aloft[wheel] = not aloft[wheel]
        return states[:size], states[size:], rates[size:], forces

    def _change(self, wheel: int, inside: float, aloft: bool) -> Callable[..., float]:
        """An event of solve_ivp: the contact of a wheel opens, or closes if it is aloft."""
        size = len(self.mass)

        def force(t: float, state: Array, *_: Any) -> float:
            return float(self.squeeze(t, state[:size], state[size:], inside)[1][wheel])

        force.terminal, force.direction = True, 1.0 if aloft else -1.0  # type: ignore[attr-defined]
        return force


def hertz_channels(
    case: Mapping[str, Any], times: Array, rails: tuple[Rail, Rail] = (LEVEL, LEVEL)
) -> dict[str, Array]:
    """Channels of the results file for a case with the contact `hertz`, at `times` from the start.

    `case` is a mapping with the keys of the case file and SI numbers; `rails` the right and the left one.
    """
    crossing, contact = crossing_from_case(case), case["contact"]
    given = {
        name: float(contact[name]) for name in ("stiffness", "damping", "running_circle") if name in contact
    }
    system = HertzSystem(crossing, HertzSpring(**given), rails)
    x, x_t, x_tt, forces = system.integrate(np.asarray(times, dtype=float))
    out: dict[str, Array] = {}
    for suffix, u in (("", x), ("_velocity", x_t), ("_acceleration", x_tt)):
        out |= {f"{name}{suffix}": u[i] for i, name in enumerate(COORDINATES)}
        for side, first in (("right", 0), ("left", system.n)):
            beam = crossing.right
            middle = math.sqrt(2 / beam.length) * np.sin(np.arange(1, system.n + 1) * math.pi / 2)
            modes = u[len(COORDINATES) + first : len(COORDINATES) + first + system.n]
            out[f"{side}_midspan{suffix}"] = middle @ modes
    out |= forces_of_bodies(crossing.train, crossing.gravity, out)
    for wheel in range(8):
        name = f"wheel_{wheel % 4 + 1}_{'right' if wheel < 4 else 'left'}"
        out[f"{name}_force"] = forces[wheel]
        out[f"{name}_unloading"] = 1 - forces[wheel] / system.loads[wheel]
    return out
