"""Whether what the paper says in words holds for our results: each statement as the list of its parts."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from tbi_cli.report.evidence import Curve, Evidence

Part = tuple[str, bool]  # what is said, and whether it holds


def check(evidence: Evidence, name: str) -> list[Part]:
    """The parts of a statement; empty where the results do not have the data."""
    return _CHECKS[name](evidence)


def _points(evidence: Evidence, channel: str) -> list[float]:
    """Peaks at 300 km/h for each mass."""
    masses = (20e3, 40e3, 60e3, 80e3)
    found = [evidence.point("peak", channel, {"car_body_mass": mass}) for mass in masses]
    known = [value for value in found if value is not None]
    return known if len(known) == len(found) else []


def _monotonic(what: str, values: list[float], rising: bool) -> Part:
    steps = np.diff(values)
    return f"{what} {'rises' if rising else 'falls'}", bool(np.all(steps > 0 if rising else steps < 0))


def _by_mass(evidence: Evidence, vertical: str, lateral: str, lateral_rises: bool) -> list[Part]:
    y, z = _points(evidence, vertical), _points(evidence, lateral)
    return [_monotonic("vertical", y, True), _monotonic("lateral", z, lateral_rises)] if y and z else []


def _mass_displacement(evidence: Evidence) -> list[Part]:
    return _by_mass(evidence, "car_body_y", "car_body_z", lateral_rises=False)


def _mass_acceleration(evidence: Evidence) -> list[Part]:
    return _by_mass(evidence, "car_body_y_acceleration", "car_body_z_acceleration", lateral_rises=True)


def _above_049(evidence: Evidence) -> list[Part]:
    curve = evidence.curve("peak", "car_body_y_acceleration", {})
    if curve is None:
        return []
    value = float(np.interp(74.9, curve.velocity, curve.value))
    above = curve.velocity[curve.value > 0.49]
    first = f", above 0.49 from {above[0]:g} m/s" if len(above) else ""
    return [(f"{value:.2f} m/s2 at 74.9 m/s{first}", value > 0.49)]


def _spans(evidence: Evidence, table: str, channel: str) -> list[Curve]:
    curves = [evidence.curve(table, channel, {"span": span}) for span in evidence.values_of("span")]
    known = [curve for curve in curves if curve is not None]
    return known if len(known) == len(curves) else []


def _span(evidence: Evidence) -> list[Part]:
    names = {
        "car_body_y": "vertical displacement",
        "car_body_z": "lateral displacement",
        "car_body_pitch": "pitch",
        "car_body_roll": "roll",
        "car_body_y_acceleration": "vertical acceleration",
        "right_midspan": "right mid-span deflection",
        "left_midspan": "left mid-span deflection",
    }
    curves = {channel: _spans(evidence, "peak", channel) for channel in (*names, "car_body_z_acceleration")}
    if not all(curves.values()):
        return []
    parts = [
        _monotonic(name, [float(c.value.max()) for c in curves[channel]], True)
        for channel, name in names.items()
    ]
    speeds = [float(c.velocity[np.argmax(c.value)]) for c in curves["right_midspan"]]
    listed = ", ".join(f"{speed:g}" for speed in speeds)
    parts.append((f"mid-span peaks move to lower speeds ({listed} m/s)", bool(np.all(np.diff(speeds) < 0))))
    lateral = [float(c.value.max()) for c in curves["car_body_z_acceleration"]]
    ratio = max(lateral) / min(lateral)
    parts.append((f"lateral acceleration hardly changes (by a factor of {ratio:.2g})", ratio < 1.2))
    return parts


def _forces(evidence: Evidence) -> list[Part]:
    wheels = [f"wheel_{axle}_{side}_force" for axle in range(1, 5) for side in ("right", "left")]
    channels = ("car_body_force", "front_bogie_force", "rear_bogie_force", *wheels)
    curves = {channel: _spans(evidence, "max", channel) for channel in channels}
    if not all(curves.values()):
        return []
    rising = [_monotonic("", [float(c.value.max()) for c in found], True)[1] for found in curves.values()]
    base = {channel: found[list(evidence.values_of("span")).index(50.0)] for channel, found in curves.items()}
    speed = {channel: float(c.velocity[np.argmax(c.value)]) for channel, c in base.items()}
    slow = all(speed[wheel] <= 40 for wheel in wheels)
    bogies = sorted(speed[f"{end}_bogie_force"] for end in ("front", "rear"))
    body = speed["car_body_force"]
    fastest = float(base["car_body_force"].velocity[-1])
    return [
        ("contact forces rise with span", all(rising)),
        (
            f"wheel forces largest at 40 m/s and below (50 m: from {min(speed[w] for w in wheels):g} m/s on)",
            slow,
        ),
        (
            f"bogie forces largest at low speed (50 m: at {bogies[0]:g} and {bogies[1]:g} m/s)",
            bogies[1] < fastest / 3,
        ),
        (f"body force largest at medium speed (50 m: at {body:g} m/s)", 0.2 * fastest < body < 0.8 * fastest),
    ]


_CHECKS: Mapping[str, Callable[[Evidence], list[Part]]] = {
    "mass_displacement": _mass_displacement,
    "mass_acceleration": _mass_acceleration,
    "above_049": _above_049,
    "span": _span,
    "forces": _forces,
}
