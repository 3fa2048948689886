"""How a number of the paper is read from results: each kind of `read:` in claims.yaml, one function.

A reading is a number, a list of numbers, or None where the results do not have it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from scipy.signal import find_peaks

from tbi_cli.report.evidence import BASE, Curve, Evidence, si
from tbi_cli.report.marks import axle_distance
from tbi_cli.report.solve_times import solve_seconds
from tbi_cli.system.bridge import critical_velocities, natural_frequencies

Number = float | list[float] | None


def read(evidence: Evidence, how: Mapping[str, Any], at: Mapping[str, float]) -> Number:
    """Our number for a `read:` entry, at the base values and `at`."""
    at = {**at, **{key: si(key, value) for key, value in how.get("at", {}).items() if key not in at}}
    if "formula" in how:
        return _FORMULAS[how["formula"]](evidence, how)
    if "table" in how:
        return evidence.point(how["table"], how["channel"], at)
    if "time_of" in how:
        return _time_of_smallest(evidence, how["channel"], at)
    if "seconds" in how:
        return _seconds(evidence, at)
    curves = _curves(evidence, how, at)
    if not curves:
        return None
    if "largest" in how:
        return max(float(curve.value.max()) for curve in curves)
    if how["speed_of"] == "largest":
        largest = max(curves, key=lambda curve: float(curve.value.max()))
        return float(largest.velocity[np.argmax(largest.value)])
    return prominent(curves[0], how["speed_of"])


def prominent(curve: Curve, count: int) -> list[float]:
    """The velocities of the most prominent peaks of a curve, in ascending order."""
    peaks, about = find_peaks(curve.value, prominence=0)
    chosen = peaks[np.argsort(-about["prominences"], kind="stable")[:count]]
    return sorted(float(curve.velocity[k]) for k in chosen)


def _curves(evidence: Evidence, how: Mapping[str, Any], at: Mapping[str, float]) -> list[Curve]:
    """The curve over velocity, or one for each value of the axis `over`."""
    table, _, channel = how["channel"].rpartition("/")
    over = how.get("over")
    places = [{**at, over: value} for value in evidence.values_of(over)] if over else [dict(at)]
    found = [evidence.curve(table or how.get("largest", "peak"), channel, place) for place in places]
    return [curve for curve in found if curve is not None] if all(found) else []


def _time_of_smallest(evidence: Evidence, channel: str, at: Mapping[str, float]) -> float | None:
    for study in evidence.studies:
        found = Evidence([study]).where(at, "peak", channel)
        if found is None or not study.has("history", channel):
            continue
        history = study.history(found[1], [channel])
        if history is not None:
            return float(history.time[np.argmin(history.values[0])])
    return None


def _seconds(evidence: Evidence, at: Mapping[str, float]) -> float | None:
    found = evidence.where(at, "rms", "car_body_y")
    return solve_seconds(*found) if found else None


def _frequencies(evidence: Evidence, how: Mapping[str, Any]) -> Number:
    case = evidence.case
    if case is None:
        return None
    return float(natural_frequencies(case.bridge, getattr(case.bridge, how["side"]))[3] / (2 * np.pi))


def _critical(evidence: Evidence, how: Mapping[str, Any]) -> Number:
    case = evidence.case
    if case is None:
        return None
    bridge = case.bridge.replacing("length", float(how.get("span", BASE["span"])))
    velocities = critical_velocities(bridge, getattr(bridge, how["side"]), axle_distance(case)).tolist()
    return list(velocities) if "span" in how else float(velocities[3])


def _all_on(evidence: Evidence, how: Mapping[str, Any]) -> Number:
    case = evidence.case
    return axle_distance(case) / case.velocity if case else None


def _clear(evidence: Evidence, how: Mapping[str, Any]) -> Number:
    case = evidence.case
    return (case.bridge.length + axle_distance(case)) / case.velocity if case else None


def _damping_ratios(evidence: Evidence, how: Mapping[str, Any]) -> Number:
    case = evidence.case
    if case is None:
        return None
    beam = getattr(case.bridge, how["side"])
    beams = [beam.replacing("damping", beam.damping.replacing("coefficient", c)) for c in (1e3, 5e3, 10e3)]
    return [100 * b.first_mode_damping_ratio(case.bridge.length) for b in beams]


def _mode_change(evidence: Evidence, how: Mapping[str, Any]) -> Number:
    """Largest change (%) of the RMS of the car body's displacement from one number of modes to the next."""
    counts = range(how["from"], how["to"] + 1)
    rms = [evidence.point("rms", "car_body_y", {"modes": n}) for n in counts]
    known = [value for value in rms if value is not None]
    if len(known) < len(rms):
        return None
    return float(np.max(100 * np.abs(np.diff(known)) / known[:-1]))


def _mass_reversal(evidence: Evidence, how: Mapping[str, Any]) -> Number:
    """The lowest velocity from which on the car body's vertical acceleration falls with its mass."""
    masses = evidence.values_of("car_body_mass")
    curves = [evidence.curve("peak", "car_body_y_acceleration", {"car_body_mass": m}) for m in masses]
    known = [curve for curve in curves if curve is not None]
    if len(known) < 2 or len(known) < len(curves):
        return None
    falls = np.all(np.diff([curve.value for curve in known], axis=0) < 0, axis=0)
    if not falls[-1]:
        return None
    last_rise = np.flatnonzero(~falls)
    return float(known[0].velocity[last_rise[-1] + 1 if len(last_rise) else 0])


_FORMULAS: Mapping[str, Callable[[Evidence, Mapping[str, Any]], Number]] = {
    "f4": _frequencies,
    "vcr4": _critical,
    "vcr": _critical,
    "all_on": _all_on,
    "clear": _clear,
    "zeta": _damping_ratios,
    "mode_change": _mode_change,
    "mass_reversal": _mass_reversal,
}
