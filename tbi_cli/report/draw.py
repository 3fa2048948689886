"""Figures as pictures: a Plot drawn with matplotlib."""

from __future__ import annotations

import math
import re
import textwrap
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import ScalarFormatter

from tbi_cli.report import style, words
from tbi_cli.report.draw_heat import draw_heat
from tbi_cli.report.draw_legend import draw_legends
from tbi_cli.report.draw_marks import ROW, draw_limits, draw_marks, rows_of_labels
from tbi_cli.report.marks import LIFT_OFF
from tbi_cli.report.plot import Axis, Curve, HeatPanel, Panel, Plot

_WIDTH, _SINGLE_WIDTH = 7.1, 4.8  # inches: two columns of a journal's page; one panel alone
_HEIGHT, _STACKED_HEIGHT = 2.55, 2.0
_TITLE = {1: 64, 2: 38, 3: 24}  # characters in a line of a panel's title, by number of columns
# Curves that lie within this share of the panel's range of each other would hide each other.
_COINCIDE = 0.03
_FEW = 12  # points: marked one by one


def draw(plot: Plot) -> Figure:
    """The figure; call it with the style of `style.in_style` in force.

    Three panels over time share that axis in one column; others stand in two columns, many in three.
    """
    count = len(plot.panels)
    columns = 1 if count == 1 or _stacked(plot) else 2 if count <= 4 else 3
    rows = math.ceil(count / columns)
    height = _STACKED_HEIGHT if _stacked(plot) else _HEIGHT
    labels = max((rows_of_labels(panel) for panel in plot.panels if isinstance(panel, Panel)), default=0)
    size = (_SINGLE_WIDTH if count == 1 else _WIDTH, rows * (height + labels * ROW / 72) + 0.3)
    figure = Figure(figsize=size)
    grid = figure.subplots(rows, columns, squeeze=False, sharex="col" if _stacked(plot) else False)
    cells = list(grid.flat)
    nested = any(_hide_each_other(panel.curves) for panel in plot.panels if isinstance(panel, Panel))
    for k, (axes, panel) in enumerate(zip(cells, plot.panels, strict=False)):
        title = words.literal(textwrap.fill(_unparted(panel.title), _TITLE[columns]))
        title = f"({chr(ord('a') + k)}) {title}" if count > 1 else words.capital(title)
        if isinstance(panel, HeatPanel):
            draw_heat(figure, axes, panel, title)
        else:
            _draw_panel(axes, panel, title, plot.legend[1], nested)
            if not _stacked(plot) or k == count - 1:
                axes.set_xlabel(axis_label(panel.x, _scale(panel.x, [curve.x for curve in panel.curves])))
    for axes in cells[count:]:
        axes.set_axis_off()
    draw_legends(figure, cells, plot)
    return figure


def _stacked(plot: Plot) -> bool:
    shown = {panel.shown for panel in plot.panels if isinstance(panel, Panel)}
    return len(plot.panels) == 3 and plot.over_time and len(shown) == 1


def _draw_panel(axes: Axes, panel: Panel, title: str, unit: str, nested: bool) -> None:
    x = _scale(panel.x, [curve.x for curve in panel.curves])
    y = _scale(panel.y, [curve.y for curve in panel.curves] + [band.high for band in panel.bands])
    for band in panel.bands:
        edges = (band.x / x.factor, band.low / y.factor, band.high / y.factor)
        colour = style.colour(band.place)
        alpha = style.BAND_ALPHAS[band.depth]
        axes.fill_between(*edges, color=colour, alpha=alpha, linewidth=0, label=words.literal(band.label))
    widths = np.linspace(3.4, 0.8, len(panel.curves)).tolist() if nested else [None] * len(panel.curves)
    for curve, width in zip(panel.curves, widths, strict=True):
        _draw_curve(axes, curve, x.factor, y.factor, width)
    for points in panel.points:
        at = (points.x / x.factor, points.y / y.factor)
        look = style.POINTS.get(points.label, style.POINTS[LIFT_OFF])
        axes.plot(*at, color=style.colour(points.place), label=f"_{points.label}", **look)
    if panel.x.logarithmic:
        axes.set_xscale("log")
    if panel.y.logarithmic:
        axes.set_yscale("log")
    axes.set_xlim(*(end / x.factor for end in panel.shown or _ends(panel)))
    if panel.from_zero:
        highest = axes.dataLim.ymax
        axes.set_ylim(0, 1.06 * highest if 0 < highest < math.inf else None)
    rows = draw_marks(axes, panel, x.factor, y.factor, unit)
    draw_limits(axes, panel.limits, y.factor, words.typeset(panel.y.units))
    axes.set_title(title, pad=4 + ROW * rows)
    axes.set_ylabel(axis_label(panel.y, y))
    _plain_ticks(axes)


