"""Figures over an axis as data for plotly.js: hover for values, zoom, switch curves on and off."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tbi_cli.report import style, words
from tbi_cli.report.marks import CRITICAL, RESONANCE
from tbi_cli.report.plot import Array, Axis, Band, Curve, Mark, Panel, Plot, Points, both_ways

# Pixels: above a panel for its title, for each row of marks, the panel, below it for its axis; the legend.
_TITLE, _MARKS, _PANEL, _FOOT, _LEGEND = 26, 13, 260, 56, 24
_GAP = 0.09  # of the width, between two columns
_ROW, _LETTER, _SAMPLE, _WIDTH = 26, 7.0, 48, 900  # pixels: of the legend's rows, letters, lines; its width
_CLOSE = 0.06  # of the height, between the numbers of two limits
_FAR = 1.6  # limits higher than so many times the curves are left out
_FONT = "system-ui, sans-serif"


@dataclass(frozen=True)
class _Cell:
    """Where a panel is: its axes' keys, its horizontal and vertical range in shares of the figure."""

    key: str
    x: tuple[float, float]
    y: tuple[float, float]


def interactive(plot: Plot) -> dict[str, Any] | None:
    """`data` and `layout` of a plotly figure; None for what is over time or a heat map.

    The numbers are those of the curves, divided by the factor of their unit's prefix.
    """
    panels = [panel for panel in plot.panels if isinstance(panel, Panel)]
    if plot.over_time or len(panels) < len(plot.panels):
        return None
    marks = max(len({mark.place for mark in panel.marks}) for panel in panels)
    cells, height = _cells(len(panels), marks)
    shared = all([c.label for c in panel.curves] == [c.label for c in panels[0].curves] for panel in panels)
    name, unit = plot.legend
    legend = _legend_height(panels, shared, bool(name))
    layout: dict[str, Any] = {
        "height": height + legend,
        "margin": {"l": 66, "r": 34, "t": 0, "b": legend},
        "hovermode": "x unified",
        "font": {"family": _FONT, "size": 12},
        "paper_bgcolor": "white",
        "plot_bgcolor": "white",
        "legend": {
            "orientation": "h",
            "y": 0,
            "yanchor": "top",
            "x": 0.5,
            "xanchor": "center",
            "title": {
                "text": words.html_symbols(_escaped(f"{name} [{unit}]" if unit else name)),
                "side": "top center",
            },
        },
        "shapes": [],
        "annotations": [],
    }
    data: list[dict[str, Any]] = []
    for k, (panel, cell) in enumerate(zip(panels, cells, strict=True)):
        x = _scale(panel.x, [curve.x for curve in panel.curves])
        y = _scale(panel.y, [curve.y for curve in panel.curves] + [band.high for band in panel.bands])
        layout[f"xaxis{cell.key}"] = _axis(panel.x, x, cell.x, f"y{cell.key}")
        head = _escaped(panel.x.label) + " %{x:.6~g} " + _escaped(x.unit)
        layout[f"xaxis{cell.key}"]["unifiedhovertitle"] = {"text": words.html_symbols(head)}
        layout[f"yaxis{cell.key}"] = _axis(panel.y, y, cell.y, f"x{cell.key}")
        if panel.from_zero:
            layout[f"yaxis{cell.key}"]["rangemode"] = "tozero"
        title = f"({chr(ord('a') + k)}) {panel.title}" if len(panels) > 1 else panel.title
        above = 4 + marks * _MARKS
        text = _text(f"<b>{_escaped(title)}</b>", cell.x[0], cell.y[1], "paper", "paper", above)
        layout["annotations"].append(text)
        _marks(layout, panel, cell.key, x.factor, marks)
        _limits(layout, panel, cell.key, y.factor)
        for band in panel.bands:
            data += _edges(band, cell.key, x, y, k == 0 or not shared)
        for curve in panel.curves:
            group = {
                "legendgroup": str(curve.place) if shared else f"{k}-{curve.place}",
                "showlegend": k == 0 or not shared,
            }
            trace = _trace(curve, cell.key, x, y) | group
            if not shared and len(panels) > 1:
                trace["name"] = f"({chr(ord('a') + k)}) {trace['name']}"
            data.append(trace)
        data += [_dots(points, cell.key, x, y) for points in panel.points]
    return {"data": data, "layout": layout}


