"""Trains of constant forces: axle lists, and the trains HSLM-A of EN 1991-2; every number in SI."""

from __future__ import annotations

from functools import cached_property
from typing import Annotated, Literal

from tbi_cli.case.fields import Text, Whole
from tbi_cli.case.part import Part
from tbi_cli.case.simple_vehicles import Forces, MovingLoad, Positions


class AxleForces(MovingLoad):
    """Axle forces of constant size at fixed distances, listed here or read from a CSV file.

    `csv` is read where the case is: in a Case, `positions` and `forces` hold what the file says.
    """

    forms = (frozenset({"csv"}), frozenset({"positions", "forces"}))

    model: Literal["axle-forces"]  # type: ignore[assignment]
    forces: Forces
    positions: Positions
    csv: Annotated[str, Text("CSV file beside this one: positions and forces", 1000)] | None = None


# Number of intermediate coaches N, coach length D (m), bogie axle spacing d (m), axle force P (N): EN 1991-2,
# table 6.3.
HSLM_A = {
    1: (18, 18.0, 2.0, 170e3),
    2: (17, 19.0, 3.5, 200e3),
    3: (16, 20.0, 2.0, 180e3),
    4: (15, 21.0, 3.0, 190e3),
    5: (14, 22.0, 2.0, 170e3),
    6: (13, 23.0, 2.0, 180e3),
    7: (13, 24.0, 2.0, 190e3),
    8: (12, 25.0, 2.5, 190e3),
    9: (11, 26.0, 2.0, 210e3),
    10: (11, 27.0, 2.0, 210e3),
}
# Axles of a power car, and the first of the end coach beside it (m); the end coach's other bogie is centred
# at the first of the joints between coaches, less one coach.
_HEAD = (0.0, 3.0, 14.0, 17.0, 20.525)
_FIRST_JOINT = 18.7625


class HslmA(Part):
    """One of the ten trains HSLM-A of EN 1991-2, 6.4.6.1.1: moving forces that stand for all fast trains."""

    model: Literal["hslm-a"]
    number: Annotated[int, Whole("number of the train HSLM-A", 1, 10)]

    @property
    def coach_length(self) -> float:
        """Length D of an intermediate coach [m], after which the forces repeat."""
        return HSLM_A[self.number][1]

    @cached_property
    def positions(self) -> tuple[float, ...]:
        """Distance of each force behind the first [m]: the head, bogies at the joints, the head mirrored."""
        coaches, D, d, _ = HSLM_A[self.number]
        head = (*_HEAD, _HEAD[-1] + d)
        length = 2 * _FIRST_JOINT + (coaches + 2) * D
        joints = (_FIRST_JOINT + i * D for i in range(1, coaches + 2))
        bogies = (joint + side * d / 2 for joint in joints for side in (-1, 1))
        return (*head, *bogies, *(length - x for x in reversed(head)))

    @cached_property
    def forces(self) -> tuple[float, ...]:
        """The forces [N], all equal."""
        return (HSLM_A[self.number][3],) * len(self.positions)
