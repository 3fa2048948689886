"""The level of the two rails along the track, as a chain of cubics."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
# Of the steepest slope: a jump that is no corner.
_ROUNDING = 1e-12


@dataclass(frozen=True, eq=False)
class RailProfile:
    """Vertical profile of the right and of the left rail, positive upward.

    x (intervals + 1,): where the intervals begin and end (m, the bridge begins at 0), rising; cubics (2,
    intervals, 4): level (m) in powers of the fraction of the interval that is behind; corners (intervals +
    1,): whether a rail has a corner at each x.  Beyond its ends each rail keeps the level that it has there.
    """

    x: Array
    cubics: Array
    corners: NDArray[np.bool_]

    def level(self, x: Array, derivative: int = 0) -> Array:
        """Level (2, n) of the right and of the left rail at places x (n,), or its derivative by x.

        At a corner a derivative is that of the rail ahead.
        """
        places = np.asarray(x, dtype=float)
        i = np.clip(np.searchsorted(self.x, places, side="right") - 1, 0, len(self.x) - 2)
        length = self.x[i + 1] - self.x[i]
        f = np.clip((places - self.x[i]) / length, 0.0, 1.0)
        powers = [f**k for k in range(4)]
        for _ in range(derivative):
            powers = [np.zeros_like(f), *(k * powers[k - 1] for k in range(1, 4))]
        value: Array = np.einsum("skc,ck->sk", self.cubics[:, i], np.array(powers))
        inside = (places >= self.x[0]) & (places < self.x[-1])
        return value if derivative == 0 else value * inside / length**derivative


def chain(x: Array, level: Array, slope_after: Array, slope_before: Array) -> RailProfile:
    """The profile with given levels and slopes at points, and corners where the slopes differ.

    x (n + 1,): the points (m), rising; level (2, n + 1) at them (m); slope_after (2, n) at the beginning of
    each interval and slope_before (2, n) at its end (m/m).
    """
    length, rise = np.diff(x), level[:, 1:] - level[:, :-1]
    here, there = slope_after * length, slope_before * length
    cubics = np.stack([level[:, :-1], here, 3 * rise - 2 * here - there, here + there - 2 * rise], axis=-1)
    jump = np.pad(slope_after, ((0, 0), (0, 1))) - np.pad(slope_before, ((0, 0), (1, 0)))
    corners = np.any(np.abs(jump) > _ROUNDING * np.max(np.abs(slope_after)), axis=0)
    return RailProfile(x, np.ascontiguousarray(cubics), corners)
