"""Wheels that may lift off: their forces in time, and how often they do over an axis."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from tbi_cli.report.ensembles import seeds_of
from tbi_cli.report.panels import View, in_time, over_axis
from tbi_cli.report.paper_figures import caption
from tbi_cli.report.plot import Panel, Plot
from tbi_cli.report.study import Study, StudyAxis

_SIDES = ("right", "left")
_OVER_AXIS = (("least force", "min", "force"), ("time aloft", "max", "time_aloft"))
_AXLES = 4


def contact_figures(study: Study, select: Mapping[str, int]) -> Iterator[Plot]:
    """Forces of the wheels in time, lift-off marked; least force and time aloft over the last axis.

    An ensemble has figures of its own over its other axes.
    """
    if study.case is None or study.case.contact.model != "hertz":
        return
    view = View(study, None, dict(select))
    if study.index(select) in study.histories:
        names = {side: _wheels(study, "history", f"{side}_force") for side in _SIDES}
        panels = [in_time(view, f"{side} wheels", found) for side, found in names.items() if found]
        yield _plot(study, "wheel-forces", "Forces of the wheels on their rails", panels, None, select)
    free = [axis for axis in study.varied if axis.name not in select]
    if free and seeds_of(study) is None:
        panels = [
            over_axis(view, f"{title}, {side} wheels", table, found, free[-1])
            for title, table, what in _OVER_AXIS
            for side in _SIDES
            if (found := _wheels(study, table, f"{side}_{what}"))
        ]
        yield _plot(study, "lift-off", "Unloading of the wheels", panels, free[-1], select)


def _wheels(study: Study, table: str, ending: str) -> list[str]:
    """The channels of one kind, one for each of the first axles."""
    variables = study.results.history_channels if table == "history" else study.results.channels
    names = [v.name for v in variables if v.name.startswith("wheel_") and v.name.endswith(ending)]
    return names[:_AXLES]


def _plot(
    study: Study,
    name: str,
    heading: str,
    panels: Sequence[Panel | None],
    x: StudyAxis | None,
    select: Mapping[str, int],
) -> Plot:
    shown = [_by_axle(panel) for panel in panels if panel is not None]
    text = caption(study, select, shown, x, None)
    return Plot(f"{study.name}-{name}", heading, text, tuple(shown), study=study.name)


def _by_axle(panel: Panel) -> Panel:
    """The same panel, its curves called by their axles, so that all panels share one legend."""
    labels = (curve.label.rpartition(" wheel of ")[2] for curve in panel.curves)
    renamed = (replace(curve, label=label) for curve, label in zip(panel.curves, labels, strict=True))
    return replace(panel, curves=tuple(renamed))
