"""Rails of shapes, waves and measured points: what they are made of, and how they begin and end."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tbi_cli.case import Track
from tbi_cli.track import RailProfile, rail_profile
from tbi_cli.track.profile import chain
from tbi_cli.verify.references.rail_shapes import rails_of
from tests.track.unsymmetric import unsymmetric

SPAN = 30.0


def rails(approach: float = 100.0, **irregularity: Any) -> RailProfile:
    return rail_profile(Track.model_validate({"approach": approach, "irregularity": irregularity}), SPAN)


X = np.linspace(-130.0, 160.0, 20_001)
MEASURED = {"x": [-187.0, -137.0, -87.0, -37.0, 13.0, 63.0], "right": [2e-3, 1e-3, -1e-3, 0.0, 2e-3, 3e-3]}
EVERYTHING = {
    "harmonic": {"wavelength": 7.0, "amplitude": 2e-3, "at": 1.3},
    "random": {"spectrum": "fra-2", "coherence": "independent"},
    "profile": MEASURED | {"left": [0.0, 0.0, 1e-3, 0.0, 0.0, 5e-3]},
}


def test_a_ramp_rises_and_stays() -> None:
    """Exactly, corners and all, wherever it begins."""
    profile = rails(ramp={"at": -20.3, "length": 7.7, "height": 5e-3})
    expected = 5e-3 * np.clip((X + 20.3) / 7.7, 0, 1)
    assert profile.level(X) == pytest.approx(np.array([expected, expected]), abs=1e-17)
    slope = np.where((X > -20.3) & (X < -12.6), 5e-3 / 7.7, 0.0)
    assert profile.level(X, 1)[0] == pytest.approx(slope, abs=1e-13)
    assert not profile.level(np.array([-99.0, -20.3])).any()
    assert profile.level(np.array([1e6]))[:, 0] == pytest.approx([5e-3, 5e-3], rel=1e-15)


@pytest.mark.parametrize(("rails_", "left"), [("both", 1), ("right", 0), ("opposite", -1)])
def test_a_dip_is_a_wave_of_the_cosine(rails_: str, left: int) -> None:
    """Cubics with the right levels and slopes, 64 in a wave: (2 pi/64)^4/384 = 2.4e-7 of half the depth."""
    right, other = rails(dip={"at": 3.0, "length": 8.0, "depth": 4e-3, "rails": rails_}).level(X)
    inside = (X > 3) & (X < 11)
    expected = np.where(inside, -2e-3 * (1 - np.cos(2 * np.pi * (X - 3) / 8)), 0.0)
    assert np.max(np.abs(right - expected)) < 2.5e-7 * 2e-3
    assert other == pytest.approx(left * right, abs=1e-20)


def test_a_bump_of_half_a_sine() -> None:
    """64 cubics in half a wave: a sixteenth of the dip's error."""
    profile = rails(half_sine={"at": -1.0, "length": 2.5, "height": 3e-3, "rails": "left"})
    right, left = profile.level(X)
    inside = (X > -1) & (X < 1.5)
    assert not right.any()
    expected = np.where(inside, 3e-3 * np.sin(np.pi * (X + 1) / 2.5), 0.0)
    assert np.max(np.abs(left - expected)) < 2e-8 * 3e-3


def test_waves_are_whole_between_the_tapers() -> None:
    profile = rails(harmonic={"wavelength": 9.0, "amplitude": 1e-3, "at": 2.0})
    between = X[(X > -75) & (X < SPAN + 75)]
    expected = 1e-3 * np.sin(2 * np.pi * (between - 2) / 9)
    assert np.max(np.abs(profile.level(between)[0] - expected)) < 2.5e-7 * 1e-3


def test_measured_rails_pass_through_their_points() -> None:
    """Between the tapers; beyond the last point the rail keeps its level."""
    profile = rails(profile=MEASURED)
    for x, level in zip(MEASURED["x"], MEASURED["right"], strict=True):
        if -75 < x < SPAN + 75:
            assert profile.level(np.array([x]))[:, 0] == pytest.approx([level, level], abs=1e-15)
    assert profile.level(np.array([95.0, 104.0]))[0] == pytest.approx([3e-3, 3e-3], abs=1e-15)


