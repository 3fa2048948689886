"""Random rails where one block fades into the next, 512 to 1024 m from its middle."""

from __future__ import annotations

from typing import Any

import numpy as np

from tbi_cli.case import Track
from tbi_cli.track import RailProfile, rail_profile

APPROACH, SPAN = 1200.0, 50.0


def rails(seed: int, **random: Any) -> RailProfile:
    """The profile of random rails, level only far beyond the first fading."""
    given = {"spectrum": "german-low", "seed": seed} | random
    return rail_profile(Track.model_validate({"approach": APPROACH, "irregularity": {"random": given}}), SPAN)


def test_the_variance_is_the_same_everywhere() -> None:
    """Waves of 20 m at most: 120 m of 40 seeds hold some 480 values that know nothing of each other.

    So a variance is good to sqrt(2/480) = 6.5 %, a ratio of two to 9 %, three times of which is let pass.
    Weights that add up to one would leave 56 % there.
    """
    middle, faded = np.arange(-60.0, 60.0, 0.5), np.arange(708.0, 828.0, 0.5)
    squares = []
    for seed in range(40):
        profile = rails(seed, longest_wavelength=20.0)
        squares.append([np.mean(profile.level(x)[0] ** 2) for x in (middle, faded, -faded)])
    one, right, left = np.mean(squares, axis=0)
    assert abs(right / one - 1) < 0.27
    assert abs(left / one - 1) < 0.27


def test_the_slope_is_the_derivative_of_the_level() -> None:
    """At the points of the rails, by differences of fourth order.

    Of waves of 3 m they are off by (k h)^4/30 with h = 3 m/24 at most, 1.6e-4 of the slope; growing weights
    add more than 1e-2 of it.
    """
    profile = rails(3, longest_wavelength=150.0)
    x = profile.x[(np.abs(np.abs(profile.x) - 768) < 200)]
    x = x[x > 0]
    h = float(x[1] - x[0])
    assert h <= 3 / 24
    level = [profile.level(x + k * h)[0] for k in (-2, -1, 1, 2)]
    differences = (level[0] - 8 * level[1] + 8 * level[2] - level[3]) / (12 * h)
    slope = profile.level(x, 1)[0]
    assert np.max(np.abs(slope - differences)) < 1e-3 * np.max(np.abs(slope))
