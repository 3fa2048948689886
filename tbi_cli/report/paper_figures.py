"""Which studies fit which figure of the catalogue, and the figure that they make."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from tbi_cli.report import marks, words
from tbi_cli.report.catalogue import FigureSpec, PanelSpec, Run
from tbi_cli.report.panels import Family, View, in_time, over_axis
from tbi_cli.report.plot import TIME, Axis, Curve, Mark, Panel, Plot
from tbi_cli.report.study import Study, StudyAxis

_MOST_MEMBERS = 8


@dataclass(frozen=True)
class Fit:
    """A study with the data of a figure, the axes that the figure uses, and where others have to stand."""

    study: Study
    x: StudyAxis | None
    family: Family | None
    place: Mapping[str, int]

    @property
    def used(self) -> set[str]:
        """The names of the axes that the figure shows or asks for."""
        axes = [self.x, self.family.axis if self.family else None]
        return {axis.name for axis in axes if axis} | set(self.place)

    @property
    def left(self) -> int:
        """How many axes vary that the figure does not show."""
        return len([axis for axis in self.study.varied if axis.name not in self.used])


def paper_figure(
    spec: FigureSpec, studies: Sequence[Study], select: Mapping[str, Mapping[str, int]]
) -> tuple[Plot, list[Fit]] | None:
    """The figure from the study that varies least besides, the first of two; None if none has its data.

    `select` tells, by study, where axes stand that the figure does not show.
    """
    if any(panel.runs for panel in spec.panels):
        return _from_runs(spec, studies)
    fits = [fit for study in studies if (fit := fit_of(spec, study, select.get(study.name, {})))]
    for fit in sorted(fits, key=lambda fit: fit.left):
        plot = _drawn(spec, fit, select.get(fit.study.name, {}))
        if plot is not None:
            return plot, [fit]
    return None


def fit_of(spec: FigureSpec, study: Study, select: Mapping[str, int]) -> Fit | None:
    """Whether a study has the data of a figure, and along which axes."""
    x = study.axis(spec.x)
    if spec.x != "time" and (x is None or not x.varies):
        return None
    family = None
    if spec.family is not None:
        axis = study.axis(spec.family)
        if axis is None or not axis.varies:
            return None
        family = Family.of(axis, _MOST_MEMBERS)
    place: dict[str, int] = {}
    for key, wanted in spec.at.items():
        value = study.value(key, select)
        axis = study.axis(key)
        if axis is not None and axis.holds(wanted):
            place[axis.name] = axis.nearest(wanted)
        elif axis is not None or value is None or not np.isclose(value, wanted, rtol=1e-6):
            return None
    if not all(study.has(panel.table, channel) for panel in spec.panels for channel in panel.channels):
        return None
    if spec.x == "time" and not study.histories:
        return None
    return Fit(study, x, family, place)


def _drawn(spec: FigureSpec, fit: Fit, select: Mapping[str, int]) -> Plot | None:
    place = {**select, **fit.place}
    view = View(fit.study, fit.family, place)
    panels: list[Panel] = []
    for panel in spec.panels:
        if spec.x == "time":
            made = in_time(view, panel.title, panel.channels)
        else:
            assert fit.x is not None
            made = over_axis(view, panel.title, panel.table, panel.channels, fit.x)
        if made is None:
            return None
        panels.append(made)
    plot = Plot(
        name=spec.name,
        heading=f"Fig. {spec.number}. {spec.heading}",
        caption=caption(fit.study, place, panels, fit.x, fit.family),
        panels=tuple(panels),
        legend=fit.family.legend if fit.family else ("", ""),
        study=fit.study.name,
    )
    return None if plot.empty else plot


def caption(
    study: Study,
    place: Mapping[str, int],
    panels: Sequence[Panel],
    x: StudyAxis | None,
    family: Family | None,
    also_shown: StudyAxis | None = None,
) -> str:
    """The study, where its other axes stand, and what the lines across the panels are."""
    sentences = [study.title]
    axes = (x, family.axis if family else None, also_shown)
    shown = {axis.name for axis in axes if axis is not None}
    held = [axis for axis in study.axes if axis.name not in shown]
    at = {**study.base, **place}
    if held:
        sentences.append("At " + ", ".join(held_at(axis, at[axis.name]) for axis in held))
    elif x is None and study.value("velocity", at) is not None and "velocity" not in shown:
        sentences.append(f"At {words.number(study.value('velocity', at) or 0)} m/s")
    if family is not None and len(family.members) < len(family.axis.values):
        sentences.append(f"{len(family.members)} of {len(family.axis.values)} curves")
    sentences += mark_words(panels)
    return ". ".join(sentence.rstrip(".") for sentence in sentences) + "."


def mark_words(panels: Sequence[Panel]) -> list[str]:
    """What the thin lines of these panels mean."""
    found = []
    lines = [mark for panel in panels for mark in panel.marks]
    if any(mark.label.startswith(marks.CRITICAL) for mark in lines):
        sides = {side for mark in lines for _, side in mark.values}
        how = " (right beam dashed, left beam dotted)" if len(sides) > 1 else ""
        found.append(f"Thin lines: critical velocities of Eq. (16){how}")
    if any(mark.label == marks.EXIT for mark in lines):
        found.append("Thin line: the train leaves the bridge")
    if any(mark.label.startswith(marks.RESONANCE) for mark in lines):
        sides = {side for mark in lines for _, side in mark.values}
        how = " (right beam dashed, left beam dotted)" if len(sides) > 1 else ""
        found.append(f"Thin lines: v_j,i = f_j D/i, where mode j is expected to resonate{how}")
    points = {points.label for panel in panels for points in panel.points}
    if marks.LIFT_OFF in points:
        found.append("Triangles: a wheel lifts off")
    if marks.PEAK in points:
        found.append("Circles: peaks that are found")
    limits = {limit.label for panel in panels for limit in panel.limits}
    if marks.ISO_2631[0].label in limits:
        found.append("ISO 2631 as quoted in the paper: 0.37 and 0.49 m/s² of body acceleration")
    if marks.EN_1990[0].label in limits:
        found.append("EN 1990, A2.4.4.2.1: at most 3.5 m/s² of a deck with ballast, 5.0 m/s² without")
    return found


def held_at(axis: StudyAxis, index: int) -> str:
    """An axis and its value in words: "car body mass m_c = 40 t"."""
    value = float(axis.lead.values[index])
    scale = words.scale(axis.lead.units, abs(value))
    head, gap, last = words.axis_words(axis.lead, axis.paths).rpartition(" ")
    # The symbol, the number and the unit stay on one line.
    end = f"{last} = {words.number(value / scale.factor)} {scale.unit}".strip()
    return head + gap + end.replace(" ", "\N{NO-BREAK SPACE}")


def _from_runs(spec: FigureSpec, studies: Sequence[Study]) -> tuple[Plot, list[Fit]] | None:
    """A figure whose curves come from several files; a panel that lacks one is left out."""
    panels, fits = [], []
    for panel in spec.panels:
        found = [(run, study) for run in panel.runs if (study := run_of(run, studies))]
        if len(found) == len(panel.runs):
            panels.append(_of_runs(panel, found))
            fits += [Fit(study, None, None, {}) for _, study in found]
    if not panels:
        return None
    text = ". ".join(["Right beam, the only one", *mark_words(panels)]) + "."
    plot = Plot(spec.name, f"Fig. {spec.number}. {spec.heading}", text, tuple(panels))
    return (plot, fits) if not plot.empty else None


def run_of(run: Run, studies: Sequence[Study]) -> Study | None:
    """The first study that has a history of the run's channel and whose case has the run's values."""
    for study in studies:
        if (
            study.case is None
            or not study.has("history", run.channel)
            or study.index({}) not in study.histories
        ):
            continue
        if all(_same(_lookup(study.case, key), value) for key, value in run.where.items()):
            return study
    return None


def _of_runs(panel: PanelSpec, found: Sequence[tuple[Run, Study]]) -> Panel:
    curves: list[Curve] = []
    exits: tuple[Mark, ...] = ()
    variable = found[0][1].variable("history", found[0][0].channel)
    assert variable is not None
    for k, (run, study) in enumerate(found):
        history = study.history({}, [run.channel])
        assert history is not None
        curves.append(Curve(run.label, history.time, history.values[0], k))
        exits = exits or View(study).marks(marks.leaving)
    y = Axis(words.quantity_of(variable), variable.units)
    end = min(float(curve.x[-1]) for curve in curves)
    return Panel(panel.title, TIME, y, tuple(curves), exits, shown=(0.0, end))


def _lookup(case: object, key: str) -> object:
    for word in key.split("."):
        case = getattr(case, word, None)
    return case


def _same(found: object, wanted: float | str) -> bool:
    if isinstance(wanted, str) or not isinstance(found, int | float):
        return found == wanted
    return bool(np.isclose(found, wanted, rtol=1e-6))
