"""The references of trains, forces and stations, against others and against what no formula can fake."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from tbi_cli.verify.references.consist import ConsistSystem, coach_fronts, consist_channels
from tbi_cli.verify.references.crossing import crossing_channels
from tbi_cli.verify.references.hslm import hslm_a
from tbi_cli.verify.references.mixed_row import mixed_row_crossing
from tbi_cli.verify.references.moving_force import deflection, forced, free_vibration, modal_coordinates
from tbi_cli.verify.references.parameters import Array, Beam, beam_from_mapping
from tbi_cli.verify.references.piecewise import integrate_between_events
from tbi_cli.verify.references.simple_vehicles import (
    RigidBeam,
    SprungMass,
    rigid_beam_crossing,
    sprung_mass_crossing,
)
from tbi_cli.verify.references.stations import (
    counted_by_en_1990,
    low_passed,
    moment_and_shear,
    moment_line,
    shear_line,
)
from tests.verify.test_references_crossing import PAPER, lopsided

BEAM = {"youngs_modulus": 30e9, "second_moment": 0.3, "mass_per_length": 10e3, "damping": {"ratio": 0.02}}


def beam(n: int, length: float = 20.0) -> Beam:
    return beam_from_mapping(BEAM, length, n)


def train_of(*cars: dict, **changes: object) -> dict:
    """The paper's case with a train of some cars, 25 m each."""
    consist = [{"vehicle": car, "count": 1, "spacing": 25.0} for car in cars]
    return {**PAPER, "contact": {}, "velocity": 50.0, "train": {"consist": consist}, **changes}


def test_a_train_of_one_car_is_the_car() -> None:
    """The same equations and steps: rounding alone is left."""
    t = np.linspace(0.0, 1.2, 25)
    train = consist_channels(train_of(lopsided()["train"]), t)
    car = crossing_channels({**lopsided(), "velocity": 50.0}, t)
    assert len(train) == len(car)
    for name, values in car.items():
        own = train[name if name in train else f"coach_1_{name}"]
        assert np.abs(own - values).max() <= 1e-9 * np.abs(values).max(), name


def test_a_far_coach_on_a_bridge_at_rest_crosses_alone() -> None:
    """With the first car long gone, and the damping so high that nothing of it is left, both do the same."""
    damped = {side: {**PAPER["bridge"][side], "damping": {"ratio": 0.5}} for side in ("right", "left")}
    case = train_of(PAPER["train"], PAPER["train"], bridge={**PAPER["bridge"], **damped})
    case["train"]["consist"][1]["spacing"] = 825.0
    fronts = ConsistSystem(case).fronts
    assert fronts == [0.0, 25.0 + 402.5 - 2.5]
    t = np.linspace(0.0, 1.0, 21)
    h = consist_channels(case, np.concatenate([t, t[1:] + fronts[1] / 50.0 - t[0]]))
    for name in ("car_body_y", "wheelset_2_roll", "rear_bogie_pitch_acceleration", "wheel_3_left_force"):
        first, second = h[f"coach_1_{name}"][: len(t)], h[f"coach_2_{name}"][len(t) :]
        # exp(-0.5 * 5.7 rad/s * 7 s) = 2e-9 is left of the first mode; DOP853 adds up to some 1e-8.
        assert np.abs(second - first[1:]).max() < 1e-6 * np.abs(first).max(), name


def test_couplers_meet() -> None:
    """Half of 30 m less 20 m stands out behind the first, half of 25 m less 20 m before the second."""
    assert coach_fronts(
        [
            {"spacing": 30},
            {"spacing": 25},
            {"front_overhang": 1, "spacing": 25},
            {"rear_overhang": 3, "spacing": 25},
        ],
        [20.0, 20.0, 15.0, 15.0],
    ) == [0.0, 27.5, 51.0, 82.0]


def test_a_row_of_one_vehicle_is_that_vehicle() -> None:
    t = np.linspace(0.0, 1.0, 41)
    mass, body = SprungMass(8e3, 2e6, 2e4), RigidBeam(30e3, 0.8e6, 12.0, 4e6, 1e5)
    row = mixed_row_crossing(beam(4), [mass], [0.0], 30.0, t)
    alone = sprung_mass_crossing(beam(4), mass, 30.0, t)
    assert np.abs(row["coach_1_sprung_mass_y"] - alone["sprung_mass_y"]).max() < 1e-9 * 1e-2
    row, alone = (
        mixed_row_crossing(beam(4), [body], [0.0], 30.0, t),
        rigid_beam_crossing(beam(4), body, 30.0, t),
    )
    for name in ("beam_y", "beam_pitch"):
        size = np.abs(alone[name]).max()
        assert np.abs(row[f"coach_1_{name}"] - alone[name]).max() < 1e-8 * size
    forces = mixed_row_crossing(beam(4), [1e5, 8e4], [0.0, 7.0], 30.0, t)["right_midspan"]
    closed = deflection(beam(4), [1e5, 8e4], [0.0, 7.0], 30.0, t)
    assert np.abs(forces - closed).max() < 1e-8 * np.abs(closed).max()


