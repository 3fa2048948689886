"""Balance laws of the full coupled system, as functions of histories.

Energy: stored = kinetic (the kinematic wheelset y left out) + strain of the beams + every spring + the
potential sum f_g w(xi) of the loads. Its rate is the power of the drive, that is of what pushes the train
along, sum over the wheels on the bridge of (f_g - k s) v w_x(xi) (with the convective term
(f_g - k s - c s') v w_x), less what dampers and beams dissipate. Momentum: nothing holds the train sideways,
in yaw or in roll, so these momenta stay zero.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from tbi_cli.verify.references.energies import COORDINATES, DYNAMIC, train_matrices
from tbi_cli.verify.references.parameters import Array, Crossing
from tbi_cli.verify.references.printed import wheel_points
from tbi_cli.verify.references.sampled import pieces, running_integral
from tbi_cli.verify.references.statics import static_wheel_loads


@dataclass(frozen=True)
class EnergyBalance:
    """stored, dissipated, driven (nt,) [J]; error = stored + dissipated - driven."""

    stored: Array
    dissipated: Array
    driven: Array

    @property
    def error(self) -> Array:
        """(nt,) [J], zero for an exact solution."""
        return self.stored + self.dissipated - self.driven


def energy_balance(crossing: Crossing, time: Array, h: Mapping[str, Array]) -> EnergyBalance:
    """Energies [J] at equally spaced `time` (nt,), from channels with velocities and modal coordinates.

    Powers are integrated by a spline of degree 7 between one event and the next, on and off decided in the
    middle: entries and exits must fall on samples.
    """
    matrices = train_matrices(crossing.train)
    dynamic = list(DYNAMIC)
    u = np.array([h[name] for name in COORDINATES])[dynamic]
    u_t = np.array([h[f"{name}_velocity"] for name in COORDINATES])[dynamic]
    kinetic = 0.5 * matrices.M[dynamic] @ u_t**2
    springs = 0.5 * np.einsum("it,ij,jt->t", u, matrices.K[np.ix_(dynamic, dynamic)], u)
    dissipation = np.einsum("it,ij,jt->t", u_t, matrices.C[np.ix_(dynamic, dynamic)], u_t)
    for side, beam in (("right", crossing.right), ("left", crossing.left)):
        for i in range(beam.n):
            q, q_t = h[f"{side}_mode_{i + 1}"], h[f"{side}_mode_{i + 1}_velocity"]
            kinetic = kinetic + 0.5 * beam.mu * q_t**2
            springs = springs + 0.5 * beam.EI * beam.wave_numbers[i] ** 4 * q**2
            dissipation = dissipation + beam.c[i] * q_t**2

    rows, loads = matrices.wheel_rows[:, dynamic], np.tile(static_wheel_loads(crossing), 2)[:, None]
    k, c = matrices.wheel_k[:, None], matrices.wheel_c[:, None]
    stored = np.empty(len(time))
    dissipated, driven = np.zeros(len(time)), np.zeros(len(time))
    L, v = crossing.right.length, crossing.velocity
    entries = crossing.train.axle_distances / v
    for piece in pieces(crossing, time):
        start = piece.start
        t = time[piece]
        middle = 0.5 * (t[0] + t[-1]) - entries
        on = np.repeat(((middle >= 0) & (middle <= L / v)).astype(float)[:, None], len(t), axis=1)
        under = wheel_points(crossing, t, {name: x[piece] for name, x in h.items()}, on)
        s = rows @ u[:, piece] - under.w
        s_t = rows @ u_t[:, piece] - under.w_t - (v * under.w_x if crossing.convective else 0.0)
        carried = k * s + (c * s_t if crossing.convective else 0.0)
        stored[piece] = kinetic[piece] + springs[piece] + np.sum(0.5 * k * s**2 + loads * under.w, axis=0)
        lost = dissipation[piece] + np.sum(c * s_t**2, axis=0)
        pushed = np.sum((loads - carried) * v * under.w_x, axis=0)
        dissipated[piece] = dissipated[start] + running_integral(t, lost)
        driven[piece] = driven[start] + running_integral(t, pushed)
    return EnergyBalance(stored, dissipated, driven)


def lateral_momentum(crossing: Crossing, h: Mapping[str, Array]) -> tuple[Array, float]:
    """Sum of m z' over all bodies (nt,) [kg m/s], which stays zero, and the largest sum of |m z'|."""
    terms = np.array([m * h[f"{body}_z_velocity"] for body, m in _masses(crossing).items()])
    return terms.sum(axis=0), float(np.abs(terms).sum(axis=0).max())


def roll_momentum(crossing: Crossing, h: Mapping[str, Array]) -> tuple[Array, float]:
    """Angular momentum about x (nt,) [kg m2/s], which stays zero, and the largest sum of its terms' sizes.

    Sum of J theta_x' + m z' Y, with Y the height of each body's centre of mass above the wheelsets' as the
    lateral springs have it: h_w for a bogie, h_w + h_b + h_c for the car body. In a roll about the axles a
    body's centre moves by u_z = theta_x Y, and the free wheelsets let no roll moment through.
    """
    t = crossing.train
    heights = (t.h_w + t.h_b + t.h_c, t.h_w, t.h_w, 0.0, 0.0, 0.0, 0.0)
    inertias = (t.car_roll, t.bogies[0].roll, t.bogies[1].roll, *[t.wheelset_roll] * 4)
    terms = np.array(
        [
            J * h[f"{body}_roll_velocity"] + m * Y * h[f"{body}_z_velocity"]
            for (body, m), J, Y in zip(_masses(crossing).items(), inertias, heights, strict=True)
        ]
    )
    return terms.sum(axis=0), float(np.abs(terms).sum(axis=0).max())


def wheel_force_sum(crossing: Crossing, h: Mapping[str, Array]) -> tuple[Array, Array]:
    """Sum of the eight wheel forces, and weight + sum of m r'' [N], (nt,) each: equal if `physical`."""
    wheels = [h[f"wheel_{k}_{side}_force"] for k in (1, 2, 3, 4) for side in ("right", "left")]
    masses = _masses(crossing)
    weight = sum(masses.values()) * crossing.gravity
    inertia = [m * h[f"{body}_y_acceleration"] for body, m in masses.items()]
    return np.sum(wheels, axis=0), weight + np.sum(inertia, axis=0)


def _masses(crossing: Crossing) -> dict[str, float]:
    t = crossing.train
    bodies = ("car_body", "front_bogie", "rear_bogie", *(f"wheelset_{k}" for k in (1, 2, 3, 4)))
    values = (t.car_mass, t.bogies[0].mass, t.bogies[1].mass, *[t.wheelset_mass] * 4)
    return dict(zip(bodies, values, strict=True))
