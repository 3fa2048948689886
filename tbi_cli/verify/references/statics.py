"""What stands on wheels and bogies, from the train's equations of motion: no lever is written out."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tbi_cli.verify.references.energies import COORDINATES, train_matrices
from tbi_cli.verify.references.parameters import Array, Crossing, Train

VERTICAL = tuple(i for i, name in enumerate(COORDINATES) if name.endswith(("body_y", "bogie_y", "pitch")))


def standing_loads(train: Train, gravity: float) -> Array:
    """(4,) load [N] of one wheel of each axle: the train is let down on its springs, K u = -M g.

    Both sides are alike, so that nothing but the vertical motion and pitch of car body and bogies takes part.
    """
    matrices, rows = train_matrices(train), list(VERTICAL)
    wheels, k = matrices.wheel_rows[:, rows], matrices.wheel_k
    stiffness = matrices.K[np.ix_(rows, rows)] + wheels.T @ (k[:, None] * wheels)
    heavy = np.array([COORDINATES[i].endswith("_y") for i in rows])
    sunk = np.linalg.solve(stiffness, -gravity * matrices.M[rows] * heavy)
    loads: Array = -k[:4] * (wheels[:4] @ sunk) + train.wheelset_mass * gravity / 2
    return loads


def static_wheel_loads(crossing: Crossing) -> Array:
    """(4,) static load f_g [N] of one wheel of each axle, in either reading of Eq. (13a)."""
    t, g = crossing.train, crossing.gravity
    if crossing.static_load == "paper":
        weight = t.car_mass + t.bogies[0].mass + t.bogies[1].mass + 8 * t.wheelset_mass
        return np.full(4, weight * g / 4)
    return standing_loads(t, g)


def forces_of_bodies(train: Train, gravity: float, h: Mapping[str, Array]) -> dict[str, Array]:
    """Forces [N] (nt,) on the car body and under both bogies that its and their accelerations take.

    Newton and Euler for the car body give what its bogies push up with, S_1 + S_2 = m_c (g + r_cy'') and
    S_1 l_b1 - S_2 l_b2 = I_cz theta_cz''; Newton for a bogie then what its wheels push up with.
    """
    (l_b1, l_b2), m_c = train.l_b, train.car_mass
    body = m_c * (gravity + h["car_body_y_acceleration"])
    moment = train.car_pitch * h["car_body_pitch_acceleration"]
    pushes = np.linalg.solve(np.array([[1.0, 1.0], [l_b1, -l_b2]]), np.array([body, moment]))
    out = {"car_body_force": body}
    for end, bogie, push in zip(("front_bogie", "rear_bogie"), train.bogies, pushes, strict=True):
        out[f"{end}_force"] = push + bogie.mass * (gravity + h[f"{end}_y_acceleration"])
    return out
