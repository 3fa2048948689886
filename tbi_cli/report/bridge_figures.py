"""What a bridge engineer reads off: the deck over speed, with limits and resonances, and stations in time."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tbi_cli.case import AxleForces, Case, Consist, HslmA
from tbi_cli.report import marks
from tbi_cli.report.ensembles import seeds_of
from tbi_cli.report.panels import Family, View, in_time, over_axis
from tbi_cli.report.paper_figures import caption, held_at
from tbi_cli.report.plot import Axis, Curve, Panel, Plot
from tbi_cli.report.resonance import SIDES, expected, midspan_channels, peak_points, repeats
from tbi_cli.report.study import Study, StudyAxis

QUANTITIES = ("deflection", "acceleration")
_MOST_CURVES = 10
_DECKS, _TRAINS = 4, 12  # panels in a figure
_IN_TIME = ("deflection", "acceleration", "acceleration_low_pass", "moment", "shear")


def of_bridge(case: Case | None) -> bool:
    """Whether a case asks for the bridge rather than for one vehicle on it."""
    if case is None:
        return False
    whole = isinstance(case.train, Consist | HslmA | AxleForces)
    return whole or case.bridge.low_pass != "none" or bool(case.bridge.places)


@dataclass(frozen=True)
class Sweep:
    """How a sweep over velocity is laid out: a curve for each train, a panel for each bridge."""

    study: Study
    velocity: StudyAxis
    trains: Family | None
    bridges: StudyAxis | None
    place: Mapping[str, int]

    @property
    def sides(self) -> tuple[str, ...]:
        """The beams; one for two that do the same."""
        names = [side for side in SIDES if self.study.has("peak", f"{side}_midspan")]
        tables = [self.study.table("peak", f"{side}_midspan") for side in names]
        alike = len(tables) == 2 and np.allclose(tables[0], tables[1], rtol=1e-9, atol=0, equal_nan=True)
        return tuple(names[:1] if alike else names)

    def side_words(self, side: str) -> str:
        """What a beam is called where there are two."""
        if len(self.sides) == 2:
            return f"{side} beam"
        return "both beams" if self.study.has("peak", "left_midspan") else ""


def bridge_figures(study: Study, select: Mapping[str, int]) -> Iterator[Plot]:
    """Acceleration and deflection of the deck over speed, resonances of each train, stations in time."""
    if not of_bridge(study.case):
        return
    sweep = _sweep(study, select)
    if sweep is not None:
        yield from _deck(sweep)
        if sweep.trains is not None and repeats(study.case):
            yield from _resonances(sweep, sweep.trains)
    yield from _stations_in_time(study, select)


def _sweep(study: Study, select: Mapping[str, int]) -> Sweep | None:
    velocity, seeds = study.axis("velocity"), seeds_of(study)
    free = [axis for axis in study.varied if axis.name not in select]
    if velocity not in free or velocity is None or (seeds is not None and seeds in free):
        return None
    free.remove(velocity)
    of_train = [axis for axis in free if all(path.startswith("train.") for path in axis.paths)]
    family = (of_train or free)[-1] if free else None
    rest = [axis for axis in free if axis is not family]
    trains = Family.of(family, _MOST_CURVES) if family else None
    return Sweep(study, velocity, trains, rest[-1] if rest else None, select)


def _deck(sweep: Sweep) -> Iterator[Plot]:
    """Both quantities in one figure, or figures of their own with a panel for each bridge."""
    if sweep.bridges is None:
        panels = _over_speed(sweep, QUANTITIES, sweep.place)
        yield _plot(sweep, "deck", "Deck at mid-span over speed", panels, sweep.trains)
        return
    members = Family.of(sweep.bridges, 4 * _DECKS).members
    for quantity in QUANTITIES[::-1]:
        panels = []
        for member in members:
            name = held_at(sweep.bridges, member)
            found = _over_speed(sweep, (quantity,), {**sweep.place, sweep.bridges.name: member})
            panels += [replace(panel, title=_after(name, panel.title)) for panel in found]
        heading = f"{quantity.capitalize()} of the deck at mid-span over speed"
        yield from _in_parts(sweep, f"deck-{quantity}", heading, panels, sweep.trains, _DECKS)


def _over_speed(sweep: Sweep, quantities: Sequence[str], place: Mapping[str, int]) -> list[Panel]:
    """A panel for each quantity: a curve for each train, or else for each beam with its resonances."""
    made: list[Panel] = []
    view = View(sweep.study, sweep.trains, place)
    for quantity in quantities:
        channels = {side: _channel(sweep.study, side, quantity) for side in sweep.sides}
        if sweep.trains is None:
            title = quantity if len(channels) > 1 else _after(quantity, sweep.side_words(sweep.sides[0]))
            found = over_axis(view, title, "peak", list(channels.values()), sweep.velocity)
            if found is not None:
                curves = [replace(c, label=sweep.side_words(s) or c.label) for s, c in _beside(sweep, found)]
                made.append(_with_resonances(sweep, _finished(sweep, found, quantity, curves), place))
            continue
        for side, channel in channels.items():
            found = over_axis(view, sweep.side_words(side), "peak", [channel], sweep.velocity)
            if found is not None:
                curves = [replace(curve, label=_train(sweep, curve.label)) for curve in found.curves]
                title = sweep.side_words(side) if sweep.bridges else _after(quantity, sweep.side_words(side))
                panel = replace(found, title=title, marks=())
                made.append(_finished(sweep, panel, quantity, curves))
    return made


def _beside(sweep: Sweep, panel: Panel) -> Iterator[tuple[str, Curve]]:
    yield from zip(sweep.sides, panel.curves, strict=True)


def _finished(sweep: Sweep, panel: Panel, quantity: str, curves: Sequence[Curve]) -> Panel:
    """A panel with the name of its quantity, and with the limits of accelerations."""
    if quantity == "deflection":
        return replace(panel, curves=tuple(curves), y=Axis("largest deflection", panel.y.units))
    label = "low-passed acceleration" if _filtered(sweep.study) else "largest acceleration"
    return replace(panel, curves=tuple(curves), y=Axis(label, panel.y.units), limits=marks.EN_1990)


def _with_resonances(sweep: Sweep, panel: Panel, place: Mapping[str, int]) -> Panel:
    """Where resonance is expected as lines, and where it is found as points, of a train that repeats."""
    case = sweep.study.case_at(dict(place))
    if not repeats(case):
        return panel
    ends = float(sweep.velocity.values.min()), float(sweep.velocity.values.max())
    lines = marks.within(expected(case, sweep.sides[0] if len(sweep.sides) == 1 else None), *ends)
    return replace(panel, marks=lines, points=tuple(peak_points(curve) for curve in panel.curves))


def _resonances(sweep: Sweep, trains: Family) -> Iterator[Plot]:
    """A panel for each train, on the bridge of the base case."""
    for quantity in QUANTITIES[::-1]:
        panels = []
        for member in trains.members:
            place = {**sweep.place, trains.axis.name: member}
            label = _train(sweep, trains.label(member))
            for found in _over_speed(replace(sweep, trains=None), (quantity,), place):
                name = f"HSLM-{label}" if _is_hslm(sweep) else held_at(trains.axis, member)
                panels.append(replace(found, title=name, limits=()))
        heading = f"Resonance of each train: {quantity} at mid-span"
        yield from _in_parts(
            sweep, f"resonance-{quantity}", heading, panels, None, _TRAINS, also_shown=trains.axis
        )


def _in_parts(
    sweep: Sweep,
    name: str,
    heading: str,
    panels: Sequence[Panel],
    family: Family | None,
    most: int,
    also_shown: StudyAxis | None = None,
) -> Iterator[Plot]:
    """The panels in as many figures of nearly equal size as it takes."""
    count = -(-len(panels) // most)
    size = -(-len(panels) // max(count, 1))
    for k in range(count):
        some = panels[k * size : (k + 1) * size]
        part = f"-{k + 1}" if count > 1 else ""
        of_all = f" ({k + 1} of {count})" if count > 1 else ""
        yield _plot(sweep, name + part, heading + of_all, some, family, also_shown or sweep.bridges)


def _plot(
    sweep: Sweep,
    name: str,
    heading: str,
    panels: Sequence[Panel],
    family: Family | None,
    also_shown: StudyAxis | None = None,
) -> Plot:
    study = sweep.study
    text = caption(study, sweep.place, panels, sweep.velocity, family, also_shown)
    if any("low-passed" in panel.y.label for panel in panels):
        text += f" {_filter_words(study)}"
    legend = family.legend if family else ("", "")
    if family and _is_hslm(sweep):
        legend = ("train HSLM-A", "")
    return Plot(f"{study.name}-{name}", heading, text, tuple(panels), legend, study.name)


def _channel(study: Study, side: str, quantity: str) -> str:
    return midspan_channels(study, side)[QUANTITIES.index(quantity)]


def _filtered(study: Study) -> bool:
    return _channel(study, "right", "acceleration").endswith("_low_pass")


def _filter_words(study: Study) -> str:
    assert study.case is not None
    cut_off = study.case.bridge.low_pass
    if cut_off == "en-1990":
        return "Accelerations up to 30 Hz, 1.5 f₁ or f₃, the largest, as EN 1990, A2.4.4.2.1 has it."
    return f"Accelerations up to {cut_off:g} Hz."


def _is_hslm(sweep: Sweep) -> bool:
    return sweep.trains is not None and sweep.trains.axis.paths == frozenset({"train.number"})


def _train(sweep: Sweep, label: str) -> str:
    """The label of a train: HSLM-A1 to -A10 by their names."""
    return f"A{label}" if _is_hslm(sweep) else label


def _after(first: str, second: str) -> str:
    return f"{first}, {second}" if second else first


def _place(study: Study, panel: Panel) -> str:
    """Which station a panel of one curve shows: " of the right beam at 10 m", of a single beam " at 10 m"."""
    if len(panel.curves) > 1:
        return ""
    label = panel.curves[0].label.replace(" m", "\N{NO-BREAK SPACE}m")
    single = study.case is not None and study.case.bridge.left is None
    return f" {label.partition('beam ')[2]}" if single else f" of the {label}"


def _stations_in_time(study: Study, select: Mapping[str, int]) -> Iterator[Plot]:
    """The histories of stations that the file has, quantity by quantity, a curve for each station."""
    if study.index(select) not in study.histories:
        return
    names = [v.name for v in study.results.history_channels if "_station_" in v.name]
    panels = []
    for quantity in _IN_TIME:
        channels = [n for n in names if re.fullmatch(rf".*_station_[0-9]+_{quantity}", n)][:_MOST_CURVES]
        panel = in_time(View(study, None, select), "", channels) if channels else None
        if panel is not None:
            panels.append(replace(panel, title=panel.y.label + _place(study, panel)))
    if panels:
        text = caption(study, select, panels, None, None)
        heading = "Along the span, in time"
        yield Plot(f"{study.name}-time-stations", heading, text, tuple(panels), study=study.name)
