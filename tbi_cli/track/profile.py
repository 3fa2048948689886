"""The level of the two rails along the track, as a chain of cubics."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class RailProfile:
    """Vertical profile of the right and of the left rail, positive upward.

    first: where the first interval begins (m, the bridge begins at 0); spacing: length of an interval (m);
    cubics (2, intervals, 4): level (m) in powers of the fraction of the interval that is behind.  Beyond its
    ends each rail keeps the level that it has there.
    """

    first: float
    spacing: float
    cubics: Array

    @property
    def end(self) -> float:
        """Where the last interval ends (m)."""
        return self.first + self.spacing * float(self.cubics.shape[1])

    def level(self, x: Array, derivative: int = 0) -> Array:
        """Level (2, n) of the right and of the left rail at places x (n,), or its derivative by x."""
        place = (np.asarray(x, dtype=float) - self.first) / self.spacing
        inside = (place >= 0) & (place < self.cubics.shape[1])
        i = np.clip(np.floor(place), 0, self.cubics.shape[1] - 1).astype(int)
        f = np.clip(place - i, 0.0, 1.0)
        powers = [f**k for k in range(4)]
        for _ in range(derivative):
            powers = [np.zeros_like(f), *(k * powers[k - 1] for k in range(1, 4))]
        value: Array = np.einsum("skc,ck->sk", self.cubics[:, i], np.array(powers))
        return value if derivative == 0 else value * inside / self.spacing**derivative


def chain(first: float, spacing: float, level: Array, slope_after: Array, slope_before: Array) -> RailProfile:
    """The profile with given levels and slopes at points at equal distances, and corners where these differ.

    level (2, n + 1) at the points (m); slope_after (2, n) at the beginning of each interval and slope_before
    (2, n) at its end (m/m).
    """
    rise = level[:, 1:] - level[:, :-1]
    here, there = slope_after * spacing, slope_before * spacing
    cubics = np.stack([level[:, :-1], here, 3 * rise - 2 * here - there, here + there - 2 * rise], axis=-1)
    return RailProfile(first, spacing, np.ascontiguousarray(cubics))
