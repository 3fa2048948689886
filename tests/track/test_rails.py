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

    A cubic that reaches over the end by at most its length h has a level of 10 (h/25 m)^3 of a few mm.
    """
    profile = rails(**{part: EVERYTHING[part]})
    beyond = X[(profile.first >= X) | (profile.end <= X)]
    ends = np.array([-100.0, SPAN + 100.0])
    for derivative, scale in enumerate((1.0, 25.0, 25.0**2)):
        assert np.max(np.abs(profile.level(beyond, derivative))) < 1e-15
        small = 60 * profile.spacing / 25.0 * 2e-2 / scale
        assert np.max(np.abs(profile.level(ends, derivative))) < small


def test_everything_is_added_up() -> None:
    """Where the points of the chains differ, cubics differ: by (k h)^4/384 of what is as short as 1.5 m."""
    shape = {"ramp": {"at": -50.0, "length": 20.0, "height": 1e-2}}
    together = rails(**EVERYTHING, **shape).level(X)
    apart = sum(rails(**{key: value}).level(X) for key, value in (EVERYTHING | shape).items())
    assert together == pytest.approx(apart, abs=2e-7)


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
    c, h = profile.cubics, profile.spacing
    ends = c.sum(axis=-1)
    assert ends[:, :-1] == pytest.approx(c[:, 1:, 0], abs=1e-16)
    slopes = (c[..., 1] + 2 * c[..., 2] + 3 * c[..., 3]) / h
    assert slopes[:, :-1] == pytest.approx(c[:, 1:, 1] / h, abs=1e-13)
    x = np.linspace(profile.first, profile.end, 400)
    step = 1e-6
    numeric = (profile.level(x + step) - profile.level(x - step)) / (2 * step)
    assert profile.level(x, 1)[:, 1:-1] == pytest.approx(numeric[:, 1:-1], abs=1e-7)


def test_a_chain_of_one_cubic() -> None:
    level, slope = np.array([[1.0, 3.0]] * 2), np.array([[0.5]] * 2)
    profile = chain(2.0, 4.0, level, slope, -slope)
    assert profile.end == 6.0
    assert profile.level(np.array([0.0, 2.0, 4.0, 6.0, 9.0]))[0].tolist() == [1.0, 1.0, 2.5, 3.0, 3.0]
    assert profile.level(np.array([0.0, 2.0, 9.0]), 1)[0].tolist() == [0.0, 0.5, 0.0]
