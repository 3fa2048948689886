"""What a panel shows beside its curves: critical velocities, the train's exit, comfort limits."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from tbi_cli.case import Case, FullTrain, MovingLoad, RigidBeam
from tbi_cli.report.plot import Curve, Limit, Mark, Points
from tbi_cli.system.assembly import build_system
from tbi_cli.system.bridge import critical_velocities

_SIDE = re.compile(r"(?:^|_)(right|left)(?:_|$)")
_BODY_ACCELERATION = re.compile(r"car_body_[yz]_acceleration")
_WHEEL_FORCE = re.compile(r".*wheel_[0-9]+_(right|left)_force")
EXIT, CRITICAL, LIFT_OFF = "train leaves", "v_cr", "wheel lifts off"
RESONANCE, PEAK = "v_res", "peak found"
#: ISO 2631 as the paper quotes it (section 3.4), in m/s2: medium and low comfort.
ISO_2631 = (Limit("ISO 2631", 0.37), Limit("ISO 2631", 0.49))
#: EN 1990, A2.4.4.2.1, for the acceleration of the deck, in m/s2: ballasted track, track without ballast.
EN_1990 = (Limit("EN 1990", 3.5), Limit("EN 1990", 5.0))


def axle_distance(case: Case) -> float:
    """The d of Eq. (16), from a vehicle's first axle to its last (m); 0 for a train, which has no one d."""
    one_vehicle = isinstance(case.train, FullTrain | RigidBeam | MovingLoad)
    return build_system(case).axle_distance if one_vehicle else 0.0


def critical(case: Case, side: str | None = None) -> list[Mark]:
    """A mark for each mode at the critical velocities of the beams, Eq. (16); none if d is zero.

    `side` keeps to one of the beams.
    """
    distance = axle_distance(case)
    if distance == 0:
        return []
    beams = {"right": case.bridge.right, "left": case.bridge.left}
    found = {
        name: critical_velocities(case.bridge, beam, distance)
        for name, beam in beams.items()
        if beam is not None and side in (None, name)
    }
    return [
        Mark(
            f"{CRITICAL}{mode + 1}",
            tuple((float(velocities[mode]), name) for name, velocities in found.items()),
        )
        for mode in range(case.bridge.modes)
    ]


def leaving(case: Case) -> list[Mark]:
    """The time at which the last axle leaves the bridge, (L + d)/v."""
    time = (case.bridge.length + build_system(case).axle_distance) / case.velocity
    return [Mark(EXIT, ((time, ""),))]


def side_of(channels: Sequence[str]) -> str | None:
    """The beam that all these channels belong to, if there is one."""
    sides = {found[1] if (found := _SIDE.search(channel)) else None for channel in channels}
    return sides.pop() if len(sides) == 1 else None


def within(marks: Sequence[Mark], low: float, high: float) -> tuple[Mark, ...]:
    """The marks of which any line is in a range, with the lines that are."""
    kept = (
        Mark(mark.label, tuple(v for v in mark.values if low <= v[0] <= high), mark.place) for mark in marks
    )
    return tuple(mark for mark in kept if mark.values)


def limits(channels: Sequence[str]) -> tuple[Limit, ...]:
    """The comfort limits, where the car body's acceleration is among the channels."""
    return ISO_2631 if any(_BODY_ACCELERATION.fullmatch(channel) for channel in channels) else ()


def are_wheel_forces(channels: Sequence[str]) -> bool:
    """Whether all these channels are forces of wheels on their rails."""
    return all(_WHEEL_FORCE.fullmatch(channel) for channel in channels)


def lift_offs(force: Curve) -> Points | None:
    """Where the force of a wheel on its rail becomes nothing; None if it never does.

    Only a contact that cannot pull has a force of zero to the last bit.
    """
    aloft = force.y == 0
    first = np.flatnonzero(aloft & ~np.append(False, aloft[:-1]))
    return Points(LIFT_OFF, force.x[first], force.y[first], force.place) if len(first) else None
