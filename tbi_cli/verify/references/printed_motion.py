"""Eqs. (12a-f) typed as the paper prints them, for any state: the accelerations that they give.

Printed for the front or the rear end only; the other end follows by exchanging the indices. Eq. (12d) leaves
out the moment of the lateral springs, so it holds with all heights zero.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from tbi_cli.verify.references.parameters import Crossing
from tbi_cli.verify.references.statics import static_wheel_loads


def printed_accelerations(crossing: Crossing, time: float, x: Mapping[str, float]) -> dict[str, float]:
    """Accelerations by Eqs. (12a-f) at `time`, from coordinates and `_velocity` by channel name.

    Keys: the channels that the paper prints an equation for, at both ends. Modal coordinates are q_i.
    """
    t = crossing.train
    l_b1, l_b2 = t.l_b
    l_w = t.l_w
    d, a = t.d, t.a
    loads = static_wheel_loads(crossing)
    n, L, v = crossing.right.n, crossing.right.length, crossing.velocity
    front, rear = t.bogies

    def disp(name: str) -> float:
        return x[name]

    def rate(name: str) -> float:
        return x[f"{name}_velocity"]

    xi = [v * time - distance for distance in t.axle_distances]
    phi = [
        np.array([math.sqrt(2 / L) * math.sin(i * math.pi * s / L) for i in range(1, n + 1)])
        if 0 <= s <= L
        else np.zeros(n)
        for s in xi
    ]
    q = {side: np.array([disp(f"{side}_mode_{i}") for i in range(1, n + 1)]) for side in ("right", "left")}
    q_t = {side: np.array([rate(f"{side}_mode_{i}") for i in range(1, n + 1)]) for side in ("right", "left")}
    phi_q = {(k, side): float(phi[k] @ q[side]) for k in range(4) for side in q}
    phi_q_t = {(k, side): float(phi[k] @ q_t[side]) for k in range(4) for side in q}

    out: dict[str, float] = {}
    k_b1, c_b1 = front.secondary_vertical.k, front.secondary_vertical.c
    k_b2, c_b2 = rear.secondary_vertical.k, rear.secondary_vertical.c
    car, car_t = disp("car_body_y"), rate("car_body_y")
    pitch, pitch_t = disp("car_body_pitch"), rate("car_body_pitch")
    s_1 = car - disp("front_bogie_y") + pitch * l_b1
    s_1_t = car_t - rate("front_bogie_y") + pitch_t * l_b1
    s_2 = car - disp("rear_bogie_y") - pitch * l_b2
    s_2_t = car_t - rate("rear_bogie_y") - pitch_t * l_b2

    # (12a)
    m_c = t.car_mass
    out["car_body_y"] = (
        -2 * c_b1 / m_c * s_1_t - 2 * c_b2 / m_c * s_2_t - 2 * k_b1 / m_c * s_1 - 2 * k_b2 / m_c * s_2
    )
    # (12f)
    I_cz = t.car_pitch
    out["car_body_pitch"] = (
        -2 * c_b1 * l_b1 / I_cz * s_1_t
        + 2 * c_b2 * l_b2 / I_cz * s_2_t
        - 2 * k_b1 * l_b1 / I_cz * s_1
        + 2 * k_b2 * l_b2 / I_cz * s_2
    )

    for j, (end, bogie, s, s_t) in enumerate(
        (("front_bogie", front, s_1, s_1_t), ("rear_bogie", rear, s_2, s_2_t))
    ):
        axles = (2 * j, 2 * j + 1)
        k_b, c_b = bogie.secondary_vertical.k, bogie.secondary_vertical.c
        k_w, c_w = bogie.primary_vertical.k, bogie.primary_vertical.c
        tilt, tilt_t = disp(f"{end}_pitch"), rate(f"{end}_pitch")
        # (12e)
        total = 2 * c_b * s_t + 2 * k_b * s
        for k, arm in zip(axles, (l_w[axles[0]], -l_w[axles[1]]), strict=True):
            total -= c_w * (
                2 * rate(f"{end}_y") - phi_q_t[k, "right"] - phi_q_t[k, "left"] + 2 * tilt_t * arm
            )
            total -= k_w * (2 * disp(f"{end}_y") - phi_q[k, "right"] - phi_q[k, "left"] + 2 * tilt * arm)
        out[f"{end}_y"] = total / bogie.mass
        # (12d)
        roll, roll_t = disp(f"{end}_roll"), rate(f"{end}_roll")
        moment = 2 * c_b * a**2 * (rate("car_body_roll") - roll_t) + 2 * k_b * a**2 * (
            disp("car_body_roll") - roll
        )
        for k in axles:
            own, own_t = disp(f"wheelset_{k + 1}_roll"), rate(f"wheelset_{k + 1}_roll")
            moment += c_w * d * (2 * own_t * d - phi_q_t[k, "right"] + phi_q_t[k, "left"] - 2 * roll_t * d)
            moment += k_w * d * (2 * own * d - phi_q[k, "right"] + phi_q[k, "left"] - 2 * roll * d)
        out[f"{end}_roll"] = moment / bogie.roll

    # (12c), printed for wheelset 2; the yaw arm is dropped in print, so it is put back
    for k in range(4):
        bogie, end = t.bogies[k // 2], ("front_bogie", "rear_bogie")[k // 2]
        arm = l_w[k] if k % 2 == 0 else -l_w[k]
        k_wz, c_wz = bogie.primary_lateral.k, bogie.primary_lateral.c
        name = f"wheelset_{k + 1}_z"
        s = disp(f"{end}_z") - disp(name) - disp(f"{end}_roll") * t.h_w - disp(f"{end}_yaw") * arm
        s_t = rate(f"{end}_z") - rate(name) - rate(f"{end}_roll") * t.h_w - rate(f"{end}_yaw") * arm
        out[name] = (2 * c_wz * s_t + 2 * k_wz * s) / t.wheelset_mass

    # (12b), the right beam; the left with the signs of d reversed
    for side, beam, sign in (("right", crossing.right, 1.0), ("left", crossing.left, -1.0)):
        N = beam.mu
        for i in range(n):
            S = beam.EI * ((i + 1) * math.pi / L) ** 4
            total = -S * q[side][i] / N - beam.c[i] * q_t[side][i] / N
            for k in range(4):
                bogie, end = t.bogies[k // 2], ("front_bogie", "rear_bogie")[k // 2]
                arm = l_w[k] if k % 2 == 0 else -l_w[k]
                wheel = f"wheelset_{k + 1}_roll"
                s = disp(f"{end}_y") - phi_q[k, side] + disp(f"{end}_pitch") * arm
                s += sign * d * (disp(wheel) - disp(f"{end}_roll"))
                s_t = rate(f"{end}_y") - phi_q_t[k, side] + rate(f"{end}_pitch") * arm
                s_t += sign * d * (rate(wheel) - rate(f"{end}_roll"))
                spring = bogie.primary_vertical
                total += phi[k][i] / N * (spring.c * s_t + spring.k * s - loads[k])
            out[f"{side}_mode_{i + 1}"] = float(total)
    return out
