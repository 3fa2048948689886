"""The lines across a panel and their labels: critical velocities, the train's exit, comfort limits."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.transforms import Transform, blended_transform_factory

from tbi_cli.report import style
from tbi_cli.report.marks import CRITICAL, RESONANCE
from tbi_cli.report.plot import Limit, Panel, both_ways

ROW = 8.5  # points between rows of labels above a panel
_MOST_ROWS = 4
SMALL = 6.5  # points: the letters of labels
# Share of the axis between two labels of a row, at least: of two columns of panels, of three.
_APART, _APART_IN_THREE = 0.075, 0.13
# Labels of limits closer than this share of the axis become one; limits so far above the curves only a note.
_CLOSE, _FAR = 0.075, 1.6


def rows_of_labels(panel: Panel) -> int:
    """How many rows of labels stand above a panel: one for each curve with marks of its own."""
    rows = len({mark.place for mark in panel.marks})
    return rows if rows <= _MOST_ROWS else 0


def draw_marks(axes: Axes, panel: Panel, x_factor: float, y_factor: float, unit: str) -> int:
    """Thin lines with their labels above the panel; returns the number of rows of labels.

    `unit` is that of the curves' labels, which name the rows.

    Where that would be too many, each curve has a dot at each of its marks instead.
    """
    rows = rows_of_labels(panel)
    if panel.marks and not rows:
        _draw_dots(axes, panel, x_factor, y_factor)
        return 0
    above = blended_transform_factory(axes.transData, axes.transAxes)
    places = sorted({mark.place for mark in panel.marks if mark.place is not None})
    low, high = axes.get_xlim()
    spot = axes.get_subplotspec()
    apart = (high - low) * (_APART if spot is None or spot.get_gridspec().ncols < 3 else _APART_IN_THREE)
    labelled: dict[int, list[float]] = {}  # where the labels of each row stand
    for mark in panel.marks:
        colour = style.MARK if mark.place is None else style.colour(mark.place)
        for value, beam in mark.values:
            dashes = style.BEAM_DASHES[beam]
            line = (0, dashes) if dashes else "-"
            axes.axvline(value / x_factor, color=colour, linewidth=0.6, linestyle=line, zorder=1.5)
        row = 0 if mark.place is None else places.index(mark.place)
        height = 2.0 + ROW * (rows - 1 - row)
        middle = sum(value for value, _ in mark.values) / len(mark.values) / x_factor
        others = labelled.setdefault(row, [])
        if low <= middle <= high and all(abs(middle - x) > apart for x in others):
            others.append(middle)
            _annotate(axes, mark_text(mark.label), (middle, 1.0), above, (0, height), "center", colour)
    if rows > 1:
        labels = {curve.place: curve.label for curve in panel.curves}
        for row, place in enumerate(places):
            height = 2.0 + ROW * (rows - 1 - row)
            label = f"{labels.get(place, '')} {unit}"  # no curve where nothing is solved yet
            _annotate(axes, label, (1.0, 1.0), "axes fraction", (4, height), "left", style.colour(place))
    return rows


def _annotate(
    axes: Axes,
    text: str,
    at: tuple[float, float],
    coordinates: str | Transform,
    shift: tuple[float, float],
    ha: str,
    colour: str,
) -> None:
    axes.annotate(
        text, at, xycoords=coordinates, xytext=shift, textcoords="offset points", ha=ha, va="bottom",
        fontsize=SMALL, color=colour, annotation_clip=False,
    )  # fmt: skip


def mark_text(label: str) -> str:
    """The label of a mark for matplotlib: speeds of note as symbols."""
    if label.startswith(RESONANCE):
        return f"$v_{{{label.removeprefix(RESONANCE)}}}$"
    if not label.startswith(CRITICAL):
        return label
    return rf"$v_{{\mathrm{{cr}},{label.removeprefix(CRITICAL)}}}$"


def _draw_dots(axes: Axes, panel: Panel, x_factor: float, y_factor: float) -> None:
    for mark in panel.marks:
        if mark.place is None or mark.place >= len(panel.curves):
            continue
        curve = panel.curves[mark.place]
        for value, _ in mark.values:
            y = np.interp(value, curve.x, curve.y)
            axes.plot(
                value / x_factor,
                y / y_factor,
                "o",
                color=style.colour(mark.place),
                markersize=2.6,
                label="_dot",
            )


def draw_limits(axes: Axes, limits: Sequence[Limit], factor: float, unit: str) -> None:
    """Horizontal lines, their values and their standard at the right edge; below zero once more, if in sight.

    Limits far above the curves are only named, with their own `unit`, so that the curves keep the panel.
    """
    if not limits:
        return
    low, high = axes.get_ylim()
    values = [limit.value / factor for limit in limits]
    if min(values) > _FAR * high:
        texts = ", ".join(f"{limit.value:g}" for limit in limits)
        _beside(axes, f"{limits[0].label}: {texts} {unit} far above", 4, high, upright=True)
        return
    axes.set_ylim(low, max(high, 1.08 * max(values)))
    low, high = axes.get_ylim()
    for value in both_ways(values, low):
        axes.axhline(value, color=style.LIMIT, linewidth=0.6, linestyle=(0, (4, 2)), zorder=1.6)
    named = [(value, f"{value:g}") for value in values]
    if max(values) - min(values) < _CLOSE * (high - low):
        named = [(sum(values) / len(values), "\n".join(text for _, text in reversed(named)))]
    for value, text in named:
        _beside(axes, text, 3, value)
    _beside(axes, limits[0].label, 21, max(values) + 0.03 * (high - low), upright=True)


def _beside(axes: Axes, text: str, shift: float, y: float, upright: bool = False) -> None:
    """Text to the right of a panel by `shift` points, at y; upright text stands below y."""
    axes.annotate(
        text,
        (1.0, y),
        xycoords=blended_transform_factory(axes.transAxes, axes.transData),
        xytext=(shift, 0),
        textcoords="offset points",
        rotation=90 if upright else 0,
        ha="left",
        va="top" if upright else "center",
        fontsize=SMALL,
        color=style.LIMIT,
        annotation_clip=False,
    )
