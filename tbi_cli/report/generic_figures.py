"""Figures of any study: curves over the last axis, a family for the second, small multiples for a third."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from tbi_cli.case import AxleForces, Consist, HslmA
from tbi_cli.report import words
from tbi_cli.report.heat import heat_panel
from tbi_cli.report.panels import Family, View, in_time, over_axis
from tbi_cli.report.paper_figures import caption, held_at
from tbi_cli.report.plot import HeatPanel, Panel, Plot
from tbi_cli.report.study import Study, StudyAxis
from tbi_cli.report.wishes import NONE, TIME, Channel, Wishes, channels_like

_MOST_CURVES, _MOST_PANELS = 8, 12
_OF_BRIDGE = re.compile(r"_(midspan|station_[0-9]+)(_|$)")
# What most people look at first, where the vehicle has it; each a figure of panels.
_GROUPS: Mapping[str, tuple[str, ...]] = {
    "displacement": ("car_body_y", "car_body_z"),
    "rotation": ("car_body_pitch", "car_body_roll"),
    "acceleration": ("car_body_y_acceleration", "car_body_z_acceleration"),
    "sprung-mass": ("sprung_mass_y", "sprung_mass_y_acceleration"),
    "beam": ("beam_y", "beam_pitch", "beam_y_acceleration", "beam_pitch_acceleration"),
    "midspan": ("right_midspan", "left_midspan"),
    "midspan-acceleration": ("right_midspan_acceleration", "left_midspan_acceleration"),
    "amplification": ("daf/right", "daf/left"),
    "forces": ("car_body_force", "front_bogie_force", "rear_bogie_force"),
}


@dataclass(frozen=True)
class Arrangement:
    """Which axis of a study is where: x (None: time), family of curves, small multiples; the rest is held."""

    study: Study
    x: StudyAxis | None
    family: StudyAxis | None
    multiples: StudyAxis | None
    place: Mapping[str, int]

    def panel_places(self) -> list[dict[str, int]]:
        """The place of each small multiple; one place if there are none."""
        if self.multiples is None:
            return [dict(self.place)]
        members = Family.of(self.multiples, _MOST_PANELS).members
        return [{**self.place, self.multiples.name: member} for member in members]


def generic_figures(study: Study, wishes: Wishes, select: Mapping[str, int]) -> Iterator[Plot]:
    """The figures of one study; none if it lacks the axes or channels asked for."""
    for arrangement in _arrangements(study, wishes, select):
        for name, channels in groups(study, wishes).items():
            if arrangement.multiples is not None:
                figures = [(_group_name(name, channel), [(table, channel)]) for table, channel in channels]
            else:
                figures = [(name, channels)]
            for group, members in figures:
                plot = _figure(arrangement, group, members, wishes.heat_map)
                if plot is not None and not plot.empty:
                    yield plot


def _arrangements(study: Study, wishes: Wishes, select: Mapping[str, int]) -> Iterator[Arrangement]:
    free = [axis for axis in study.varied if axis.name not in select]
    if wishes.x not in (None, TIME):
        x = study.axis(wishes.x or "")
        if x is not None and x.varies:
            yield _arranged(study, x, free, wishes, select)
        return
    if free and wishes.x is None:
        yield _arranged(study, free[-1], free, wishes, select)
    if study.histories and not wishes.heat_map and (wishes.x == TIME or len(study.histories) <= _MOST_CURVES):
        yield _arranged(study, None, free, wishes, select)


def _arranged(
    study: Study, x: StudyAxis | None, free: Sequence[StudyAxis], wishes: Wishes, select: Mapping[str, int]
) -> Arrangement:
    rest = [axis for axis in free if x is None or axis.name != x.name]
    family: StudyAxis | None = rest[-1] if rest else None
    if wishes.family == NONE:
        family = None
    elif wishes.family is not None:
        wanted = study.axis(wishes.family)
        family = wanted if wanted in rest else family
    rest = [axis for axis in rest if family is None or axis.name != family.name]
    multiples = rest[-1] if rest and wishes.family != NONE else None
    return Arrangement(study, x, family, multiples, select)


def groups(study: Study, wishes: Wishes) -> dict[str, list[Channel]]:
    """The channels to draw, by figure: those asked for, one each; else what most people look at first."""
    if wishes.channels:
        asked = dict.fromkeys(c for pattern in wishes.channels for c in channels_like(study, pattern))
        return {
            channel if table in ("peak", "max") else f"{table}-{channel}": [(table, channel)]
            for table, channel in asked
        }
    groups = {
        name: [found for pattern in patterns for found in channels_like(study, pattern)]
        for name, patterns in _GROUPS.items()
    }
    if study.case is not None and isinstance(study.case.train, Consist | HslmA | AxleForces):
        # A whole train never stands at mid-span, as the paper's factor has it.
        groups["amplification"] = [(table, f"{name}_static") for table, name in groups["amplification"]]
    groups = {name: channels for name, channels in groups.items() if channels}
    if not set(groups) - {"midspan", "midspan-acceleration", "amplification"}:
        of_vehicle = (v.name for v in study.results.channels if not _OF_BRIDGE.search(v.name))
        first = list(of_vehicle)[:4]
        others = [found for name in first for found in channels_like(study, name)]
        groups = ({"vehicle": others} if others else {}) | groups
    return groups


def _group_name(group: str, channel: str) -> str:
    return group if channel in group else f"{group}-{channel}"


def _figure(at: Arrangement, name: str, channels: Sequence[Channel], heat: bool) -> Plot | None:
    family = Family.of(at.family, _MOST_CURVES) if at.family else None
    panels: list[Panel | HeatPanel] = []
    for place in at.panel_places():
        for table, channel in channels:
            panel: Panel | HeatPanel | None
            title = _title(at, place, table, channel)
            if heat:
                if at.x is None or at.family is None:
                    return None
                panel = heat_panel(at.study, title, table, channel, at.x, at.family, place)
            elif at.x is None:
                panel = in_time(View(at.study, family, place), title, [channel]) if table != "daf" else None
            else:
                panel = over_axis(View(at.study, family, place), title, table, [channel], at.x)
            if panel is not None:
                panels.append(panel)
    if not panels:
        return None
    kind = "heat-" if heat else "time-" if at.x is None else ""
    curves = [panel for panel in panels if isinstance(panel, Panel)]
    shown = Family(at.family, tuple(range(len(at.family.values)))) if heat and at.family else family
    text = caption(at.study, at.place, curves, at.x, shown, also_shown=at.multiples)
    if heat and any(isinstance(panel, HeatPanel) and panel.lines for panel in panels):
        text += " Lines: critical velocities of Eq. (16), right beam dashed, left beam dotted."
    variables = [v for table, channel in channels if (v := at.study.variable(table, channel))]
    return Plot(
        name=f"{at.study.name}-{kind}{name}",
        heading=words.capital(", ".join(words.full_name(variable) for variable in variables)),
        caption=text,
        panels=tuple(panels),
        legend=family.legend if family and not heat else ("", ""),
        study=at.study.name,
    )


def _title(at: Arrangement, place: Mapping[str, int], table: str, channel: str) -> str:
    """A small multiple is named by its value, any other panel by its channel."""
    if at.multiples is not None:
        return held_at(at.multiples, place[at.multiples.name])
    variable = at.study.variable(table, channel)
    return words.full_name(variable) if variable else channel