def test_points_of_a_cubic_give_the_cubic() -> None:
    """Where no end is near: the spline forgets that it is level there by a factor of 3.7 each point."""
    x = np.arange(-400.0, 401.0, 5.0)
    cubic = np.polynomial.Polynomial([1e-3, 2e-5, -3e-7, 1e-9])
    profile = rails(profile={"x": x.tolist(), "right": cubic(x).tolist()})
    between = X[(X > -75) & (X < SPAN + 75)]
    assert profile.level(between)[0] == pytest.approx(cubic(between), abs=1e-15)
    assert profile.level(between, 2)[0] == pytest.approx(cubic.deriv(2)(between), abs=1e-12)


@pytest.mark.parametrize("part", sorted(EVERYTHING))
def test_what_goes_on_everywhere_begins_and_ends_level(part: str) -> None:
    """Level, slope and curvature are zero at both ends of the track but for rounding, and beyond.

    A cubic of random rails that reaches over the end by its length h: 10 (h/25 m)^3 of a few mm.
    """
    profile = rails(**{part: EVERYTHING[part]})
    beyond = X[(profile.x[0] >= X) | (profile.x[-1] <= X)]
    ends = np.array([-100.0, SPAN + 100.0])
    for derivative, scale in enumerate((1.0, 25.0, 25.0**2)):
        assert np.max(np.abs(profile.level(beyond, derivative))) < 1e-15
        small = 60 * np.diff(profile.x)[[0, -1]].max() / 25.0 * 2e-2 / scale
        assert np.max(np.abs(profile.level(ends, derivative))) < small


def test_everything_is_added_up() -> None:
    """Only points of random rails next to others are left out: (k h)^4/384 of what is as short as 1.5 m."""
    shapes = {
        "ramp": {"at": -50.03, "length": 20.1, "height": 1e-2},
        "dip": {"at": 3.3, "length": 2.2, "depth": 1e-3},
    }
    together = rails(**EVERYTHING, **shapes).level(X)
    apart = sum(rails(**{key: value}).level(X) for key, value in (EVERYTHING | shapes).items())
    assert together == pytest.approx(apart, abs=2e-8)


@pytest.mark.parametrize("seed", range(8))
def test_rails_of_many_parts_are_those_of_their_formulas(seed: int) -> None:
    """Several shapes, waves and uneven measured points at once, on each rail others; corners on both sides.

    Cubics of a wave of 1/64 h of its length: (2 pi/64)^4/384 = 2.4e-7 of its amplitude, slopes to its cube
    over 216 = 4.4e-6 of the largest.  Ramps and measured points, which are cubics, to rounding.
    """
    irregularity = unsymmetric(seed)
    profile, (right, left) = rails(60.0, **irregularity), rails_of(irregularity, 60.0, SPAN)
    corners = np.array(sorted({*right.corners, *left.corners}))
    corners = corners[(corners > -60) & (corners < SPAN + 60)]
    x = np.concatenate([X, corners - 1e-7, corners, corners + 1e-7])
    found, slope = profile.level(x), profile.level(x, 1)
    cubics = {"ramp": irregularity["ramp"], "profile": irregularity["profile"]}
    between = np.abs(x - SPAN / 2) < 0.75 * 60 + SPAN / 2
    exact = rails(60.0, **cubics).level(x)
    for k, (rail, cubic) in enumerate(zip((right, left), rails_of(cubics, 60.0, SPAN), strict=True)):
        largest = sum(
            part.get(key, 0.0) for part in irregularity.values() for key in ("depth", "height", "amplitude")
        )
        assert np.max(np.abs(found[k] - rail.level(x))) < 2.5e-7 * max(largest, 1e-3)
        assert exact[k][between] == pytest.approx(cubic.level(x[between]), abs=1e-17)
        assert np.max(np.abs(slope[k] - rail.slope(x + 1e-9))) < 1e-5 * np.max(np.abs(rail.slope(X)))


