"""Resonance with a train that repeats itself: where it is expected, v = f_j D/i, and where it is found."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import product

import numpy as np
from numpy.typing import NDArray

from tbi_cli.case import Case, Consist, HslmA, MovingLoad
from tbi_cli.report import marks
from tbi_cli.report.plot import Array, Curve, Mark, Points
from tbi_cli.report.study import Study, StudyAxis
from tbi_cli.report.table import Cell, Table
from tbi_cli.system.resonance import repeats_after, resonant_speeds

SIDES = ("right", "left")
# A peak stands out if one has to go down from it by this share of the largest value to get higher.
_STANDS_OUT = 0.03
_NEAR = 0.1  # a peak is near an expected speed within this share of it
_MOST_PLACES = 200


def repeats(case: Case | None) -> bool:
    """Whether several equal vehicles of a train follow each other, or its forces repeat themselves."""
    return (
        case is not None
        and isinstance(case.train, Consist | HslmA | MovingLoad)
        and bool(repeats_after(case))
    )


def expected(case: Case | None, side: str | None = None) -> list[Mark]:
    """A mark for mode j and part i at v = f_j D/i of the beams; none of a train that repeats nothing.

    Modes of even number are left out: they have a node at mid-span.  `side` keeps to one of the beams; where
    both have the same speed, it is marked once.
    """
    if case is None or not repeats(case):
        return []
    found: dict[tuple[int, int], dict[str, list[float]]] = {}
    for beam, mode, part, speed in resonant_speeds(case):
        if mode % 2 and side in (None, beam):
            found.setdefault((mode, part), {}).setdefault(beam, []).append(speed)
    made = []
    for (mode, part), speeds in sorted(found.items()):
        for together in zip(*speeds.values(), strict=True):
            values = tuple(zip(together, speeds, strict=True))
            if np.allclose(together, together[0], rtol=1e-9):
                values = ((together[0], ""),)
            made.append(Mark(f"{marks.RESONANCE}{mode},{part}", values))
    return made


def peaks(values: Array) -> NDArray[np.int64]:
    """The indices of the local maxima that stand out; what is not finite is passed over."""
    from scipy.signal import find_peaks

    known = np.flatnonzero(np.isfinite(values))
    if len(known) < 3:
        return known[:0]
    found, _ = find_peaks(values[known], prominence=_STANDS_OUT * float(np.max(values[known])))
    return np.asarray(known[found], dtype=np.int64)


def peak_points(curve: Curve) -> Points:
    """The local maxima of a curve that stand out."""
    at = peaks(curve.y)
    return Points(marks.PEAK, curve.x[at], curve.y[at], curve.place)


def midspan_channels(study: Study, side: str) -> tuple[str, str]:
    """The channels of deflection and of acceleration at mid-span, the low-passed one where it is there."""
    filtered = f"{side}_midspan_acceleration_low_pass"
    plain = f"{side}_midspan_acceleration"
    return f"{side}_midspan", filtered if study.has("peak", filtered) else plain


def resonance_table(study: Study, select: Mapping[str, int]) -> Table | None:
    """For each train and bridge of a sweep over velocity: the expected speeds, and the peaks near them."""
    velocity = study.axis("velocity")
    if velocity is None or not velocity.varies or velocity.name in select or not repeats(study.case):
        return None
    others = [axis for axis in study.varied if axis is not velocity and axis.name not in select]
    if np.prod([len(axis.values) for axis in others]) > _MOST_PLACES:
        others = []
    rows: list[tuple[Cell, ...]] = []
    for indices in product(*(range(len(axis.values)) for axis in others)):
        place = {**select, **dict(zip((axis.name for axis in others), indices, strict=True))}
        where = [float(axis.lead.values[k]) for axis, k in zip(others, indices, strict=True)]
        rows += [(*where, *row) for row in _rows(study, velocity, place)]
    if not rows:
        return None
    heads = [axis.lead.name + ("" if axis.lead.units == "1" else f" [{axis.lead.units}]") for axis in others]
    return Table(
        name=f"resonance-{study.name}",
        heading=f"Resonance: {study.title}",
        columns=(*heads, *_HEADS),
        rows=tuple(rows),
        note="Expected: f_j D/i, with i periods of mode j from one coach of length D to the next; of a list "
        "of forces, D is the longest strong wave of its spectrum. Found: "
        "where the largest value at mid-span peaks over speed, within 10 % and near no other expected speed. "
        "Modes of even number have a node at mid-span.",
    )


_HEADS = (
    "beam", "mode j", "part i", "expected [m/s]",
    "deflection peaks at [m/s]", "difference [m/s]", "acceleration peaks at [m/s]", "difference [m/s]",
)  # fmt: skip


def _rows(study: Study, velocity: StudyAxis, place: Mapping[str, int]) -> Iterator[tuple[Cell, ...]]:
    """The rows of one train and bridge: beam by beam, mode by mode."""
    ends = float(velocity.values.min()), float(velocity.values.max())
    for side in SIDES:
        channels = midspan_channels(study, side)
        if not all(study.has("peak", channel) for channel in channels):
            continue
        found = [velocity.values[peaks(study.along("peak", c, [velocity], place))] for c in channels]
        lines = marks.within(expected(study.case_at(place), side), *ends)
        every = np.array([speed for mark in lines for speed, _ in mark.values])
        for mark in lines:
            mode, _, part = mark.label.removeprefix(marks.RESONANCE).partition(",")
            for speed, _ in mark.values:
                row: list[Cell] = [side, int(mode), int(part), speed]
                for peak in found:
                    nearest = _belonging(speed, every, peak)
                    row += [nearest, None if nearest is None else nearest - speed]
                yield tuple(row)


def _belonging(speed: float, every: Array, found: Array) -> float | None:
    """The peak found nearest to an expected speed, of those to which no other expected speed is nearer."""
    own = [
        float(peak)
        for peak in found
        if abs(peak - speed) <= min(float(np.min(np.abs(peak - every))), _NEAR * speed)
    ]
    return min(own, key=lambda peak: abs(peak - speed), default=None)
