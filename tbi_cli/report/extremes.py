"""The table of extremes of a study: for each channel the largest value, where it is, and what is near."""

from __future__ import annotations

import numpy as np

from tbi_cli.case import Case
from tbi_cli.report import marks, words
from tbi_cli.report.study import Study
from tbi_cli.report.table import Cell, Table
from tbi_cli.report.wishes import table_of


def extremes(study: Study) -> Table:
    """One row for each channel of the tables: largest value (of a force: largest push), its time, its place.

    Where velocity is swept, the nearest critical velocity of Eq. (16) stands beside it; a side's own channel
    is compared with its own beam.
    """
    velocity = study.axis("velocity")
    near = (
        velocity is not None
        and velocity.varies
        and study.case is not None
        and bool(marks.critical(study.case))
    )
    heads = ["channel", "what", "unit", "largest", "time [s]"]
    heads += [
        f"{axis.name}{'' if axis.dim.units == '1' else f' [{axis.dim.units}]'}" for axis in study.varied
    ]
    if near:
        heads += ["nearest critical velocity [m/s]", "mode", "beam"]
    critical: dict[tuple[object, ...], tuple[Cell, ...]] = {}
    rows: list[tuple[Cell, ...]] = []
    for variable in study.results.channels:
        values = study.table(table_of(variable), variable.name)
        if not np.isfinite(values).any():
            continue
        flat = int(np.nanargmax(values))
        at = dict(zip((a.name for a in study.axes), np.unravel_index(flat, values.shape), strict=True))
        place = {name: int(index) for name, index in at.items()}
        time = study.table("time_of_peak", variable.name).flat[flat]
        row: list[Cell] = [variable.name, words.full_name(variable), variable.units]
        row += [float(values.flat[flat]), float(time)]
        row += [float(axis.values[place[axis.name]]) for axis in study.varied]
        if near:
            side = marks.side_of([variable.name])
            key = (side, *place.values())
            if key not in critical:
                critical[key] = nearest_critical(study.case_at(place), side)
            row += critical[key]
        rows.append(tuple(row))
    return Table(
        name=f"extremes-{study.name}",
        heading=f"Extremes: {study.title}",
        columns=tuple(heads),
        rows=tuple(rows),
        note="Largest absolute values and their times; of forces the largest push, with the time of its peak."
        + (" Critical velocities: Eq. (16)." if near else ""),
    )


def nearest_critical(case: Case | None, side: str | None) -> tuple[Cell, ...]:
    """The critical velocity (m/s) nearest to the case's own, its mode and its beam; empty without any."""
    if case is None:
        return None, None, None
    found = [
        (abs(value - case.velocity), value, int(mark.label.removeprefix(marks.CRITICAL)), beam)
        for mark in marks.critical(case, side)
        for value, beam in mark.values
    ]
    if not found:
        return None, None, None
    _, value, mode, beam = min(found)
    return value, mode, beam
