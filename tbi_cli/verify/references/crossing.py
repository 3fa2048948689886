"""The 31-degree-of-freedom train over two beams, integrated with DOP853: the solver's oracle.

The equations are those of Eqs. (7), (8) and (12) with the contact as printed: at each wheel the primary
suspension acts on the beam itself, and a wheelset's own y is the mean of the beams under it. DOP853 is
restarted at every entry and exit of an axle, so no step crosses a kink.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from tbi_cli.verify.references.energies import COORDINATES, DYNAMIC, train_matrices
from tbi_cli.verify.references.parameters import Array, Crossing, crossing_from_case
from tbi_cli.verify.references.piecewise import integrate_between_events
from tbi_cli.verify.references.statics import forces_of_bodies, static_wheel_loads

# An axle this close [m per m of span] to a support counts as on the bridge, so that a sample that falls on
# an entry or exit up to rounding is read as "0 <= xi <= L" says.
ON_BRIDGE_MARGIN = 1e-9


@dataclass(frozen=True)
class Motion:
    """Everything that moves, at nt times.

    u, u_t, u_tt (31, nt): the coordinates of Eq. (9), with the kinematic wheelset y filled in, and their
    derivatives. q, q_t, q_tt (2n, nt): modal coordinates, right then left. stretch, force (8, nt): stretch
    [m] of each primary vertical spring and the force [N] k s + c s' in it (right 1-4, left 1-4).
    beam (8, nt), beam_slope (8, nt): w and w_x under each wheel, zero off the bridge. on (4, nt): axle on the
    bridge.
    """

    time: Array
    u: Array
    u_t: Array
    u_tt: Array
    q: Array
    q_t: Array
    q_tt: Array
    stretch: Array
    force: Array
    beam: Array
    beam_slope: Array
    on: Array


class CoupledSystem:
    """The coupled second-order equations of a crossing, M x'' = F(t, x, x'), x = (27 train, 2n modal)."""

    def __init__(self, crossing: Crossing) -> None:
        self.crossing = crossing
        self.matrices = train_matrices(crossing.train)
        right, left = crossing.right, crossing.left
        self.n = right.n
        self.distances = crossing.train.axle_distances
        self.static_loads = np.tile(static_wheel_loads(crossing), 2)
        dynamic = list(DYNAMIC)
        n_train, n_all = len(dynamic), len(dynamic) + 2 * self.n
        beams = slice(n_train, n_all)
        self.mass = np.concatenate(
            [self.matrices.M[dynamic], np.full(self.n, right.mu), np.full(self.n, left.mu)]
        )
        self.K = np.zeros((n_all, n_all))
        self.C = np.zeros((n_all, n_all))
        self.K[:n_train, :n_train] = self.matrices.K[np.ix_(dynamic, dynamic)]
        self.C[:n_train, :n_train] = self.matrices.C[np.ix_(dynamic, dynamic)]
        self.K[beams, beams] = np.diag(
            np.concatenate([right.EI * right.wave_numbers**4, left.EI * left.wave_numbers**4])
        )
        self.C[beams, beams] = np.diag(np.concatenate([right.c, left.c]))
        self.wheel_rows = self.matrices.wheel_rows[:, dynamic]
        self.n_train = n_train

    @property
    def size(self) -> int:
        """Number of second-order equations, 27 + 2n."""
        return len(self.mass)

    def events(self) -> Array:
        """Sorted times [s] at which an axle enters or leaves the bridge."""
        v, L = self.crossing.velocity, self.crossing.right.length
        return np.unique(np.concatenate([self.distances / v, (self.distances + L) / v]))

    def positions(self, time: Array | float) -> Array:
        """(4,) or (4, nt) positions xi_k [m] of the axles."""
        xi: Array = np.subtract.outer(-self.distances, -self.crossing.velocity * np.asarray(time))
        return xi

    def axles_on(self, time: Array | float) -> Array:
        """1.0 where the axle is on the bridge (supports included), 0.0 elsewhere."""
        xi, L = self.positions(time), self.crossing.right.length
        margin = ON_BRIDGE_MARGIN * L
        return ((xi >= -margin) & (xi <= L + margin)).astype(float)

    def shapes(self, time: float, on: Array, derivative: int = 0) -> Array:
        """(8, 2n): phi_i, phi_i' or phi_i'' under each wheel, zero for the other beam and off the bridge."""
        k, L = self.crossing.right.wave_numbers, self.crossing.right.length
        phase = np.outer(self.positions(time), k) + derivative * math.pi / 2
        phi = math.sqrt(2 / L) * k**derivative * np.sin(phase) * on[:, None]
        out = np.zeros((8, 2 * self.n))
        out[:4, : self.n] = phi
        out[4:, self.n :] = phi
        return out

    def wheel_forces(self, time: float, x: Array, x_t: Array, on: Array) -> tuple[Array, Array, Array]:
        """phi (8, 2n), stretch (8,) and force k s + c s' (8,) of the primary vertical springs, Eq. (12b)."""
        phi = self.shapes(time, on)
        s = self.wheel_rows @ x[: self.n_train] - phi @ x[self.n_train :]
        s_t = self.wheel_rows @ x_t[: self.n_train] - phi @ x_t[self.n_train :]
        if self.crossing.convective:
            s_t = s_t - self.crossing.velocity * (self.shapes(time, on, 1) @ x[self.n_train :])
        return phi, s, self.matrices.wheel_k * s + self.matrices.wheel_c * s_t

    def acceleration(self, time: float, x: Array, x_t: Array, on: Array) -> Array:
        """x'' (27 + 2n,) of the equations of motion, Eqs. (12), with the axles `on` (4,) on the bridge."""
        phi, _, force = self.wheel_forces(time, x, x_t, on)
        F = -self.K @ x - self.C @ x_t
        F[: self.n_train] -= self.wheel_rows.T @ force
        F[self.n_train :] += phi.T @ (force - self.static_loads)
        result: Array = F / self.mass
        return result

    def integrate(self, times: Array, rtol: float = 1e-10, atol: float = 1e-14) -> tuple[Array, Array]:
        """x and x' (27 + 2n, nt) at increasing `times` >= 0, from rest at t = 0."""
        size = self.size

        def rate_between(start: float, stop: float) -> Callable[[float, Array], Array]:
            on = self.axles_on(0.5 * (start + stop))

            def rate(t: float, y: Array) -> Array:
                x, x_t = y[:size], y[size:]
                return np.concatenate([x_t, self.acceleration(t, x, x_t, on)])

            return rate

        samples = integrate_between_events(rate_between, 2 * size, self.events(), times, rtol, atol)
        return samples[:size], samples[size:]

    def displacements(self, x: Array) -> dict[str, Array]:
        """The dynamic coordinates and both mid-spans, name -> (nt,), from x (27 + 2n, nt)."""
        out = {COORDINATES[i]: row for i, row in zip(DYNAMIC, x[: self.n_train], strict=True)}
        middle = self.midspan_shape()
        out["right_midspan"] = middle @ x[self.n_train : self.n_train + self.n]
        out["left_midspan"] = middle @ x[self.n_train + self.n :]
        return out

    def midspan_shape(self) -> Array:
        """(n,) phi_i(L/2)."""
        beam = self.crossing.right
        shape: Array = math.sqrt(2 / beam.length) * np.sin(beam.wave_numbers * beam.length / 2)
        return shape

    def motion(self, times: Array, **tolerances: float) -> Motion:
        """Integrate, and form accelerations and wheel quantities at each sample."""
        x, x_t = self.integrate(times, **tolerances)
        on = self.axles_on(times)
        x_tt = np.array([self.acceleration(t, x[:, j], x_t[:, j], on[:, j]) for j, t in enumerate(times)]).T
        return self.motion_of(times, x, x_t, x_tt)

    def motion_of(self, times: Array, x: Array, x_t: Array, x_tt: Array) -> Motion:
        """The motion that x, x' and x'' (27 + 2n, nt) at each sample are."""
        nt, v, nb = len(times), self.crossing.velocity, self.n_train
        stretch, force = np.empty((8, nt)), np.empty((8, nt))
        w, w_t, w_tt, w_x = (np.empty((8, nt)) for _ in range(4))
        on_all = self.axles_on(times)
        for j, t in enumerate(times):
            on = on_all[:, j]
            phi, stretch[:, j], force[:, j] = self.wheel_forces(t, x[:, j], x_t[:, j], on)
            q, q_t, q_tt = x[nb:, j], x_t[nb:, j], x_tt[nb:, j]
            phi_x, phi_xx = self.shapes(t, on, 1), self.shapes(t, on, 2)
            w[:, j], w_x[:, j] = phi @ q, phi_x @ q
            w_t[:, j] = phi @ q_t + v * (phi_x @ q)
            w_tt[:, j] = phi @ q_tt + 2 * v * (phi_x @ q_t) + v**2 * (phi_xx @ q)

        def all_coordinates(dynamic: Array, wheel: Array) -> Array:
            out = np.empty((len(COORDINATES), nt))
            out[list(DYNAMIC)] = dynamic
            for k in range(4):
                out[COORDINATES.index(f"wheelset_{k + 1}_y")] = (wheel[k] + wheel[4 + k]) / 2
            return out

        return Motion(
            time=times,
            u=all_coordinates(x[:nb], w),
            u_t=all_coordinates(x_t[:nb], w_t),
            u_tt=all_coordinates(x_tt[:nb], w_tt),
            q=x[nb:],
            q_t=x_t[nb:],
            q_tt=x_tt[nb:],
            stretch=stretch,
            force=force,
            beam=w,
            beam_slope=w_x,
            on=on_all,
        )


def crossing_channels(case: Mapping[str, Any] | Crossing, times: Array) -> dict[str, Array]:
    """Every channel of the results file at `times` (increasing, from 0): name -> (nt,) array, SI.

    `case` is a mapping with the keys of the case file and SI numbers, or a `Crossing`.
    Displacements, velocities and accelerations of the 31 coordinates; mid-span of both beams; modal
    coordinates; forces on the car body, under the bogies and of each wheel on its rail.
    """
    crossing = case if isinstance(case, Crossing) else crossing_from_case(case)
    system = CoupledSystem(crossing)
    return channels_of(system, system.motion(np.asarray(times, dtype=float)))


def channels_of(system: CoupledSystem, motion: Motion) -> dict[str, Array]:
    """The channels of the results file from a motion of the system: name -> (nt,)."""
    crossing, n = system.crossing, system.n
    train = crossing.train
    out: dict[str, Array] = {}
    middle = system.midspan_shape()
    for suffix, u in (("", motion.u), ("_velocity", motion.u_t), ("_acceleration", motion.u_tt)):
        out |= {f"{name}{suffix}": u[i] for i, name in enumerate(COORDINATES)}
    for side, modes in (("right", slice(0, n)), ("left", slice(n, 2 * n))):
        out[f"{side}_midspan"] = middle @ motion.q[modes]
        out[f"{side}_midspan_velocity"] = middle @ motion.q_t[modes]
        out[f"{side}_midspan_acceleration"] = middle @ motion.q_tt[modes]
        for suffix, q in (("", motion.q), ("_velocity", motion.q_t), ("_acceleration", motion.q_tt)):
            out |= {f"{side}_mode_{i + 1}{suffix}": row for i, row in enumerate(q[modes])}
    out |= forces_of_bodies(train, crossing.gravity, out)
    for side, first in (("right", 0), ("left", 4)):
        for k in range(4):
            inertia = train.wheelset_mass * out[f"wheelset_{k + 1}_y_acceleration"] / 2
            out[f"wheel_{k + 1}_{side}_force"] = (
                system.static_loads[first + k] - motion.force[first + k] + inertia
            )
    return out