def _cells(count: int, marks: int) -> tuple[list[_Cell], int]:
    """Where the panels are, row by row, and the height of them all in pixels."""
    columns = min(count, 2)
    rows = -(-count // columns)
    row = _TITLE + marks * _MARKS + _PANEL + _FOOT
    height = rows * row
    width = (1 - _GAP * (columns - 1)) / columns
    cells = []
    for k in range(count):
        down, across = divmod(k, columns)
        left = across * (width + _GAP)
        top = down * row + _TITLE + marks * _MARKS
        vertical = (1 - (top + _PANEL) / height, 1 - top / height)
        cells.append(_Cell("" if k == 0 else str(k + 1), (left, left + width), vertical))
    return cells, height


def _legend_height(panels: Sequence[Panel], shared: bool, named: bool) -> int:
    """Pixels for the legend below the panels: its heading and as many rows as its entries fill."""
    shown = panels[:1] if shared else panels
    texts = [curve.label for panel in shown for curve in panel.curves]
    texts += [band.label for panel in shown for band in panel.bands]
    rows = -(-sum(_SAMPLE + _LETTER * len(text) for text in texts) // _WIDTH)
    return int(_LEGEND + _ROW * (rows + named))


def _trace(curve: Curve, key: str, x: words.Scale, y: words.Scale) -> dict[str, Any]:
    dash = ",".join(f"{1.8 * length:.1f}px" for length in style.dashes(curve.place)) or "solid"
    return {
        "type": "scatter",
        "mode": "lines" if len(curve.x) > 12 else "lines+markers",
        "name": _escaped(curve.label),
        "x": _packed(curve.x / x.factor),
        "y": _packed(curve.y / y.factor),
        "xaxis": f"x{key}",
        "yaxis": f"y{key}",
        "line": {"color": style.colour(curve.place), "width": 1.8, "dash": dash, "simplify": False},
        "hovertemplate": "%{y:.4~g} " + _escaped(y.unit),
    }


def _dots(points: Points, key: str, x: words.Scale, y: words.Scale) -> dict[str, Any]:
    """Open circles, which the pointer passes over: the curve under them tells the numbers."""
    colour = style.colour(points.place)
    return {
        "type": "scatter",
        "mode": "markers",
        "name": _escaped(points.label),
        "x": _packed(points.x / x.factor),
        "y": _packed(points.y / y.factor),
        "xaxis": f"x{key}",
        "yaxis": f"y{key}",
        "marker": {"symbol": "circle-open", "size": 8, "color": colour},
        "showlegend": False,
        "hoverinfo": "skip",
    }


def _edges(band: Band, key: str, x: words.Scale, y: words.Scale, named: bool) -> list[dict[str, Any]]:
    """The lower edge of a band, and the upper one with what is between them filled."""
    colour = style.colour(band.place)
    red, green, blue = (int(colour[k : k + 2], 16) for k in (1, 3, 5))
    both = {
        "type": "scatter",
        "mode": "lines",
        "name": _escaped(band.label),
        "x": _packed(band.x / x.factor),
        "xaxis": f"x{key}",
        "yaxis": f"y{key}",
        "line": {"width": 0},
        "legendgroup": f"band-{band.place}-{band.depth}",
        "hovertemplate": "%{y:.4~g} " + _escaped(y.unit),
    }
    fill = {"fill": "tonexty", "fillcolor": f"rgba({red},{green},{blue},{style.BAND_ALPHAS[band.depth]})"}
    return [
        both | {"y": _packed(band.low / y.factor), "showlegend": False},
        both | {"y": _packed(band.high / y.factor), "showlegend": named} | fill,
    ]


def _axis(axis: Axis, scale: words.Scale, domain: Sequence[float], anchor: str) -> dict[str, Any]:
    name = words.html_symbols(_escaped(words.capital(axis.label)))
    return {
        "title": {"text": f"{name} [{_escaped(scale.unit)}]" if scale.unit else name, "standoff": 8},
        "domain": list(domain),
        "anchor": anchor,
        "type": "log" if axis.logarithmic else "linear",
        "gridcolor": "#e3e3e3",
        "linecolor": "#333",
        "mirror": True,
        "ticks": "inside",
        "zeroline": False,
    }


def _marks(layout: dict[str, Any], panel: Panel, key: str, factor: float, rows: int) -> None:
    """Speeds of note: thin lines, each curve's labels in a row of their own above the panel."""
    places = sorted({mark.place for mark in panel.marks if mark.place is not None})
    for mark in panel.marks:
        colour = style.MARK if mark.place is None else style.colour(mark.place)
        for value, beam in mark.values:
            dash = {"right": "dash", "left": "dot"}.get(beam, "solid")
            line = {"color": colour, "width": 1, "dash": dash}
            at = value / factor
            ends = {"x0": at, "x1": at, "y0": 0, "y1": 1, "xref": f"x{key}", "yref": f"y{key} domain"}
            layout["shapes"].append({"type": "line", **ends, "line": line, "opacity": 0.7, "layer": "below"})
        at = sum(value for value, _ in mark.values) / len(mark.values) / factor
        # plotly.js takes the place of a note on a logarithmic axis as an exponent, that of a line as it is.
        at = float(np.log10(at)) if panel.x.logarithmic else at
        above = _MARKS * (rows - 1 - places.index(mark.place)) if mark.place is not None else 0
        note = _text(_mark_text(mark), at, 1, f"x{key}", f"y{key} domain", above)
        layout["annotations"].append(note | {"font": {"size": 10, "color": colour}, "xanchor": "center"})


def _mark_text(mark: Mark) -> str:
    if mark.label.startswith(CRITICAL):
        return f"<i>v</i><sub>cr,{mark.label.removeprefix(CRITICAL)}</sub>"
    if mark.label.startswith(RESONANCE):
        return f"<i>v</i><sub>{mark.label.removeprefix(RESONANCE)}</sub>"
    return _escaped(mark.label)


def _limits(layout: dict[str, Any], panel: Panel, key: str, factor: float) -> None:
    """Limits of standards that are not far above the curves; below zero once more, if in sight."""
    low = min(float(np.nanmin(curve.y, initial=0)) for curve in panel.curves) / factor
    high = max(float(np.nanmax(curve.y, initial=0)) for curve in panel.curves) / factor
    shown = [at for limit in panel.limits if (at := limit.value / factor) <= _FAR * high]
    for at in both_ways(shown, low):
        line = {"color": style.LIMIT, "width": 1, "dash": "dash"}
        ends = {"x0": 0, "x1": 1, "y0": at, "y1": at, "xref": f"x{key} domain", "yref": f"y{key}"}
        layout["shapes"].append({"type": "line", **ends, "line": line, "layer": "below"})
    texts = [(f"{at:g}", at) for at in shown]
    if texts and max(shown) - min(shown) < _CLOSE * max(high, *shown):
        texts = [("<br>".join(text for text, _ in reversed(texts)), sum(shown) / len(shown))]
    for text, at in texts:
        look = {"font": {"size": 10, "color": style.LIMIT}, "yanchor": "middle", "xshift": 2}
        layout["annotations"].append(_text(text, 1, at, f"x{key} domain", f"y{key}", 0) | look)


def _text(text: str, x: float, y: float, x_of: str, y_of: str, above: float) -> dict[str, Any]:
    return {
        "text": text,
        "x": x,
        "y": y,
        "xref": x_of,
        "yref": y_of,
        "xanchor": "left",
        "yanchor": "bottom",
        "yshift": above,
        "showarrow": False,
    }


def _packed(values: Array) -> dict[str, str]:
    """Numbers as plotly.js takes them in bulk: float64, little-endian, base64."""
    data = np.ascontiguousarray(values, dtype="<f8").tobytes()
    return {"dtype": "f8", "bdata": base64.b64encode(data).decode("ascii")}


def _scale(axis: Axis, arrays: Sequence[Array]) -> words.Scale:
    finite = [float(np.max(np.abs(a[np.isfinite(a)]))) for a in arrays if np.isfinite(a).any()]
    return words.scale(axis.units, max(finite, default=0.0))


def _escaped(text: str) -> str:
    """Text for plotly.js, which takes a few tags from text."""
    return text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
