"""Envelopes along the span: the largest and smallest deflection, acceleration, moment and shear force."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from tbi_cli.case import Case
from tbi_cli.report.paper_figures import caption
from tbi_cli.report.plot import Array, Axis, Curve, Panel, Plot
from tbi_cli.report.resonance import SIDES
from tbi_cli.report.study import Study, StudyAxis

SPAN = Axis("distance from the beginning of the span", "m")
# Endings of the channels, what they are, and their units.
_QUANTITIES = (
    ("deflection", "deflection", "m"),
    ("acceleration", "acceleration", "m/s2"),
    ("moment", "bending moment", "N m"),
    ("shear", "shear force", "N"),
)
_ENDS = (("max", "largest"), ("min", "smallest"))


def envelope_figures(study: Study, select: Mapping[str, int]) -> Iterator[Plot]:
    """One figure: every quantity at the stations of both beams, of the worst speed where speeds are swept."""
    case = study.case_at(dict(select))
    if case is None or len(case.bridge.places) < 2:
        return
    velocity = study.axis("velocity")
    swept = velocity is not None and velocity.varies and velocity.name not in select
    panels = [
        panel
        for ending, words, units in _QUANTITIES
        if (panel := _panel(study, case, velocity if swept else None, select, ending, words, units))
    ]
    if not panels:
        return
    text = caption(study, select, panels, velocity if swept else None, None)
    if velocity is not None and swept:
        low, high = (f"{end:g}" for end in (velocity.values.min(), velocity.values.max()))
        text += f" Largest and smallest of all speeds from {low} to {high} m/s."
    text += " Deflections are positive upward, sagging moments are positive."
    if any("low-passed" in panel.y.label for panel in panels):
        text += " Accelerations are low-passed."
    yield Plot(f"{study.name}-envelopes", "Envelopes along the span", text, tuple(panels), study=study.name)


def _panel(
    study: Study,
    case: Case,
    velocity: StudyAxis | None,
    select: Mapping[str, int],
    ending: str,
    words: str,
    units: str,
) -> Panel | None:
    if study.has("max", f"right_station_1_{ending}_low_pass"):
        ending, words = f"{ending}_low_pass", f"low-passed {words}"
    x = np.array(case.bridge.places)
    order = np.argsort(x, kind="stable")
    found = {
        (side, table): values[order]
        for side in SIDES
        for table, _ in _ENDS
        if (values := _along_span(study, table, side, ending, len(x), velocity, select)) is not None
    }
    sides = [side for side in SIDES if (side, "max") in found]
    alike = len(sides) == 2 and all(
        np.allclose(found["right", table], found["left", table], rtol=1e-9, atol=0, equal_nan=True)
        for table, _ in _ENDS
    )
    if not sides:
        return None
    edge = 0.02 * case.bridge.length  # room for the markers
    curves: list[Curve] = []
    for side in sides[:1] if alike else sides:
        of = "" if len(sides) == 1 else ", both beams" if alike else f", {side} beam"
        for table, name in _ENDS:
            curves.append(Curve(name + of, x[order], found[side, table], len(curves)))
    return Panel(words, SPAN, Axis(words, units), tuple(curves), shown=(-edge, case.bridge.length + edge))


def _along_span(
    study: Study,
    table: str,
    side: str,
    ending: str,
    count: int,
    velocity: StudyAxis | None,
    select: Mapping[str, int],
) -> Array | None:
    """The extremes at all stations of a beam, over all speeds of an axis; None without any."""
    names = [f"{side}_station_{k + 1}_{ending}" for k in range(count)]
    if not all(study.has(table, name) for name in names):
        return None
    axes = [velocity] if velocity else []
    values = np.array([np.atleast_1d(study.along(table, name, axes, select)) for name in names])
    over = np.fmax if table == "max" else np.fmin
    extremes: Array = over.reduce(values, axis=1)
    return extremes
