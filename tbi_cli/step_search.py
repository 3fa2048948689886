"""Which speeds one step of a refined axis needs: its peaks to the tolerance, and a line through the rest."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from tbi_cli.case.refinement import LEAST_PARTS, Refinement

Array = NDArray[np.float64]

# How much more a channel may be off the straight line in a dip, where no peak is to be settled.
_IN_DIPS = 5.0
# A peak is the highest for so many of the finest distances to either side: of the wiggles that sampling
# leaves on a curve, the others are left alone.
_HIGHEST_AMONG = 8


class StepSearch:
    """The search in the step number `cell` of an axis of `speeds`.

    It begins with the ends of its step and of those beside it, and with the places of resonance in the
    three.  A place is an index of `speeds`, `per_step` in each step.
    """

    def __init__(self, cell: int, speeds: Array, refinement: Refinement, resonant: NDArray[np.int64]) -> None:
        step, last = refinement.per_step, len(speeds) - 1
        self._low, self._high = cell * step, (cell + 1) * step
        ends = range(max(self._low - step, 0), min(self._high + step, last) + 1, step)
        inside = resonant[(resonant > ends[0]) & (resonant < ends[-1])]
        #: All places that it has asked for, in rising order.
        self.places: list[int] = sorted({*ends, *inside.tolist()})
        self._ends = list(ends)
        self._speeds, self._tolerance = speeds, refinement.tolerance
        # Down to this distance lines are drawn closer; peaks are settled beyond it.
        self._drawn = step // LEAST_PARTS
        # Between which places it follows peaks: in its step, and wherever the peaks there have led to.
        self._follows = (self._low, self._high)
        #: Which scenarios have a peak that is not settled yet, at which places.
        self.unsettled: dict[int, NDArray[np.bool_]] = {}
        self._ended = False

    def more(self, peaks: Mapping[int, Array]) -> list[int]:
        """The places to come in, given the peaks (channels, scenarios) at those that it has asked for."""
        if self._ended:
            return []
        new = self._between_peaks(peaks) | self._along_lines(peaks)
        self.places = sorted({*self.places, *new})
        self._ended = not new
        return sorted(new)

    def _between_peaks(self, peaks: Mapping[int, Array]) -> set[int]:
        """Places beside peaks that may be higher than what was found by more than the tolerance."""
        places = np.array(self.places)
        low, mid, high = _triples(places, peaks)
        before, behind, curved = self._curvature(places, low, mid, high)
        with np.errstate(invalid="ignore"):
            top = (mid >= low) & (mid >= high) & self._highest(places, peaks)
            wanting = [top & (curved * way**2 > self._tolerance * mid) for way in (before, behind)]
        self.unsettled = {}
        new: set[int] = set()
        while True:
            first, last = self._follows
            at = np.flatnonzero(top.any(axis=(1, 2)) & (places[1:-1] >= first) & (places[1:-1] <= last))
            reach = [*self._follows, *places[at].tolist(), *places[at + 2].tolist()]
            if (min(reach), max(reach)) == self._follows:
                break
            self._follows = min(reach), max(reach)
        for k in at.tolist():
            asked = wanting[0][k] | wanting[1][k]
            if asked.any():
                self.unsettled[int(places[k + 1])] = asked.any(axis=0)
            for side, wants in enumerate(wanting):
                left, right = int(places[k + side]), int(places[k + side + 1])
                if wants[k].any() and right - left > 1:
                    new.add(_inside(left, right))
        return new

    def _highest(self, places: NDArray[np.int64], peaks: Mapping[int, Array]) -> NDArray[np.bool_]:
        """Whether no place nearby is higher than one, (places but the ends, channels, scenarios)."""
        values = np.array([peaks[place] for place in places.tolist()])
        first = np.searchsorted(places, places - _HIGHEST_AMONG)
        end = np.searchsorted(places, places + _HIGHEST_AMONG, side="right")
        largest = [np.fmax.reduce(values[i:j]) for i, j in zip(first[1:-1], end[1:-1], strict=True)]
        return np.asarray(values[1:-1] >= np.array(largest))

    def _along_lines(self, peaks: Mapping[int, Array]) -> set[int]:
        """Places in the step where a straight line would be off by more than the tolerance.

        It may be relative to the largest value at the ends and here; where it is above the channel, in a dip
        between peaks, more.
        """
        places = np.array([place for place in self.places if place % self._drawn == 0])
        low, mid, high = _triples(places, peaks)
        before, behind, curved = self._curvature(places, low, mid, high)
        around = np.fmax.reduce([peaks[place] for place in self._ends])
        size = self._tolerance * np.fmax(np.fmax(np.fmax(low, mid), high), around)
        new: set[int] = set()
        # A scenario that failed is NaN and bends nothing.
        with np.errstate(invalid="ignore"):
            for side, way in enumerate((before, behind)):
                off = curved * way**2
                bent = ((off > size) | (off < -_IN_DIPS * size)).any(axis=(1, 2))
                for k in np.flatnonzero(bent).tolist():
                    left, right = int(places[k + side]), int(places[k + side + 1])
                    if self._low <= left and right <= self._high and right - left > self._drawn:
                        new.add(_inside(left, right))
        return new

    def _curvature(
        self, places: NDArray[np.int64], low: Array, mid: Array, high: Array
    ) -> tuple[Array, Array, Array]:
        """The ways (k, 1, 1) to the places before and behind each, and minus half of the second derivative.

        A parabola with this bend is off its chord over a way h by a quarter of bend h^2.
        """
        speeds = self._speeds[places]
        before = (speeds[1:-1] - speeds[:-2])[:, None, None]
        behind = (speeds[2:] - speeds[1:-1])[:, None, None]
        return before, behind, ((mid - low) / before - (high - mid) / behind) / (before + behind)


def _inside(left: int, right: int) -> int:
    """The place between two in the coarsest halving of the steps: the most even number there."""
    shift = (left ^ (right - 1)).bit_length() - 1
    return (right - 1) >> shift << shift


def _triples(places: NDArray[np.int64], peaks: Mapping[int, Array]) -> tuple[Array, Array, Array]:
    """The peaks before, at and behind every place but the ends: (places, channels, scenarios) each."""
    values = np.array([peaks[place] for place in places.tolist()])
    return values[:-2], values[1:-1], values[2:]
