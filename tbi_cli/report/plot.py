"""What is drawn, as plain data in SI: figures of panels of curves.  How it is drawn is another matter."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Axis:
    """An axis of a panel: what it measures, its SI units, and whether it shows orders of magnitude."""

    label: str
    units: str
    logarithmic: bool = False


@dataclass(frozen=True, eq=False)
class Curve:
    """One curve, in SI, NaN where nothing was computed.  Its `place` in the family decides its look."""

    label: str
    x: Array
    y: Array
    place: int = 0


@dataclass(frozen=True, eq=False)
class Band:
    """What lies between two curves over the same axis, in SI: the spread of an ensemble.

    `place` is that of the curve in whose colour it is; the wider of two has the smaller `depth`.
    """

    label: str
    x: Array
    low: Array
    high: Array
    place: int = 0
    depth: int = 0


@dataclass(frozen=True, eq=False)
class Points:
    """Single points on a curve that something is said of: where a wheel lifts off."""

    label: str
    x: Array
    y: Array
    place: int = 0


@dataclass(frozen=True)
class Mark:
    """Thin lines across a panel with one label: where the train leaves, or a critical velocity of each beam.

    `values` are (x, beam), the beam "" where there is none.  `place` is that of the curve that the mark
    belongs to; None: of all.
    """

    label: str
    values: tuple[tuple[float, str], ...]
    place: int | None = None


@dataclass(frozen=True)
class Limit:
    """A horizontal line: a value that a standard names."""

    label: str
    value: float


def both_ways(values: Sequence[float], low: float) -> list[float]:
    """Where the lines of limits are drawn: at their values, and below zero once more, if above `low`."""
    return [*values, *(-value for value in values if -value > low)]


@dataclass(frozen=True, eq=False)
class Panel:
    """Curves over one axis."""

    title: str
    x: Axis
    y: Axis
    curves: tuple[Curve, ...]
    marks: tuple[Mark, ...] = ()
    bands: tuple[Band, ...] = ()
    points: tuple[Points, ...] = ()
    limits: tuple[Limit, ...] = ()
    #: The part of the axis that is shown; all of it if None.
    shown: tuple[float, float] | None = None
    #: Whether the y axis starts at zero.
    from_zero: bool = False


@dataclass(frozen=True, eq=False)
class HeatPanel:
    """Values (rows, columns) over two axes, with curves across them: critical velocities."""

    title: str
    x: Axis
    y: Axis
    values_of: Axis
    columns: Array
    rows: Array
    values: Array
    lines: tuple[Curve, ...] = ()


@dataclass(frozen=True, eq=False)
class Plot:
    """One figure.

    `name` is that of its files; `caption` says all that the drawing does not.  `legend` is the axis of which
    every value is a curve, and its unit; empty where the curves are different things.
    """

    name: str
    heading: str
    caption: str
    panels: tuple[Panel | HeatPanel, ...]
    legend: tuple[str, str] = ("", "")
    study: str = ""
    notes: tuple[str, ...] = ()

    @property
    def over_time(self) -> bool:
        """Whether the curves run over time."""
        return any(isinstance(panel, Panel) and panel.x.label == TIME.label for panel in self.panels)

    @property
    def empty(self) -> bool:
        """Whether there is no number in it."""
        for panel in self.panels:
            arrays = [curve.y for curve in panel.curves] if isinstance(panel, Panel) else [panel.values]
            if any(np.isfinite(array).any() for array in arrays):
                return False
        return True

    def with_notes(self, *notes: str) -> Plot:
        """The same figure with more to say of it."""
        return replace(self, notes=(*self.notes, *notes))


TIME = Axis("time", "s")
