"""From a study to a panel of curves: over an axis of the grid, or in time."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from tbi_cli.case import Case
from tbi_cli.report import marks, words
from tbi_cli.report.plot import TIME, Axis, Curve, Mark, Panel
from tbi_cli.report.study import Study, StudyAxis
from tbi_cli.store import Variable

# Figures over time end after so many crossings: later there is little left to see.
_SHOWN_CROSSINGS = 2.0


@dataclass(frozen=True)
class Family:
    """The axis of which every value is a curve, and which values are drawn, in the order of the file."""

    axis: StudyAxis
    members: tuple[int, ...]

    @classmethod
    def of(cls, axis: StudyAxis, most: int) -> Family:
        """All values of an axis, or `most` of them, evenly spread, the first and the last among them."""
        count = len(axis.values)
        spread = np.unique(np.linspace(0, count - 1, min(count, most)).round().astype(int))
        return cls(axis, tuple(sorted(spread.tolist(), key=lambda member: int(axis.order[member]))))

    @property
    def legend(self) -> tuple[str, str]:
        """The heading of the legend: the axis and its unit."""
        return words.axis_words(self.axis.lead, self.axis.paths), self._scale.unit

    def label(self, member: int) -> str:
        """The text for one curve."""
        return words.number(float(self.axis.lead.values[member]) / self._scale.factor)

    @property
    def _scale(self) -> words.Scale:
        lead = self.axis.lead
        return words.scale(lead.units, float(np.max(np.abs(lead.values))))


@dataclass(frozen=True)
class View:
    """Which part of a study a panel shows: the family, and where the other axes stand (else: base case)."""

    study: Study
    family: Family | None = None
    place: Mapping[str, int] = field(default_factory=dict)

    def places(self) -> list[dict[str, int]]:
        """The place of every member of the family, or the one place."""
        if self.family is None:
            return [dict(self.place)]
        return [{**self.place, self.family.axis.name: member} for member in self.family.members]

    def label(self, side: str | None, member: int) -> str:
        """The label of the curve of the family's k-th member; dampings of a beam are told as ratios too."""
        assert self.family is not None
        index = self.family.members[member]
        label = self.family.label(index)
        case = self.study.case_at(self.places()[member])
        beam = getattr(case.bridge, side) if case and side and self._is_damping() else None
        if beam is None or case is None:
            return label
        return f"{label} (ζ₁ = {100 * beam.first_mode_damping_ratio(case.bridge.length):.2f} %)"

    def _is_damping(self) -> bool:
        return self.family is not None and all("damping" in path for path in self.family.axis.paths)

    def marks(self, of_case: Callable[[Case], list[Mark]]) -> tuple[Mark, ...]:
        """The marks of every member of the family; where all members have the same, they are marked once."""
        cases = [self.study.case_at(place) for place in self.places()]
        sets = [of_case(case) if case else [] for case in cases]
        if all(marks == sets[0] for marks in sets):
            return tuple(sets[0])
        return tuple(replace(mark, place=k) for k, found in enumerate(sets) for mark in found)


def over_axis(view: View, title: str, table: str, channels: Sequence[str], x: StudyAxis) -> Panel | None:
    """The channels of a table over one axis; None if the file lacks one of them.

    With a family there is one channel, and a curve for each member; else a curve for each channel.
    """
    variables = _variables(view.study, table, channels)
    if variables is None:
        return None
    side = marks.side_of(channels)
    curves: list[Curve] = []
    for variable in variables:
        if view.family is None:
            y = view.study.along(table, variable.name, [x], view.place)
            curves.append(_solved(x, Curve(words.body_of(variable), x.values, y, len(curves))))
            continue
        values = view.study.along(table, variable.name, [view.family.axis, x], view.place)
        curves += [
            _solved(x, Curve(view.label(side, k), x.values, values[member], k))
            for k, member in enumerate(view.family.members)
        ]
    over_velocity = x.paths == frozenset({"velocity"})
    lines = view.marks(lambda case: marks.critical(case, side)) if over_velocity else ()
    units = variables[0].units
    return Panel(
        title=title,
        x=axis_of(x),
        y=Axis(words.of_table(table, _quantity(view.study, table, variables)), units),
        curves=tuple(curves),
        marks=marks.within(lines, float(x.values.min()), float(x.values.max())),
        limits=marks.limits(channels) if table in ("peak", "max", "rms") else (),
        from_zero=table in ("peak", "rms") and units != "N",
    )


def _solved(x: StudyAxis, curve: Curve) -> Curve:
    """A curve over an axis that grows its own values: through those that were solved, whatever is between."""
    known = np.isfinite(curve.y)
    if not x.refined or not known.any():
        return curve
    return replace(curve, x=curve.x[known], y=curve.y[known])


def in_time(view: View, title: str, channels: Sequence[str]) -> Panel | None:
    """The histories of the channels; None if the file lacks one, or any history."""
    variables = _variables(view.study, "history", channels)
    if variables is None:
        return None
    side = marks.side_of(channels)
    curves: list[Curve] = []
    for k, place in enumerate(view.places()):
        history = view.study.history(place, channels)
        if history is None:
            continue
        for c, variable in enumerate(variables):
            label = words.body_of(variable) if view.family is None else view.label(side, k)
            curves.append(Curve(label, history.time, history.values[c], k + c))
    if not curves:
        return None
    lifted = [marks.lift_offs(curve) for curve in curves] if marks.are_wheel_forces(channels) else []
    exits = view.marks(marks.leaving)
    end = max(float(curve.x[-1]) for curve in curves)
    last = max((value for mark in exits for value, _ in mark.values), default=end)
    return Panel(
        title=title,
        x=TIME,
        y=Axis(_quantity(view.study, "history", variables), variables[0].units),
        curves=tuple(curves),
        marks=exits,
        points=tuple(points for points in lifted if points is not None),
        limits=marks.limits(channels),
        shown=(min(float(curve.x[0]) for curve in curves), min(end, _SHOWN_CROSSINGS * last)),
    )


def axis_of(axis: StudyAxis) -> Axis:
    """A swept axis as the axis of a panel; one whose values keep a ratio is logarithmic."""
    values = axis.values
    logarithmic = False
    if len(values) > 3 and values.min() > 0 and values.max() >= 10 * values.min():
        ratios = values[1:] / values[:-1]
        logarithmic = bool(np.allclose(ratios, ratios[0], rtol=1e-6))
    return Axis(words.axis_words(axis.dim, axis.paths), axis.dim.units, logarithmic)


def _variables(study: Study, table: str, channels: Sequence[str]) -> list[Variable] | None:
    found = [study.variable(table, channel) for channel in channels]
    return None if None in found else [variable for variable in found if variable is not None]


def _quantity(study: Study, table: str, variables: Sequence[Variable]) -> str:
    """What the channels of a panel have in common."""
    if table == "time_of_peak":
        peaks = [study.variable("peak", variable.name) for variable in variables]
        variables = [peak for peak in peaks if peak is not None]
    if table == "daf":
        return "dynamic amplification factor"
    return " / ".join(dict.fromkeys(words.quantity_of(variable) for variable in variables))
