"""Legends, always beside the curves: one for all panels where these share their curves, else one for each."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tbi_cli.report import words
from tbi_cli.report.plot import Panel, Plot

_LONG = 14  # characters: two such labels fill the width of a panel


def draw_legends(figure: Figure, cells: Sequence[Axes], plot: Plot) -> None:
    """Legends for the panels, which stand in the first `cells`; a shared one goes into a cell left over."""
    panels = [panel for panel in plot.panels if isinstance(panel, Panel)]
    sets = [[c.label for c in panel.curves] + [band.label for band in panel.bands] for panel in panels]
    name, unit = plot.legend
    heading = words.mathtext(name) + (f" [{unit}]" if unit else "")
    if not sets or (not name and all(len(labels) < 2 for labels in sets)):
        return
    if all(labels == sets[0] for labels in sets):
        handles = _handles(cells[0])
        if len(cells) > len(panels):
            cells[len(panels)].legend(handles=handles, title=heading or None, loc="center", alignment="left")
        else:
            figure.legend(
                handles=handles, title=heading or None, loc="outside lower center", ncols=min(len(handles), 8)
            )
        return
    for axes, labels in zip(cells, sets, strict=False):
        if len(labels) > 1 or name:
            columns = min(len(labels), 2 if max(map(len, labels)) > _LONG else 4)
            axes.legend(
                handles=_handles(axes), title=heading or None, loc="upper center", ncols=columns,
                bbox_to_anchor=(0.5, -0.19),
            )  # fmt: skip


def _handles(axes: Axes) -> list[Artist]:
    shown = [*axes.get_lines(), *axes.collections]
    return [artist for artist in shown if not str(artist.get_label()).startswith("_")]
