"""Heat maps: values over two axes, in colour, with the critical velocities across them."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke

from tbi_cli.report import style, words
from tbi_cli.report.draw_marks import SMALL, mark_text
from tbi_cli.report.plot import Axis, HeatPanel


def draw_heat(figure: Figure, axes: Axes, panel: HeatPanel, title: str) -> None:
    """One panel; grey where nothing was computed.  Critical velocities are named where they end."""
    x, y = _scale(panel.x, panel.columns), _scale(panel.y, panel.rows)
    value = _scale(panel.values_of, panel.values)
    axes.set_facecolor("#D9D9D9")
    mesh = axes.pcolormesh(
        panel.columns / x.factor,
        panel.rows / y.factor,
        np.ma.masked_invalid(panel.values / value.factor),
        shading="nearest",
        rasterized=True,
    )
    limits = axes.get_xlim(), axes.get_ylim()
    named: set[str] = set()
    for line in panel.lines:
        mark, _, beam = line.label.partition(" ")
        dashes = style.BEAM_DASHES[beam]
        axes.plot(
            line.x / x.factor,
            line.y / y.factor,
            color="white",
            linewidth=0.9,
            path_effects=[withStroke(linewidth=1.9, foreground="#00000070")],
            linestyle=(0, dashes) if dashes else "-",
        )
        end = line.x[-1] / x.factor, line.y[-1] / y.factor
        inside = all(low < place < high for place, (low, high) in zip(end, limits, strict=True))
        if inside and mark not in named:
            named.add(mark)
            _name(axes, mark_text(mark), end)
    axes.set_xlim(*limits[0])
    axes.set_ylim(*limits[1])
    if panel.x.logarithmic:
        axes.set_xscale("log")
    if panel.y.logarithmic:
        axes.set_yscale("log")
    axes.grid(visible=False)
    bar = figure.colorbar(mesh, ax=axes, pad=0.015)
    bar.set_label(_label(panel.values_of, value))
    axes.set_title(title)
    axes.set_xlabel(_label(panel.x, x))
    axes.set_ylabel(_label(panel.y, y))


def _name(axes: Axes, text: str, end: tuple[float, float]) -> None:
    """The name of a line, to the left of its end."""
    edge = withStroke(linewidth=1.2, foreground="#000000A0")
    axes.annotate(
        text, end, xytext=(-2, -2), textcoords="offset points", ha="right", va="top",
        fontsize=SMALL, color="white", path_effects=[edge],
    )  # fmt: skip


def _scale(axis: Axis, values: np.ndarray) -> words.Scale:
    known = values[np.isfinite(values)]
    return words.scale(axis.units, float(np.abs(known).max()) if known.size else 0.0)


def _label(axis: Axis, scale: words.Scale) -> str:
    name = words.mathtext(words.capital(axis.label))
    return f"{name} [{scale.unit}]" if scale.unit else name
