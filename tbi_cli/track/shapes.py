"""Rails of which the level is known as a function of the place."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from tbi_cli.case import Dip, HalfSine, Harmonic, Profile, Ramp
from tbi_cli.track.profile import Array, RailProfile

_SIDES = {"both": (1.0, 1.0), "right": (1.0, 0.0), "left": (0.0, 1.0), "opposite": (1.0, -1.0)}


class Level(Protocol):
    """The level of the right and of the left rail all along the track, without corners."""

    def level(self, x: Array) -> Array:
        """Level (2, n) in m at places x (n,)."""

    def slope(self, x: Array) -> Array:
        """Slope (2, n) at places x (n,)."""


class Waves:
    """Sine waves."""

    def __init__(self, harmonic: Harmonic) -> None:
        self._at, self._turn = harmonic.at, 2 * np.pi / harmonic.wavelength
        self._amplitude = np.array(_SIDES[harmonic.rails])[:, None] * harmonic.amplitude

    def level(self, x: Array) -> Array:
        """Level (2, n) in m at places x (n,)."""
        found: Array = self._amplitude * np.sin(self._turn * (x - self._at))
        return found

    def slope(self, x: Array) -> Array:
        """Slope (2, n) at places x (n,)."""
        found: Array = self._amplitude * self._turn * np.cos(self._turn * (x - self._at))
        return found


class Shape:
    """A ramp, a dip, or a bump of half a sine, which stands between two corners."""

    def __init__(self, shape: Ramp | Dip | HalfSine) -> None:
        self._shape = shape
        self._sides: Array = np.array(_SIDES[shape.rails])[:, None]

    def level(self, x: Array) -> Array:
        """Level (2, n) in m at places x (n,)."""
        shape = self._shape
        part: Array = np.clip((x - shape.at) / shape.length, 0.0, 1.0)
        if isinstance(shape, Ramp):
            return self._sides * shape.height * part
        if isinstance(shape, Dip):
            hollow: Array = 1 - np.cos(2 * np.pi * part)
            return self._sides * (-shape.depth / 2) * hollow
        bump: Array = np.sin(np.pi * part)
        return self._sides * shape.height * bump

    def slope(self, x: Array, beside: Array) -> Array:
        """Slope (2, n) at places x (n,), on the side where `beside` (n,) is: at a corner it has two."""
        shape = self._shape
        on = (beside > shape.at) & (beside < shape.at + shape.length)
        part: Array = np.clip((x - shape.at) / shape.length, 0.0, 1.0)
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

        places, right, left = profile.points
        self.x: Array = np.array(places)
        self._spline = CubicSpline(self.x, np.array([right, left]), axis=1, bc_type="clamped")

    def level(self, x: Array) -> Array:
        """Level (2, n) in m at places x (n,)."""
        found: Array = self._spline(np.clip(x, self.x[0], self.x[-1]))
        return found

    def slope(self, x: Array) -> Array:
        """Slope (2, n) at places x (n,)."""
        found: Array = self._spline(np.clip(x, self.x[0], self.x[-1]), 1)
        return np.where((x > self.x[0]) & (x < self.x[-1]), found, 0.0)


class Chained:
    """Rails that are a chain of cubics without corners already."""

    def __init__(self, profile: RailProfile) -> None:
        self._profile = profile

    @property
    def x(self) -> Array:
        """Its points (m)."""
        return self._profile.x

    def level(self, x: Array) -> Array:
        """Level (2, n) in m at places x (n,)."""
        return self._profile.level(x)

    def slope(self, x: Array) -> Array:
        """Slope (2, n) at places x (n,)."""
        return self._profile.level(x, 1)
