"""Rails of which the level is known as a function of the place.

Where such a function has corners its slope is asked for with a place beside the point in question, which
tells on which side of the corner it is meant.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

from tbi_cli.case import Dip, HalfSine, Harmonic, Profile, Ramp
from tbi_cli.track.profile import Array, RailProfile

_SIDES = {"both": (1.0, 1.0), "right": (1.0, 0.0), "left": (0.0, 1.0), "opposite": (1.0, -1.0)}


class Level(Protocol):
    """The level of the right and of the left rail."""

    def level(self, x: Array) -> Array:
        """Level (2, n) in m at places x (n,)."""

    def slope(self, x: Array, beside: Array) -> Array:
        """Slope (2, n) at places x (n,), on the side where `beside` (n,) is."""


class Shape:
    """A ramp, a dip, a bump of half a sine, or sine waves."""

    def __init__(self, shape: Ramp | Dip | HalfSine | Harmonic) -> None:
        self._shape = shape
        self._sides: Array = np.array(_SIDES[shape.rails])[:, None]

    def level(self, x: Array) -> Array:
        """Level (2, n) in m at places x (n,)."""
        shape = self._shape
        if isinstance(shape, Harmonic):
            wave: Array = np.sin(2 * np.pi * (x - shape.at) / shape.wavelength)
            return self._sides * shape.amplitude * wave
        part: Array = np.clip((x - shape.at) / shape.length, 0.0, 1.0)
        if isinstance(shape, Ramp):
            return self._sides * shape.height * part
        if isinstance(shape, Dip):
            hollow: Array = 1 - np.cos(2 * np.pi * part)
            return self._sides * (-shape.depth / 2) * hollow
        bump: Array = np.sin(np.pi * part)
        return self._sides * shape.height * bump

    def slope(self, x: Array, beside: Array) -> Array:
        """Slope (2, n) at places x (n,), on the side where `beside` (n,) is."""
        shape = self._shape
        if isinstance(shape, Harmonic):
            turn = 2 * np.pi / shape.wavelength
            rise: Array = np.cos(turn * (x - shape.at))
            return self._sides * shape.amplitude * turn * rise
        on = (beside > shape.at) & (beside < shape.at + shape.length)
        part = (x - shape.at) / shape.length
        if isinstance(shape, Ramp):
            slope = np.full_like(x, shape.height / shape.length)
        elif isinstance(shape, Dip):
            slope = -shape.depth * np.pi / shape.length * np.sin(2 * np.pi * part)
        else:
            slope = shape.height * np.pi / shape.length * np.cos(np.pi * part)
        return self._sides * np.where(on, slope, 0.0)


class Measured:
    """Rails as measured: a cubic spline through the points, level at its ends and beyond them."""

    def __init__(self, profile: Profile) -> None:
        from scipy.interpolate import CubicSpline

        self._first, self._last = profile.x[0], profile.x[-1]
        rails = [profile.right, profile.left or profile.right]
        self._spline = CubicSpline(np.array(profile.x), np.array(rails), axis=1, bc_type="clamped")

    def level(self, x: Array) -> Array:
        """Level (2, n) in m at places x (n,)."""
        found: Array = self._spline(np.clip(x, self._first, self._last))
        return found

    def slope(self, x: Array, beside: Array) -> Array:
        """Slope (2, n) at places x (n,), on the side where `beside` (n,) is."""
        found: Array = self._spline(np.clip(x, self._first, self._last), 1)
        return np.where((beside > self._first) & (beside < self._last), found, 0.0)


class Chained:
    """Rails that are a chain of cubics already."""

    def __init__(self, profile: RailProfile) -> None:
        self._profile = profile

    @property
    def spacing(self) -> float:
        """Distance of its points (m)."""
        return self._profile.spacing

    def level(self, x: Array) -> Array:
        """Level (2, n) in m at places x (n,)."""
        return self._profile.level(x)

    def slope(self, x: Array, beside: Array) -> Array:
        """Slope (2, n) at places x (n,), on the side where `beside` (n,) is."""
        return self._profile.level(x, 1)
