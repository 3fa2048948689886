"""The train's matrices from the energies of Eqs. (1a-c), bracket by bracket as printed.

Each coordinate of Eq. (9) is a unit vector of R^31, so a bracket of Eq. (1b) is typed as the paper
prints it and comes out as the row that takes the coordinates to a spring's stretch. Then E_p is the sum
of k (row eta)^2 / 2 and Lagrange's equations (7) give K = sum k row^T row, and C likewise.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tbi_cli.verify.references.parameters import Array, Train

# Eq. (9): y, z, pitch, roll, yaw of the car body and the bogies; y, z, roll, yaw of the wheelsets.
COORDINATES: tuple[str, ...] = (
    *(
        f"{b}_{m}"
        for b in ("car_body", "front_bogie", "rear_bogie")
        for m in ("y", "z", "pitch", "roll", "yaw")
    ),
    *(f"wheelset_{k}_{m}" for k in (1, 2, 3, 4) for m in ("y", "z", "roll", "yaw")),
)
# A wheelset's own y follows the beams and has no equation of motion.
KINEMATIC = tuple(COORDINATES.index(f"wheelset_{k}_y") for k in (1, 2, 3, 4))
DYNAMIC = tuple(i for i in range(len(COORDINATES)) if i not in KINEMATIC)


@dataclass(frozen=True)
class Matrices:
    """Lagrange's equations of the train, in the 31 coordinates of Eq. (9).

    M (31,) masses and inertias; K, C (31, 31) of every spring-damper but the primary vertical ones.
    wheel_rows (8, 31): the stretch of each primary vertical spring but for the beam under it, that is
    r_by + theta_bz X -+ theta_bx d +- theta_wx d; right wheels 1-4, then left 1-4. wheel_k, wheel_c (8,).
    """

    M: Array
    K: Array
    C: Array
    wheel_rows: Array
    wheel_k: Array
    wheel_c: Array


def train_matrices(train: Train) -> Matrices:
    """M, K, C and the wheel rows of the train, from the brackets of Eqs. (1a-c)."""
    unit = dict(zip(COORDINATES, np.eye(len(COORDINATES)), strict=True))
    M = np.empty(len(COORDINATES))
    K = np.zeros((len(COORDINATES), len(COORDINATES)))
    C = np.zeros_like(K)
    a, d, h_c, h_b, h_w = train.a, train.d, train.h_c, train.h_b, train.h_w

    def add(k: float, c: float, bracket: Array) -> None:
        K[...] += k * np.outer(bracket, bracket)
        C[...] += c * np.outer(bracket, bracket)

    def name_masses(body: str, mass: float, roll: float, yaw: float, pitch: float | None = None) -> None:
        values = {"y": mass, "z": mass, "roll": roll, "yaw": yaw, "pitch": pitch}
        for motion, value in values.items():
            if value is not None:
                M[COORDINATES.index(f"{body}_{motion}")] = value

    r_cy, r_cz = unit["car_body_y"], unit["car_body_z"]
    th_cx, th_cy, th_cz = unit["car_body_roll"], unit["car_body_yaw"], unit["car_body_pitch"]
    name_masses("car_body", train.car_mass, train.car_roll, train.car_yaw, train.car_pitch)

    right: list[Array] = []
    left: list[Array] = []
    wheel_k, wheel_c = [], []
    for j, end in enumerate(("front_bogie", "rear_bogie")):
        bogie = train.bogies[j]
        name_masses(end, bogie.mass, bogie.roll, bogie.yaw, bogie.pitch)
        r_by, r_bz = unit[f"{end}_y"], unit[f"{end}_z"]
        th_bx, th_by, th_bz = unit[f"{end}_roll"], unit[f"{end}_yaw"], unit[f"{end}_pitch"]
        X_b = train.l_b[0] if j == 0 else -train.l_b[1]

        s = bogie.secondary_vertical
        add(s.k, s.c, r_cy - r_by + th_cz * X_b - th_cx * a + th_bx * a)
        add(s.k, s.c, r_cy - r_by + th_cz * X_b + th_cx * a - th_bx * a)
        s = bogie.secondary_lateral
        add(2 * s.k, 2 * s.c, r_cz - th_cx * h_c - th_cy * X_b - r_bz - th_bx * h_b)
        s = bogie.secondary_longitudinal
        add(2 * s.k, 2 * s.c, a * (th_cy - th_by))

        for axle in (2 * j, 2 * j + 1):
            wheelset = f"wheelset_{axle + 1}"
            name_masses(wheelset, train.wheelset_mass, train.wheelset_roll, train.wheelset_yaw)
            r_wz, th_wx, th_wy = unit[f"{wheelset}_z"], unit[f"{wheelset}_roll"], unit[f"{wheelset}_yaw"]
            X_w = train.l_w[axle] if axle % 2 == 0 else -train.l_w[axle]

            right.append(r_by + th_bz * X_w - th_bx * d + th_wx * d)
            left.append(r_by + th_bz * X_w + th_bx * d - th_wx * d)
            wheel_k.append(bogie.primary_vertical.k)
            wheel_c.append(bogie.primary_vertical.c)
            s = bogie.primary_lateral
            add(2 * s.k, 2 * s.c, r_bz - th_bx * h_w - th_by * X_w - r_wz)
            s = bogie.primary_longitudinal
            add(2 * s.k, 2 * s.c, d * (th_by - th_wy))

    return Matrices(M, K, C, np.array(right + left), np.array(wheel_k * 2), np.array(wheel_c * 2))
