"""Closed forms against each other, against DOP853 and against numbers from elsewhere."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tbi_cli.verify.references.frequencies import (
    TABLE_2_MODE_4,
    TABLE_5,
    body_bounce,
    body_pitch,
    body_roll,
    critical_velocities,
    frequencies,
    vehicle_frequencies,
)
from tbi_cli.verify.references.influence import influence_line, modal_influence_line
from tbi_cli.verify.references.moving_force import (
    cancellation_speed,
    critical_speed,
    deflection,
    equal_forces_deflection,
    modal_coordinates,
    resonant_speed,
    spacing_cancellation_speed,
)
from tbi_cli.verify.references.parameters import Beam, beam_from_mapping, train_from_mapping
from tbi_cli.verify.references.piecewise import integrate_between_events
from tbi_cli.verify.references.simple_vehicles import (
    RigidBeam,
    SprungMass,
    rigid_beam_crossing,
    sprung_mass_crossing,
)
from tests.verify.test_references_crossing import PAPER

V = 27.78


def beam(length: float, E: float, I: float, mu: float, n: int, ratio: float = 0.0) -> Beam:  # noqa: E741
    given = {"youngs_modulus": E, "second_moment": I, "mass_per_length": mu, "damping": {"ratio": ratio}}
    return beam_from_mapping(given, length, n)


@pytest.mark.parametrize("ratio", [0.0, 0.03])
@pytest.mark.parametrize("speed", [0.1, 0.25, 0.5, 0.617, 1.0, 1.7])
def test_closed_form_solves_the_modal_equation(speed: float, ratio: float) -> None:
    b = beam(20.0, 30e9, 0.3, 10e3, 3, ratio)
    v = speed * critical_speed(b)
    t = np.linspace(0.0, 3 * b.length / v, 101)
    q, q_t = modal_coordinates(b, 1e5, v, t)

    def rate_between(start: float, stop: float):  # type: ignore[no-untyped-def]
        on = 0.5 * (start + stop) < b.length / v

        def rate(t: float, y: np.ndarray) -> np.ndarray:
            phi = math.sqrt(2 / b.length) * np.sin(b.wave_numbers * v * t) * on
            return np.concatenate([y[3:], (-1e5 * phi - b.c * y[3:]) / b.mu - b.omega**2 * y[:3]])

        return rate

    y = integrate_between_events(rate_between, 6, [b.length / v], t)
    # DOP853 to 1e-10 per step over a few hundred steps
    np.testing.assert_allclose(np.vstack([q, q_t]), y, atol=1e-8 * np.abs(y[:3]).max() * b.omega[-1])
    np.testing.assert_allclose(q, y[:3], atol=1e-8 * np.abs(y[:3]).max())


def test_largest_one_mode_deflection() -> None:
    b = beam(20.0, 1e9, 1.0, 1e3, 1)
    unit = 48 * b.EI / b.length**3
    speeds = np.linspace(0.6, 0.63, 301)
    peaks = []
    for s in speeds:
        v = s * critical_speed(b)
        peaks.append(np.abs(deflection(b, [unit], [0.0], v, np.linspace(0, b.length / v, 2001))).max())
    assert max(peaks) == pytest.approx(1.743, abs=5e-4)
    assert max(peaks) * math.pi**4 / 96 == pytest.approx(1.768, abs=5e-4)
    assert speeds[int(np.argmax(peaks))] == pytest.approx(0.617, abs=5e-4)


@pytest.mark.parametrize("i", [1, 2, 3])
def test_every_mode_is_still_after_the_exit(i: int) -> None:
    b = beam(20.0, 1e9, 1.0, 1e3, 5)
    v = cancellation_speed(b, i)
    q, _ = modal_coordinates(b, 1e4, v, np.linspace(0.0, 2 * b.length / v, 400))
    assert np.abs(q[:, 200:]).max() < 1e-12 * np.abs(q).max()


@pytest.mark.parametrize("ratio", [0.0, 0.02])
@pytest.mark.parametrize("i", [1, 2, 5])
def test_geometric_series_is_the_sum_of_the_forces(i: int, ratio: float) -> None:
    b = beam(20.0, 1e9, 1.0, 1e3, 3, ratio)
    v = resonant_speed(b, 30.0, i)
    t = np.linspace(0.0, 2 * 320.0 / v, 2001)
    series = equal_forces_deflection(b, 1e4, 30.0, 10, v, t)
    summed = deflection(b, [1e4] * 10, list(30.0 * np.arange(10)), v, t)
    # rounding: both sum the same ten closed forms
    np.testing.assert_allclose(series, summed, atol=1e-11 * np.abs(summed).max())


def test_spacing_cancels_the_first_mode() -> None:
    b = beam(20.0, 1e9, 1.0, 1e3, 1)
    v = spacing_cancellation_speed(b, 30.0, 4, 5)
    t = np.linspace(0.0, 300.0 / v, 2001)
    w = deflection(b, [1e4] * 4, list(30.0 * np.arange(4)), v, t)
    assert np.abs(w[t > 110.5 / v]).max() < 1e-11 * np.abs(w).max()


@pytest.mark.parametrize(("modes", "coupled", "force"), [(1, 2.3840, 2.3766), (4, 2.4080, 2.3966)])
def test_sprung_mass_numbers(modes: int, coupled: float, force: float) -> None:
    b = beam(25.0, 2.87e9, 2.9, 2303.0, modes)
    t = np.linspace(0.3, 0.45, 1501)
    w = sprung_mass_crossing(b, SprungMass(5750.0, 1595e3), V, t)["right_midspan"]
    # the numbers are given to five digits
    assert np.abs(w).max() * 1e3 == pytest.approx(coupled, abs=5.1e-5)
    if modes == 4:
        assert t[np.abs(w).argmax()] == pytest.approx(0.3705, abs=5.1e-5)
    assert np.abs(deflection(b, [5750 * 9.81], [0.0], V, t)).max() * 1e3 == pytest.approx(force, abs=5.1e-5)


@pytest.mark.parametrize(
    ("E", "modes", "coupled", "force"),
    [
        (2.943e9, 1, 82.63, 91.79),
        (2.943e9, 4, 84.29, 92.36),
        (29.43e9, 1, 7.911, 8.137),
        (29.43e9, 4, 7.888, 8.020),
    ],
)
def test_rigid_beam_numbers(E: float, modes: int, coupled: float, force: float) -> None:
    b = beam(30.0, E, 8.65, 36e3, modes)
    t = np.arange(0.0, 47.5 / V, 1e-3)
    w = rigid_beam_crossing(b, RigidBeam(540e3, 13.8e6, 17.5, 41.35e6), V, t)["right_midspan"]
    # four digits are given, and a sample may miss a peak by half a millisecond: w'' dt^2 / 8 < 1e-4 w
    assert np.abs(w).max() * 1e3 == pytest.approx(coupled, rel=1.5e-4)
    moving = deflection(b, [270e3 * 9.81] * 2, [0.0, 17.5], V, t)
    assert np.abs(moving).max() * 1e3 == pytest.approx(force, rel=1.5e-4)


@pytest.mark.parametrize("vehicle", ["sprung-mass", "rigid-beam"])
def test_soft_springs_carry_constant_forces(vehicle: str) -> None:
    # As the spring-damper goes to zero the load becomes constant; the difference is first order in it.
    b = beam(25.0, 2.87e9, 2.9, 2303.0, 2, 0.01)
    t = np.linspace(0.0, 3.0, 301)
    differences = []
    for k in (1e3, 1e2):
        if vehicle == "sprung-mass":
            w = sprung_mass_crossing(b, SprungMass(5750.0, k, k / 100), V, t)["right_midspan"]
            force = deflection(b, [5750 * 9.81], [0.0], V, t)
        else:
            w = rigid_beam_crossing(b, RigidBeam(5750.0, 2e4, 7.0, k, k / 100), V, t)["right_midspan"]
            force = deflection(b, [5750 * 9.81 / 2] * 2, [0.0, 7.0], V, t)
        differences.append(np.abs(w - force).max())
    assert differences[0] < 0.01 * np.abs(force).max()
    assert differences[0] / differences[1] == pytest.approx(10, rel=0.02)


def test_influence_lines_agree_as_the_modes_do() -> None:
    b = beam(30.0, 30e9, 1.0, 1e4, 20)
    x = np.linspace(-1.0, 31.0, 641)
    exact, modal = influence_line(b, x), modal_influence_line(b, x)
    # what modes 21, 23, ... would add: 2/pi^4 sum i^-4 of the peak L^3/48EI times 48
    tail = 1 - 96 / math.pi**4 * sum(i**-4 for i in range(1, 20, 2))
    assert np.abs(exact - modal).max() == pytest.approx(tail * exact.max(), rel=1e-6)
    assert exact.max() == pytest.approx(b.length**3 / (48 * b.EI), rel=1e-12)


def test_tables_2_and_5() -> None:
    bridge = PAPER["bridge"]
    for side, (f4, v4) in TABLE_2_MODE_4.items():
        b = beam_from_mapping(bridge[side], 50.0, 4)
        assert frequencies(b)[3] == pytest.approx(f4, abs=6e-4)
        assert critical_velocities(b, 20.0)[3] == pytest.approx(v4, abs=6e-3)
    for length, values in TABLE_5.items():
        b = beam_from_mapping(bridge["left"], length, 4)
        # the paper cut its frequencies off after four decimals: so computed, every digit agrees
        cut = np.floor(frequencies(b) * 1e4) / 1e4
        np.testing.assert_allclose(np.round(20.0 * cut, 2), values, rtol=1e-12)
        np.testing.assert_allclose(critical_velocities(b, 20.0), values, atol=7e-3)


def test_body_on_stiff_bogies() -> None:
    errors: dict[str, list[float]] = {"bounce": [], "pitch": [], "roll": []}
    for stiffness in (1e8, 1e9, 1e10):
        train = {**PAPER["train"], "geometry": {**PAPER["train"]["geometry"]}}
        for height in ("car_body_to_secondary", "secondary_to_bogie", "bogie_to_axle"):
            train["geometry"][height] = 0.0
        train["primary"] = {**train["primary"], "vertical": {"stiffness": stiffness}}
        t = train_from_mapping(train)
        omega = vehicle_frequencies(t)
        for name, value in (("bounce", body_bounce(t)), ("pitch", body_pitch(t)), ("roll", body_roll(t))):
            errors[name].append(float(np.min(np.abs(omega / value - 1))))
    for values in errors.values():
        slope = np.polyfit([8, 9, 10], np.log10(values), 1)[0]
        assert slope == pytest.approx(-1.0, abs=0.02)