def _plain_ticks(axes: Axes) -> None:
    """Plain text for numbers without powers of ten: setting mathematics takes a third of a figure's time."""
    for axis in (axes.xaxis, axes.yaxis):
        form = axis.get_major_formatter()
        if isinstance(form, ScalarFormatter) and 1e-3 <= np.max(np.abs(axis.get_view_interval())) < 1e5:
            form.set_useMathText(False)


def _unparted(title: str) -> str:
    """A title whose last word, if it is only a number or a letter, keeps to the line of the one before."""
    return re.sub(r" (?=\S{1,2}$)", "\N{NO-BREAK SPACE}", title)


def _ends(panel: Panel) -> tuple[float, float]:
    low = min(float(curve.x.min()) for curve in panel.curves)
    high = max(float(curve.x.max()) for curve in panel.curves)
    if panel.x.logarithmic:
        return low, high
    if max(len(curve.x) for curve in panel.curves) <= _FEW:
        edge = 0.02 * (high - low)  # room for the markers
        return low - edge, high + edge
    # Velocities are read from zero.
    return (0.0 if 0 < low < 0.1 * high else low, high)


def _hide_each_other(curves: Sequence[Curve]) -> bool:
    """Whether three or more curves coincide: then each is drawn thinner than the one before it."""
    if len(curves) < 3 or not all(np.isfinite(curve.y).all() for curve in curves):
        return False
    last = curves[-1]
    apart = [np.max(np.abs(curve.y - np.interp(curve.x, last.x, last.y))) for curve in curves[:-1]]
    return bool(max(apart) < _COINCIDE * np.ptp(last.y))


def _draw_curve(axes: Axes, curve: Curve, x_factor: float, y_factor: float, width: float | None) -> None:
    x, y = curve.x / x_factor, curve.y / y_factor
    look: dict[str, Any] = {"color": style.colour(curve.place), "label": words.literal(curve.label)}
    dashes = style.dashes(curve.place)
    if width is not None:
        look |= {"linewidth": width}
        dashes = () if width > 1.0 else dashes
    if len(x) <= _FEW:
        look |= {"marker": style.marker(curve.place), "markersize": 3.2}
    axes.plot(x, y, linestyle=(0, dashes) if dashes else "-", **look)
    known = np.isfinite(y)
    alone = known & ~np.append(known[1:], False) & ~np.append(False, known[:-1])
    if alone.any() and len(x) > _FEW:
        axes.plot(x[alone], y[alone], ".", color=look["color"], markersize=2.5, label="_alone")


def _scale(axis: Axis, arrays: Sequence[np.ndarray]) -> words.Scale:
    finite = [float(np.max(np.abs(a[np.isfinite(a)]))) for a in arrays if np.isfinite(a).any()]
    return words.scale(axis.units, max(finite, default=0.0))


def axis_label(axis: Axis, scale: words.Scale) -> str:
    """The name of an axis with its unit in brackets."""
    name = words.mathtext(words.capital(axis.label))
    return f"{name} [{scale.unit}]" if scale.unit else name
