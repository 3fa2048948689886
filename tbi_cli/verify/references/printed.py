"""The equations that the paper prints, evaluated on histories: residuals of Eqs. (29) and (32)-(34).

By Eqs. (12) each residual is identically zero. They are formed from channels and from the deflection of
the beams under the wheels, not from assembled matrices, so they check the assembly; with accelerations
differenced from velocities they check the integrator too.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from tbi_cli.verify.references.parameters import Array, Beam, Crossing
from tbi_cli.verify.references.statics import static_wheel_loads

SIDES = ("right", "left")


@dataclass(frozen=True)
class WheelPoints:
    """The beams under the wheels, (8, nt) each: right wheels 1-4, then left 1-4; zero off the bridge.

    w [m]; w_t: its rate at a fixed place, sum phi_i q_i'; w_x: slope; on (4, nt) axle on the bridge.
    """

    w: Array
    w_t: Array
    w_x: Array
    on: Array


def wheel_points(
    crossing: Crossing, time: Array, h: Mapping[str, Array], on: Array | None = None
) -> WheelPoints:
    """Sum the modes under each wheel from the channels `right_mode_1` ... and their velocities.

    `on` (4, nt) says which axles are on the bridge; by default those with 0 <= xi <= L up to rounding.
    """
    xi = np.subtract.outer(-crossing.train.axle_distances, -crossing.velocity * time)
    L = crossing.right.length
    if on is None:
        on = ((xi >= -1e-9 * L) & (xi <= L * (1 + 1e-9))).astype(float)
    w, w_t, w_x = (np.zeros((8, len(time))) for _ in range(3))
    for s, (side, beam) in enumerate(zip(SIDES, (crossing.right, crossing.left), strict=True)):
        rows = slice(4 * s, 4 * s + 4)
        for i, kappa in enumerate(beam.wave_numbers):
            q = h[f"{side}_mode_{i + 1}"]
            shape = math.sqrt(2 / L) * np.sin(kappa * xi) * on
            w[rows] += shape * q
            w_t[rows] += shape * h[f"{side}_mode_{i + 1}_velocity"]
            w_x[rows] += math.sqrt(2 / L) * kappa * np.cos(kappa * xi) * on * q
    return WheelPoints(w, w_t, w_x, on)


def wheelset_torque(crossing: Crossing, h: Mapping[str, Array], under: WheelPoints) -> dict[str, Array]:
    """tau_wk [N m] (nt,) of Eq. (29) for each wheelset: identically zero."""
    train, out = crossing.train, {}
    d = train.d
    for k in range(4):
        end = "front_bogie" if k < 2 else "rear_bogie"
        spring = train.bogies[k // 2].primary_vertical
        name = f"wheelset_{k + 1}_roll"
        rate = _beam_rate(crossing, under)
        damper = 2 * h[f"{end}_roll_velocity"] * d - rate[4 + k] + rate[k] - 2 * h[f"{name}_velocity"] * d
        stretch = 2 * h[f"{end}_roll"] * d - under.w[4 + k] + under.w[k] - 2 * h[name] * d
        out[f"Eq. (29), wheelset {k + 1}"] = (
            h[f"{name}_acceleration"] * train.wheelset_roll - spring.c * d * damper - spring.k * d * stretch
        )
    return out


def bogie_and_body_forces(crossing: Crossing, h: Mapping[str, Array], under: WheelPoints) -> dict[str, Array]:
    """F_fb - f_b, F_rb - f_b and F_tb - f_t [N] (nt,) of Eqs. (32)-(34): identically zero."""
    train, out = crossing.train, {}
    y, y_t = h["car_body_y"], h["car_body_y_velocity"]
    pitch, pitch_t = h["car_body_pitch"], h["car_body_pitch_velocity"]
    rate = _beam_rate(crossing, under)
    body = train.car_mass * h["car_body_y_acceleration"]
    for j, (end, number) in enumerate((("front_bogie", 32), ("rear_bogie", 33))):
        bogie, X_b = train.bogies[j], (train.l_b[0], -train.l_b[1])[j]
        k_b, c_b = bogie.secondary_vertical.k, bogie.secondary_vertical.c
        k_w, c_w = bogie.primary_vertical.k, bogie.primary_vertical.c
        r, r_t, tilt, tilt_t = (h[f"{end}_{x}"] for x in ("y", "y_velocity", "pitch", "pitch_velocity"))
        secondary = 2 * c_b * (y_t - r_t + pitch_t * X_b) + 2 * k_b * (y - r + pitch * X_b)
        residual = h[f"{end}_y_acceleration"] * bogie.mass - secondary
        for k in (2 * j, 2 * j + 1):
            X_w = train.l_w[k] if k % 2 == 0 else -train.l_w[k]
            residual = residual + c_w * (2 * r_t - rate[k] - rate[4 + k] + 2 * tilt_t * X_w)
            residual = residual + k_w * (2 * r - under.w[k] - under.w[4 + k] + 2 * tilt * X_w)
        out[f"Eq. ({number}), {end.replace('_', ' ')}"] = residual
        body = body + secondary
    out["Eq. (34), car body"] = body
    return out


def wheel_force_residual(
    crossing: Crossing, h: Mapping[str, Array], under: WheelPoints, time: Array
) -> dict[str, Array]:
    """N q_i'' + c q_i' + S q_i + sum phi_i (wheel force - m_w r''_wy / 2), [N m^0.5] (nt,): zero.

    The force that enters a beam is that of the wheel on its rail without the wheelset's inertia.
    """
    out = {}
    xi = np.subtract.outer(-crossing.train.axle_distances, -crossing.velocity * time)
    half = crossing.train.wheelset_mass / 2
    for side, beam in zip(SIDES, (crossing.right, crossing.left), strict=True):
        for i, kappa in enumerate(beam.wave_numbers):
            name = f"{side}_mode_{i + 1}"
            residual = beam.mu * h[f"{name}_acceleration"] + beam.c[i] * h[f"{name}_velocity"]
            residual = residual + beam.EI * kappa**4 * h[name]
            for k in range(4):
                entering = h[f"wheel_{k + 1}_{side}_force"] - half * h[f"wheelset_{k + 1}_y_acceleration"]
                shape = math.sqrt(2 / beam.length) * np.sin(kappa * xi[k]) * under.on[k]
                residual = residual + shape * entering
            out[name] = residual
    return out


def _beam_rate(crossing: Crossing, under: WheelPoints) -> Array:
    """The rate of the beam that the primary dampers feel, with the convective part if the case has it."""
    return under.w_t + crossing.velocity * under.w_x if crossing.convective else under.w_t


def beam_residual(
    crossing: Crossing, h: Mapping[str, Array], under: WheelPoints, time: Array
) -> dict[str, Array]:
    """N (q_i'' - right-hand side) of Eq. (12b) for every mode of both beams, [N m^0.5] (nt,)."""
    train, out = crossing.train, {}
    d = train.d
    rate = _beam_rate(crossing, under)
    xi = np.subtract.outer(-train.axle_distances, -crossing.velocity * time)
    loads = static_wheel_loads(crossing)
    beams: tuple[Beam, Beam] = (crossing.right, crossing.left)
    for s, (side, beam) in enumerate(zip(SIDES, beams, strict=True)):
        sign = -1.0 if side == "right" else 1.0
        for i, kappa in enumerate(beam.wave_numbers):
            name = f"{side}_mode_{i + 1}"
            load = np.zeros(len(time))
            for k in range(4):
                end = "front_bogie" if k < 2 else "rear_bogie"
                spring = train.bogies[k // 2].primary_vertical
                X_w = train.l_w[k] if k % 2 == 0 else -train.l_w[k]

                def point(
                    suffix: str, end: str = end, X_w: float = X_w, k: int = k, sign: float = sign
                ) -> Array:
                    return (
                        h[f"{end}_y{suffix}"]
                        + h[f"{end}_pitch{suffix}"] * X_w
                        + sign * d * (h[f"{end}_roll{suffix}"] - h[f"wheelset_{k + 1}_roll{suffix}"])
                    )

                force = spring.c * (point("_velocity") - rate[4 * s + k])
                force = force + spring.k * (point("") - under.w[4 * s + k])
                shape = math.sqrt(2 / beam.length) * np.sin(kappa * xi[k]) * under.on[k]
                load += shape * (force - loads[k])
            out[f"Eq. (12b), {side} mode {i + 1}"] = (
                beam.mu * h[f"{name}_acceleration"]
                + beam.c[i] * h[f"{name}_velocity"]
                + beam.EI * kappa**4 * h[name]
                - load
            )
    return out
