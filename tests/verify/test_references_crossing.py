"""The oracle against the laws that no assembly can fake, and against itself."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from tbi_cli.verify.references.balance import (
    energy_balance,
    lateral_momentum,
    roll_momentum,
    wheel_force_sum,
)
from tbi_cli.verify.references.crossing import CoupledSystem, channels_of, crossing_channels
from tbi_cli.verify.references.frequencies import vehicle_frequencies
from tbi_cli.verify.references.parameters import Crossing, crossing_from_case
from tbi_cli.verify.references.printed import (
    beam_residual,
    bogie_and_body_forces,
    wheel_points,
    wheelset_torque,
)
from tbi_cli.verify.references.scaling import mirror_sign, mirrored, scaled
from tbi_cli.verify.references.state_space import state_space

SPRING = {"stiffness": 168.9e3, "damping": 0.0}
PAPER: dict = {
    "train": {
        "model": "full-31dof",
        "car_body": {
            "mass": 40e3,
            "roll_inertia": 110.2e3,
            "yaw_inertia": 1.5722e6,
            "pitch_inertia": 1.666e6,
        },
        "bogie": {"mass": 2280.0, "roll_inertia": 1847.0, "yaw_inertia": 2280.0, "pitch_inertia": 1249.0},
        "wheelset": {"mass": 1901.8, "roll_inertia": 685.0, "yaw_inertia": 685.0},
        "secondary": {
            "vertical": {"stiffness": 260e3, "damping": 40e3},
            "lateral": {"stiffness": 168.9e3, "damping": 58.8e3},
            "longitudinal": SPRING,
        },
        "primary": {
            "vertical": {"stiffness": 1.176e6, "damping": 29.6e3},
            "lateral": {"stiffness": 0.98e6},
            "longitudinal": {"stiffness": 0.98e6},
        },
        "geometry": {
            "bogie_distance": 17.5,
            "wheelbase": 2.5,
            "secondary_half_spacing": 1.23,
            "primary_half_spacing": 1.0,
            "car_body_to_secondary": 0.52,
            "secondary_to_bogie": 0.29,
            "bogie_to_axle": 0.08,
        },
    },
    "bridge": {
        "length": 50.0,
        "modes": 4,
        "right": {"youngs_modulus": 207e9, "second_moment": 0.2, "mass_per_length": 20e3, "damping": 10e3},
        "left": {"youngs_modulus": 200e9, "second_moment": 0.2, "mass_per_length": 18e3, "damping": 10e3},
    },
    "contact": {"static_load": "paper"},
    "velocity": 300 / 3.6,
    "gravity": 9.81,
}


def lopsided() -> dict:
    """Front and rear ends of different masses, springs and lengths: nothing cancels by symmetry."""
    train = {
        **PAPER["train"],
        "front_bogie": {"mass": 3000.0, "secondary": {"vertical": {"stiffness": 300e3, "damping": 25e3}}},
        "rear_bogie": {
            "roll_inertia": 2500.0,
            "primary": {"vertical": {"stiffness": 0.9e6, "damping": 12e3}},
        },
        "geometry": {**PAPER["train"]["geometry"], "l_b1": 7.0, "l_w1": 1.5, "l_w4": 0.75},
    }
    return {**PAPER, "train": train, "contact": {}}


def crossing(case: dict = PAPER, **changes: object) -> Crossing:
    return dataclasses.replace(crossing_from_case(case), **changes)


def test_paper_case_at_300_kmh() -> None:
    # The numbers an independent implementation found (issue 2), there to 0.5 %.
    t = np.arange(4201) * 1e-3
    h = crossing_channels(PAPER, t)
    for name, value in (
        ("right_midspan", 0.0464),
        ("car_body_y", 0.0311),
        ("car_body_y_acceleration", 0.828),
    ):
        assert np.abs(h[name]).max() == pytest.approx(value, rel=5e-3)
    assert t[np.abs(h["car_body_y"]).argmax()] == pytest.approx(0.73, abs=0.005)


@pytest.mark.parametrize("case", [PAPER, lopsided()], ids=["paper", "lopsided"])
@pytest.mark.parametrize("convective", [False, True])
def test_balance_laws_and_printed_equations(case: dict, convective: bool) -> None:
    c = crossing(case, velocity=50.0, static_load="physical", convective=convective)
    system = CoupledSystem(c)
    # the lopsided train's axles do not enter on a millisecond, so take samples on which they do
    step = 1e-3 if case is PAPER else 0.5e-2 / 4
    t = np.arange(int(2.2 / step) + 1) * step
    h = channels_of(system, system.motion(t))
    energy = energy_balance(c, t, h)
    # DOP853's own error at rtol 1e-10 is 4e-9 of the largest response; energy is quadratic in it.
    assert np.abs(energy.error).max() < 2e-8 * energy.stored.max()
    assert energy.dissipated[-1] > 0.5 * energy.stored.max()
    for momentum, scale in (lateral_momentum(c, h), roll_momentum(c, h)):
        assert np.abs(momentum).max() < 1e-10 * scale
    forces, inertia = wheel_force_sum(c, h)
    # rounding only: both sides are formed from the same accelerations
    np.testing.assert_allclose(forces, inertia, rtol=1e-12)
    under = wheel_points(c, t, h)
    residuals = {**wheelset_torque(c, h, under), **bogie_and_body_forces(c, h, under)}
    residuals |= beam_residual(c, h, under, t)
    largest = max(float(np.abs(r).max()) for r in residuals.values())
    assert largest < 1e-12 * c.train.car_mass * c.gravity


@pytest.mark.parametrize("convective", [False, True])
def test_state_space_form_is_the_equations_of_motion(convective: bool) -> None:
    system = CoupledSystem(crossing(lopsided(), convective=convective))
    state = np.random.default_rng(3).normal(size=2 * system.size)
    for t in (0.0, 0.02, 0.25, 0.65, 0.8, 3.0):
        A, f = state_space(system, t)
        expected = system.acceleration(t, state[0::2], state[1::2], system.axles_on(t))
        np.testing.assert_allclose((A @ state + f)[1::2], expected, atol=1e-12 * np.abs(expected).max())
        np.testing.assert_array_equal((A @ state + f)[0::2], state[1::2])


def test_similar_system_has_the_scaled_response() -> None:
    t = np.linspace(0.0, 1.0, 51)
    h = crossing_channels(PAPER, t)
    # powers of two, so that the scaled case is exact and only DOP853's steps may differ
    s = crossing_channels(scaled(PAPER, length=4.0, mass=8.0, time=2.0), 2.0 * t)
    for name, factor in (("car_body_y", 4.0), ("front_bogie_roll", 1.0), ("wheel_2_left_force", 8.0)):
        assert np.abs(s[name] - factor * h[name]).max() < 2e-8 * np.abs(factor * h[name]).max()


def test_mirror() -> None:
    t = np.linspace(0.0, 1.0, 51)
    h, m = crossing_channels(lopsided(), t), crossing_channels(mirrored(lopsided()), t)
    for name in h:
        image, sign = mirror_sign(name)
        assert np.abs(m[image] - sign * h[name]).max() <= 2e-8 * np.abs(h[name]).max()


def test_three_motions_of_the_train_are_not_held() -> None:
    omega = vehicle_frequencies(crossing(lopsided()).train)
    # rounding: eigenvalues are good to 1e-16 of the largest, their roots to 1e-8
    assert (omega[:3] < 1e-6 * omega[-1]).all()
    assert omega[3] > 0.01 * omega[-1]
