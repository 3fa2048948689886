"""Ensembles: what many realisations of the rails make of a channel, as bands and as a table."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tbi_cli.report import marks, words
from tbi_cli.report.generic_figures import groups
from tbi_cli.report.panels import axis_of
from tbi_cli.report.paper_figures import held_at, mark_words
from tbi_cli.report.plot import TIME, Array, Axis, Band, Curve, Mark, Panel, Plot
from tbi_cli.report.study import Study, StudyAxis
from tbi_cli.report.table import Cell, Table
from tbi_cli.report.wishes import Channel, Wishes, channels_like

SEED = "seed"
PERCENTILES = (5.0, 50.0, 95.0)
# Looked at beside what is looked at first in any study, where they are there: the contact.
_CONTACT = {
    "wheel-forces": ("wheel_1_right_force", "min/wheel_1_right_force"),
    "contact": ("wheel_1_right_unloading", "wheel_1_right_time_aloft"),
}
_MOST_HISTORIES = 200


@dataclass(frozen=True, eq=False)
class Statistics:
    """Mean, standard deviation and percentiles over the realisations, each (n,); NaN where none is there."""

    mean: Array
    deviation: Array
    percentiles: Array

    @classmethod
    def of(cls, values: Array) -> Statistics:
        """Of values (realisations, n), without those that are not finite; deviation: of a sample, n - 1."""
        known = np.isfinite(values)
        count = known.sum(axis=0)
        enough = count > 0
        kept = np.where(known, values, 0.0)
        mean = np.where(enough, kept.sum(axis=0) / np.maximum(count, 1), np.nan)
        square = np.where(known, (values - mean) ** 2, 0.0).sum(axis=0)
        deviation = np.where(enough, np.sqrt(square / np.maximum(count - 1, 1)), np.nan)
        percentiles = np.full((len(PERCENTILES), values.shape[1]), np.nan)
        if enough.any():
            percentiles[:, enough] = np.nanpercentile(values[:, enough], PERCENTILES, axis=0)
        return cls(mean, deviation, percentiles)

    def panel(self, title: str, x: Axis, places: Array, y: Axis) -> Panel:
        """Mean and median as curves, the spread as two bands."""
        low, median, high = self.percentiles
        sigma = (self.mean - self.deviation, self.mean + self.deviation)
        return Panel(
            title=title,
            x=x,
            y=y,
            curves=(Curve("mean", places, self.mean, 0), Curve("median", places, median, 1)),
            bands=(
                Band("5 to 95 % of the realisations", places, low, high, 0, 0),
                Band("mean ± standard deviation", places, *sigma, 0, 1),
            ),
        )


def seeds_of(study: Study) -> StudyAxis | None:
    """The axis of the realisations, if there are several."""
    axis = study.axis(SEED)
    return axis if axis is not None and axis.varies else None


def ensemble_figures(study: Study, wishes: Wishes, select: Mapping[str, int]) -> Iterator[Plot]:
    """Over the last axis besides the seeds, or else how the realisations spread; and over time."""
    seeds = seeds_of(study)
    if seeds is None or seeds.name in select:
        return
    free = [axis for axis in study.varied if axis.name not in (*select, seeds.name)]
    wanted = study.axis(wishes.x) if wishes.x else None
    x = wanted if wanted in free else free[-1] if free else None
    for name, channels in _groups(study, wishes).items():
        panels = [panel for table, c in channels if (panel := _panel(study, seeds, x, table, c, select))]
        if panels:
            yield _plot(study, seeds, x, f"ensemble-{name}", channels, panels, select)
    if len(study.histories) > 1:
        yield from _in_time(study, seeds, wishes, select)


def _groups(study: Study, wishes: Wishes) -> dict[str, list[Channel]]:
    found = groups(study, wishes)
    if not wishes.channels:
        for name, patterns in _CONTACT.items():
            channels = [channel for pattern in patterns for channel in channels_like(study, pattern)]
            found |= {name: channels} if channels else {}
    return found


def _panel(
    study: Study, seeds: StudyAxis, x: StudyAxis | None, table: str, channel: str, place: Mapping[str, int]
) -> Panel | None:
    variable = study.variable(table, channel)
    if variable is None:
        return None
    quantity = "dynamic amplification factor" if table == "daf" else words.quantity_of(variable)
    y = Axis(words.of_table(table, quantity), variable.units)
    title = words.full_name(variable)
    if x is not None:
        values = study.along(table, channel, [seeds, x], place)
        panel = Statistics.of(values).panel(title, axis_of(x), x.values, y)
        known = np.isfinite(panel.curves[0].y).any()
        return _marked(study, panel, x, table, channel, place) if known else None
    values = np.sort(study.along(table, channel, [seeds], place))
    values = values[np.isfinite(values)]
    if not len(values) or not np.ptp(values) > 0:
        return None
    share = (np.arange(len(values)) + 0.5) / len(values)
    mean = float(values.mean())
    curve = Curve("realisations", values, share, 0)
    shares = Axis("share of the realisations below", "1")
    return Panel(title, y, shares, (curve,), marks=(Mark("mean", ((mean, ""),)),), from_zero=True)


def _marked(
    study: Study, panel: Panel, x: StudyAxis, table: str, channel: str, place: Mapping[str, int]
) -> Panel:
    """The panel with critical velocities and comfort limits, as a study without seeds has them."""
    case = study.case_at(place) if x.paths == frozenset({"velocity"}) else None
    lines = marks.critical(case, marks.side_of([channel])) if case else []
    return replace(
        panel,
        marks=marks.within(lines, float(x.values.min()), float(x.values.max())),
        limits=marks.limits([channel]) if table in ("peak", "max", "rms") else (),
    )


def _in_time(study: Study, seeds: StudyAxis, wishes: Wishes, select: Mapping[str, int]) -> Iterator[Plot]:
    """The histories of all realisations at one place of the other axes, channel by channel."""
    channels = [v.name for v in study.results.history_channels]
    if wishes.channels:
        asked = {c for pattern in wishes.channels for _, c in channels_like(study, pattern)}
        channels = [name for name in channels if name in asked]
    for channel in channels[:12]:
        variable = study.variable("history", channel)
        found = [
            history
            for member in range(min(len(seeds.values), _MOST_HISTORIES))
            if (history := study.history({**select, seeds.name: member}, [channel])) is not None
        ]
        if variable is None or len(found) < 2 or any(len(h.time) != len(found[0].time) for h in found):
            continue
        values = np.array([history.values[0] for history in found])
        y = Axis(words.quantity_of(variable), variable.units)
        panel = Statistics.of(values).panel(words.full_name(variable), TIME, found[0].time, y)
        panel = replace(panel, limits=marks.limits([channel]))
        yield _plot(study, seeds, None, f"ensemble-time-{channel}", [("history", channel)], [panel], select)


def _plot(
    study: Study,
    seeds: StudyAxis,
    x: StudyAxis | None,
    name: str,
    channels: Sequence[Channel],
    panels: Sequence[Panel],
    select: Mapping[str, int],
) -> Plot:
    variables = [v for table, channel in channels if (v := study.variable(table, channel))]
    held = [axis for axis in study.varied if axis is not seeds and axis is not x]
    at = {**study.base, **select}
    sentences = [study.title, f"{len(seeds.values)} realisations of the rails"]
    if held:
        sentences.append("At " + ", ".join(held_at(axis, at[axis.name]) for axis in held))
    if any(panel.bands for panel in panels):
        sentences.append("Bands: 5 to 95 % of the realisations, and their mean ± standard deviation")
    return Plot(
        name=f"{study.name}-{name}",
        heading=words.capital(", ".join(words.full_name(variable) for variable in variables)),
        caption=". ".join((*sentences, *mark_words(panels))) + ".",
        panels=tuple(panels),
        study=study.name,
    )


def ensemble_table(study: Study) -> Table | None:
    """For each channel and each place of the other axes: mean, standard deviation, percentiles, ends."""
    seeds = seeds_of(study)
    if seeds is None:
        return None
    others = [axis for axis in study.varied if axis is not seeds]
    heads = ["channel", "unit", *(_head(axis) for axis in others), "realisations", "mean"]
    heads += ["standard deviation", *(f"{p:g} %" for p in PERCENTILES), "smallest", "largest"]
    rows: list[tuple[Cell, ...]] = []
    for variable in study.results.channels:
        values = study.along("peak", variable.name, [seeds, *others], {})
        flat = values.reshape(len(seeds.values), -1)
        found = Statistics.of(flat)
        counts = np.isfinite(flat).sum(axis=0)
        for k in np.flatnonzero(counts):
            at = np.unravel_index(int(k), values.shape[1:]) if others else ()
            where = [float(axis.values[i]) for axis, i in zip(others, at, strict=True)]
            numbers = [found.mean[k], found.deviation[k], *found.percentiles[:, k]]
            ends = [np.nanmin(flat[:, k]), np.nanmax(flat[:, k])]
            row: list[Cell] = [variable.name, variable.units, *where, int(counts[k])]
            rows.append((*row, *(float(number) for number in (*numbers, *ends))))
    return Table(
        name=f"ensemble-{study.name}",
        heading=f"Ensemble: {study.title}",
        columns=tuple(heads),
        rows=tuple(rows),
        note="Of the largest absolute value in each realisation.",
    )


def _head(axis: StudyAxis) -> str:
    return axis.name if axis.dim.units == "1" else f"{axis.name} [{axis.dim.units}]"