@pytest.mark.parametrize("number", range(1, 11))
def test_hslm_a(number: int) -> None:
    """2 N + 14 axles, 37.525 m + (N + 2) D less nothing from first to last, the same from either end."""
    coaches, length, spacing, force = {
        1: (18, 18, 2.0, 170),
        2: (17, 19, 3.5, 200),
        3: (16, 20, 2.0, 180),
        4: (15, 21, 3.0, 190),
        5: (14, 22, 2.0, 170),
        6: (13, 23, 2.0, 180),
        7: (13, 24, 2.0, 190),
        8: (12, 25, 2.5, 190),
        9: (11, 26, 2.0, 210),
        10: (11, 27, 2.0, 210),
    }[number]
    positions, newtons = hslm_a(number)
    assert newtons == 1e3 * force
    assert len(positions) == 2 * coaches + 14
    assert positions[-1] == pytest.approx(37.525 + (coaches + 2) * length)
    assert np.allclose(positions, positions[-1] - np.array(positions[::-1]))
    gaps = np.diff(positions)
    # Shared bogies: spacing d inside, D - d between neighbours.
    middle = gaps[6:-6]
    assert np.allclose(middle[::2], spacing)
    assert np.allclose(middle[1::2], length - spacing)


@pytest.mark.parametrize("zeta", [0.3, 0.999, 1.001, 1.5, 6.0])
def test_oscillators_of_any_damping(zeta: float) -> None:
    """DOP853 to 1e-11; a damping ratio of one parts two formulas, and both are good on its sides."""
    omega, Omega = 20.0, 13.0
    t = np.linspace(0.0, 2.0, 81)

    def rate_between(start: float, stop: float) -> Callable[[float, Array], Array]:
        return lambda t, y: np.array([y[1], np.sin(Omega * t) - 2 * zeta * omega * y[1] - omega**2 * y[0]])

    x, x_t = integrate_between_events(rate_between, 2, [], t, 1e-11, 1e-16)
    ours, ours_t = forced(t, omega, zeta, Omega)
    # Near one the two exponentials are nearly equal: rounding over 2 sqrt(|zeta^2 - 1|).
    assert np.abs(ours - x).max() < 1e-8 * np.abs(x).max()
    assert np.abs(ours_t - x_t).max() < 1e-8 * np.abs(x_t).max()
    x0, v0 = free_vibration(np.zeros(1), omega, zeta, 0.3, -2.0)
    assert (float(x0[0]), float(v0[0])) == pytest.approx((0.3, -2.0))


def test_influence_lines_are_equilibrium() -> None:
    """Reactions add up to one, the moment is the integral of the shear force, its peak x (L - x)/L."""
    length, xi = 20.0, np.linspace(0.1, 19.9, 199)
    reactions = shear_line(length, 0.0, xi) - shear_line(length, length, xi)
    assert np.allclose(reactions, 1.0)
    for x in (4.0, 10.0, 17.0):
        assert moment_line(length, x, np.array([x]))[0] == pytest.approx(x * (length - x) / length)
        places = np.linspace(0.0, x, 20001)
        shear = np.array([shear_line(length, p, xi) for p in (places[1:] + places[:-1]) / 2])
        # A jump inside an interval of 1 mm or less.
        assert np.abs(shear.sum(axis=0) * (x / 20000) - moment_line(length, x, xi)).max() < 2e-3


def test_moments_converge_to_those_of_many_modes() -> None:
    """With the influence lines the error falls with n^-2 or faster, where the bare sum falls with 1/n."""
    t, force, v, x = np.linspace(0.0, 0.6, 601), 1e5, 50.0, 13.7
    xi = v * t[None, :]

    def both(n: int) -> tuple[Array, Array]:
        q = modal_coordinates(beam(n), force, v, t)[0]
        b = beam(n)
        bare = -b.EI * np.sqrt(2 / b.length) * (b.wave_numbers**2 * np.sin(b.wave_numbers * x)) @ q
        return moment_and_shear(b, x, q, np.full_like(xi, force), xi)[0], bare

    exact = both(300)[0]
    counts = np.array([4, 8, 16, 32])
    corrected, bare = np.array([[np.abs(m - exact).max() for m in both(int(n))] for n in counts]).T
    assert -np.polyfit(np.log(counts), np.log(corrected), 1)[0] > 2
    assert -np.polyfit(np.log(counts), np.log(bare), 1)[0] < 1.3
    assert corrected[-1] < 1e-2 * bare[-1]


def test_what_en_1990_counts() -> None:
    """f3 = 9 f1 for a beam, so that 1.5 f1 never decides; 30 Hz where f1 is below 10/3 Hz."""
    for length in (10.0, 20.0, 25.0, 50.0):
        f1 = np.pi / (2 * length**2) * np.sqrt(30e9 * 0.3 / 10e3)
        assert counted_by_en_1990(beam(3, length)) == pytest.approx(max(30.0, 9 * f1))


def test_the_filter_at_its_cut_off() -> None:
    """1/sqrt(2) of a sine at the cut-off passes, all of a slow one, and (f/fc)^-4, warped, of a fast one."""
    t = np.arange(8000) * 1e-3
    fast = (np.tan(0.03 * np.pi) / np.tan(0.09 * np.pi)) ** 4
    for frequency, share in ((2.0, 1.0), (30.0, 2**-0.5), (90.0, fast)):
        passed = low_passed(np.sin(2 * np.pi * frequency * t), 30.0, 1e-3)[4000:]
        assert np.sqrt(2 * np.mean(passed**2)) == pytest.approx(share, rel=1e-2)