@pytest.mark.parametrize("seed", range(4))
def test_a_dip_of_next_to_nothing_changes_next_to_nothing(seed: int) -> None:
    """Wherever it stands among the other parts: 1 nm of level, and no corner of another."""
    others = unsymmetric(seed) | {"random": {"spectrum": "fra-4", "coherence": "independent"}}
    others.pop("dip")
    at = float(np.random.default_rng(seed).uniform(-50, 50))
    before, after = rails(60.0, **others), rails(60.0, **others, dip={"at": at, "length": 3.0, "depth": 1e-9})
    assert set(before.x[before.corners]) <= set(after.x[after.corners])
    # And (k h)^4/384 of random rails of 1 mm where a point was left out, as above.
    assert np.max(np.abs(after.level(X) - before.level(X))) < 1e-9 + 2e-8
    assert np.max(np.abs(after.level(X, 1) - before.level(X, 1))) < 1.1e-9 + 3e-6


def test_measured_points_in_falling_order_and_from_another_origin() -> None:
    """The same rails as rising ones that begin at the bridge."""
    x = np.array([-40.0, -31.0, -17.5, -2.0, 9.3, 22.0, 48.0])
    levels = np.random.default_rng(3).normal(0, 1e-3, (2, 7))
    plain = {"x": x.tolist(), "right": levels[0].tolist(), "left": levels[1].tolist()}
    turned = {key: values[::-1] for key, values in plain.items()}
    moved = turned | {"x": (x[::-1] + 123_456.0).tolist(), "start": 123_456.0}
    expected = rails(profile=plain).level(X)
    assert np.array_equal(rails(profile=turned).level(X), expected)
    # Places of 1e5 m are rounded to 1e-11 m, slopes are 1e-3.
    assert rails(profile=moved).level(X) == pytest.approx(expected, abs=1e-13)


@settings(max_examples=25, deadline=None)
@given(
    st.sampled_from(sorted(EVERYTHING)).map(lambda key: {key: EVERYTHING[key]})
    | st.fixed_dictionaries(
        {
            "dip": st.fixed_dictionaries(
                {"at": st.integers(-90, 20), "length": st.floats(0.5, 40), "depth": st.floats(1e-4, 0.01)}
            )
        }
    )
)
def test_level_and_slope_are_continuous(irregularity: dict[str, Any]) -> None:
    """The cubics of neighbouring intervals meet with the same level and the same slope."""
    profile = rails(**irregularity)
    c, h = profile.cubics, np.diff(profile.x)
    assert not profile.corners.any()
    ends = c.sum(axis=-1)
    assert ends[:, :-1] == pytest.approx(c[:, 1:, 0], abs=1e-16)
    slopes = (c[..., 1] + 2 * c[..., 2] + 3 * c[..., 3]) / h
    assert slopes[:, :-1] == pytest.approx(c[:, 1:, 1] / h[1:], abs=1e-13)
    x = np.linspace(profile.x[0], profile.x[-1], 400)
    step = 1e-6
    numeric = (profile.level(x + step) - profile.level(x - step)) / (2 * step)
    assert profile.level(x, 1)[:, 1:-1] == pytest.approx(numeric[:, 1:-1], abs=1e-7)


def test_a_chain_of_one_cubic() -> None:
    level, slope = np.array([[1.0, 3.0]] * 2), np.array([[0.5]] * 2)
    profile = chain(np.array([2.0, 6.0]), level, slope, -slope)
    assert profile.corners.tolist() == [True, True]
    assert profile.level(np.array([0.0, 2.0, 4.0, 6.0, 9.0]))[0].tolist() == [1.0, 1.0, 2.5, 3.0, 3.0]
    assert profile.level(np.array([0.0, 2.0, 9.0]), 1)[0].tolist() == [0.0, 0.5, 0.0]
