"""Heat maps: one channel over two axes, with the critical velocities where one of them is velocity."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tbi_cli.report import marks, words
from tbi_cli.report.panels import axis_of
from tbi_cli.report.plot import Axis, Curve, HeatPanel
from tbi_cli.report.study import Study, StudyAxis

_VELOCITY = frozenset({"velocity"})


def heat_panel(
    study: Study,
    title: str,
    table: str,
    channel: str,
    x: StudyAxis,
    y: StudyAxis,
    place: Mapping[str, int],
) -> HeatPanel | None:
    """A channel of a table over the axes x and y; None if the file lacks it."""
    variable = study.variable(table, channel)
    if variable is None:
        return None
    name = "dynamic amplification factor" if table == "daf" else words.quantity_of(variable)
    return HeatPanel(
        title=title,
        x=axis_of(x),
        y=axis_of(y),
        values_of=Axis(words.of_table(table, name), variable.units),
        columns=x.values,
        rows=y.values,
        values=study.along(table, channel, [y, x], place),
        lines=_critical_lines(study, channel, x, y, place),
    )


def _critical_lines(
    study: Study, channel: str, x: StudyAxis, y: StudyAxis, place: Mapping[str, int]
) -> tuple[Curve, ...]:
    """The critical velocity of each mode and beam along the other axis; none where no axis is velocity.

    They are called by their mark and their beam: "v_cr1 right".
    """
    if _VELOCITY not in (x.paths, y.paths):
        return ()
    other = y if x.paths == _VELOCITY else x
    found: dict[tuple[str, str], list[tuple[float, float]]] = {}
    for index, value in enumerate(other.values.tolist()):
        case = study.case_at({**place, other.name: index})
        for of_mode in marks.critical(case, marks.side_of([channel])) if case else []:
            for velocity, beam in of_mode.values:
                found.setdefault((of_mode.label, beam), []).append((velocity, value))
    lines = []
    for (mark, beam), points in found.items():
        velocities, values = (np.array(column) for column in zip(*points, strict=True))
        ends = (velocities, values) if other is y else (values, velocities)
        lines.append(Curve(f"{mark} {beam}", *ends))
    return tuple(lines)
