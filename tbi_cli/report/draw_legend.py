"""Legends, always beside the curves: one for all panels where these share their curves, else one for each."""

from __future__ import annotations

import re
from collections.abc import Sequence

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from tbi_cli.report import style, words
from tbi_cli.report.marks import CRITICAL
from tbi_cli.report.plot import Panel, Plot

_LONG = 14  # characters: two such labels fill the width of a panel
_LETTER, _SAMPLE = 4.4, 44  # points: a letter, the sample of a line with the gaps around it


def draw_legends(figure: Figure, cells: Sequence[Axes], plot: Plot) -> None:
    """Legends for the panels, which stand in the first `cells`; a shared one goes into a cell left over.

    Thin lines of two beams and marked points are named in them too.
    """
    panels = [panel for panel in plot.panels if isinstance(panel, Panel)]
    sets = [[c.label for c in panel.curves] + [band.label for band in panel.bands] for panel in panels]
    name, unit = plot.legend
    heading = words.mathtext(name) + (f" [{unit}]" if unit else "")
    if not sets:
        return
    named = bool(name) or any(len(labels) > 1 for labels in sets)
    if all(labels == sets[0] for labels in sets):
        handles = (_handles(cells[0]) if named else []) + _keys(cells, panels)
        if not handles:
            return
        if len(cells) > len(panels):
            cells[len(panels)].legend(handles=handles, title=heading or None, loc="center", alignment="left")
        else:
            columns = _columns(handles, 72 * figure.get_figwidth())
            figure.legend(handles=handles, title=heading or None, loc="outside lower center", ncols=columns)
        return
    for axes, panel, labels in zip(cells, panels, sets, strict=False):
        if len(labels) > 1 or name:
            handles = _handles(axes) + _keys([axes], [panel])
            longest = max(len(str(handle.get_label())) for handle in handles)
            columns = min(len(handles), 2 if longest > _LONG else 4)
            axes.legend(
                handles=handles, title=heading or None, loc="upper center", ncols=columns,
                bbox_to_anchor=(0.5, -0.19),
            )  # fmt: skip


def _columns(handles: Sequence[Artist], room: float) -> int:
    """All in one row if that is `room` points wide at most, else rows of equal length."""
    texts = [re.sub(r"\\mathrm|[${}\\]", "", str(handle.get_label())) for handle in handles]
    widths = [_SAMPLE + _LETTER * len(text) for text in texts]
    if sum(widths) <= room:
        return len(widths)
    fit = max(1, int(room // max(widths)))
    rows = -(-len(widths) // fit)
    return -(-len(widths) // rows)


def _keys(cells: Sequence[Axes], panels: Sequence[Panel]) -> list[Artist]:
    """What stands for the critical velocities of either beam, where there are two, and for marked points."""
    critical = [mark for panel in panels for mark in panel.marks if mark.label.startswith(CRITICAL)]
    sides = dict.fromkeys(side for mark in critical for _, side in mark.values)
    found: list[Artist] = [
        Line2D(
            [], [], color=style.MARK, linewidth=0.8, linestyle=(0, style.BEAM_DASHES[side]),
            label=rf"$v_\mathrm{{cr}}$, {side} beam",
        )
        for side in (sides if len(sides) > 1 else ())
    ]  # fmt: skip
    for label in dict.fromkeys(points.label for panel in panels for points in panel.points):
        key = Line2D([], [])
        key.update_from(next(a for axes in cells for a in axes.get_lines() if a.get_label() == f"_{label}"))
        key.set(color=style.MARK, label=label)
        found.append(key)
    return found


def _handles(axes: Axes) -> list[Artist]:
    shown = [*axes.get_lines(), *axes.collections]
    return [artist for artist in shown if not str(artist.get_label()).startswith("_")]
