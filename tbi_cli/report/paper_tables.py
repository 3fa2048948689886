"""Tables 2-5 of the paper, from results."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from tbi_cli.case import Bridge, Case
from tbi_cli.report.marks import axle_distance
from tbi_cli.report.solve_times import solve_seconds
from tbi_cli.report.study import Array, Study
from tbi_cli.report.table import Cell, Table
from tbi_cli.system.bridge import critical_velocities, natural_frequencies

_MODES = 4  # the paper lists the first four
_RMS_CHANNELS = (
    ("right_midspan", "mid-span deflection, right beam"),
    ("car_body_y", "car body displacement"),
)


@dataclass(frozen=True)
class TableSpec:
    """A table of the paper: how it is made of a study, and the built-in case that has its data."""

    number: int
    make: Callable[[Study], Table | None]
    case: str


def paper_tables(studies: Sequence[Study]) -> dict[int, tuple[Table, Study]]:
    """Each table from the first study that has its data, the least swept ones first, with that study."""
    order = sorted(studies, key=lambda study: len(study.varied))
    found: dict[int, tuple[Table, Study]] = {}
    for spec in TABLES:
        for study in order:
            table = spec.make(study)
            if table is not None:
                found[spec.number] = (table, study)
                break
    return found


def frequencies(study: Study) -> Table | None:
    """Table 2: natural frequencies (15) and critical velocities (16) of both beams of the base case."""
    case = study.case_at({})
    if case is None or case.bridge.left is None:
        return None
    rows: list[tuple[Cell, ...]] = []
    for side, hertz, velocities in _beams(case):
        rows.append((f"{side} beam", "natural frequency [Hz]", *hertz))
        # A train of several vehicles has no one d of Eq. (16).
        if any(velocities):
            rows.append((f"{side} beam", "critical velocity [m/s]", *velocities))
    heads = ("beam", "quantity", *(f"mode {j}" for j in range(1, _MODES + 1)))
    return Table(
        "table2", "Table 2. Natural frequencies and critical velocities", heads, tuple(rows), study.title
    )


def by_modes(study: Study) -> Table | None:
    """Table 3: RMS by number of modes, each with its change from one mode less."""
    axis = study.axis("modes")
    columns = (
        ("car_body_y", "car body displacement [m]"),
        ("car_body_y_acceleration", "car body acceleration [m/s2]"),
        ("right_midspan", "mid-span deflection, right beam [m]"),
    )
    if axis is None or not axis.varies or not all(study.has("rms", channel) for channel, _ in columns):
        return None
    cells: list[list[Cell]] = [[int(value) for value in axis.values]]
    heads = ["modes"]
    for channel, title in columns:
        rms = study.along("rms", channel, [axis], {})
        cells += [_cells(rms), [None, *_cells(100 * np.abs(np.diff(rms)) / rms[:-1])]]
        heads += [f"RMS of {title}", "change [%]"]
    return Table(
        "table3", "Table 3. RMS by number of beam modes", tuple(heads), _transposed(cells), study.title
    )


def by_sampling(study: Study) -> Table | None:
    """Table 4: RMS by sampling interval at each velocity, with the difference to the finest."""
    axis, velocity = study.axis("sampling"), study.axis("velocity")
    if axis is None or not axis.varies or not all(study.has("rms", channel) for channel, _ in _RMS_CHANNELS):
        return None
    order = np.arange(len(axis.values))[::-1]  # the finest last
    speeds = velocity.values if velocity is not None else np.array([study.value("velocity", {}) or np.nan])
    rows: list[tuple[Cell, ...]] = []
    for channel, title in _RMS_CHANNELS:
        for k, speed in enumerate(speeds):
            place = {velocity.name: k} if velocity is not None else {}
            rms = study.along("rms", channel, [axis], place)[order]
            away = 100 * np.abs(rms - rms[-1]) / rms[-1]
            seconds = [solve_seconds(study, {**place, axis.name: int(i)}) for i in order]
            rows += [
                (title, 3.6 * float(speed), float(axis.values[i]), took, float(r), float(d))
                for i, took, r, d in zip(order, seconds, rms, away, strict=True)
            ]
    note = f"{study.title}. Solution time: that of the run, shared by Runge-Kutta steps."
    heads = (
        "response",
        "velocity [km/h]",
        "sampling interval [s]",
        "solution time [s]",
        "RMS [m]",
        "difference to the finest [%]",
    )
    return Table("table4", "Table 4. RMS by sampling interval", heads, tuple(rows), note)


def by_span(study: Study) -> Table | None:
    """Table 5: critical velocities (16) of both beams for every span."""
    axis = study.axis("span")
    if axis is None or not axis.varies or study.case is None or study.case.bridge.left is None:
        return None
    rows: list[tuple[Cell, ...]] = []
    for k, span in enumerate(axis.values):
        case = study.case_at({axis.name: k})
        if case is not None:
            rows += [(float(span), f"{side} beam", *velocities) for side, _, velocities in _beams(case)]
    rows.sort(key=lambda row: str(row[1]))
    heads = ("span [m]", "beam", *(f"v_cr{j} [m/s]" for j in range(1, _MODES + 1)))
    return Table("table5", "Table 5. Critical velocities by span", heads, tuple(rows), study.title)


TABLES = (
    TableSpec(2, frequencies, "paper/constant-velocity"),
    TableSpec(3, by_modes, "paper/modes"),
    TableSpec(4, by_sampling, "paper/sampling"),
    TableSpec(5, by_span, "paper/velocity-spans"),
)


def _beams(case: Case) -> list[tuple[str, list[float], list[float]]]:
    """Each beam's first natural frequencies (Hz) and critical velocities (m/s), whatever the case's modes."""
    bridge: Bridge = case.bridge.replacing("modes", _MODES)
    distance = axle_distance(case)
    sides = (("right", bridge.right), ("left", bridge.left))
    return [
        (
            side,
            (natural_frequencies(bridge, beam) / (2 * np.pi)).tolist(),
            critical_velocities(bridge, beam, distance).tolist(),
        )
        for side, beam in sides
        if beam is not None
    ]


def _cells(values: Array) -> list[Cell]:
    return [float(value) for value in values]


def _transposed(columns: Sequence[Sequence[Cell]]) -> tuple[tuple[Cell, ...], ...]:
    return tuple(zip(*columns, strict=True))
