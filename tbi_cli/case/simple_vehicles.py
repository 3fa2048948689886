"""The vehicles that run on one beam; every number in SI."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import Annotated, Literal

from pydantic import field_validator, model_validator

from tbi_cli.case.fields import (
    DAMPING,
    FORCE,
    INERTIA,
    LENGTH,
    MASS,
    STIFFNESS,
    AtMost,
    BadValueError,
    Quantity,
    rejected,
)
from tbi_cli.case.messages import plain_number
from tbi_cli.case.part import Part

MOST_FORCES = 1000
WIDEST_GAP = 100.0  # m between neighbouring axles; more is a length in mm, perhaps
_DAMPING = Quantity(
    "damping of each spring; 0 for none", DAMPING, "40 kN*s/m", "not negative", usual=(1.0, 1e7)
)
_SPRUNG = (1.0, 1e6)


class SprungMass(Part):
    """A mass on one spring-damper on the right beam (the paper's first verification case)."""

    model: Literal["sprung-mass"]
    mass: Annotated[float, Quantity("sprung mass M_v", MASS, "5750 kg", usual=_SPRUNG)]
    stiffness: Annotated[
        float, Quantity("stiffness k_v of its spring", STIFFNESS, "1595 kN/m", usual=(1e3, 1e9))
    ]
    damping: Annotated[float, _DAMPING]


class RigidBeam(Part):
    """A rigid beam on two equal spring-dampers on the right beam (the paper's second verification case)."""

    model: Literal["rigid-beam"]
    mass: Annotated[float, Quantity("mass M_v of the rigid beam", MASS, "540 t", usual=_SPRUNG)]
    pitch_inertia: Annotated[
        float, Quantity("pitch inertia about the centre", INERTIA, "13800 t*m^2", usual=(1e2, 1e9))
    ]
    support_distance: Annotated[
        float, Quantity("distance d of the two springs", LENGTH, "17.5 m", usual=(1, 60))
    ]
    stiffness: Annotated[
        float, Quantity("stiffness k_v of each spring", STIFFNESS, "41.35e3 kN/m", usual=(1e3, 1e9))
    ]
    damping: Annotated[float, _DAMPING]


FORCE_OF_AXLE = Quantity(
    "force, downward",
    FORCE,
    "56.4 kN",
    "not negative",
    usual=(1e3, 1e7),
    hint="a force acts downward: change the sign",
)
POSITION_OF_AXLE = Quantity(
    "place of each force, counted backward; only differences count",
    LENGTH,
    "2.5 m",
    "any",
    (-4000, 4000),
    smallest=0.0,
)


Forces = Annotated[tuple[Annotated[float, FORCE_OF_AXLE], ...], AtMost(MOST_FORCES)]
Positions = Annotated[tuple[Annotated[float, POSITION_OF_AXLE], ...], AtMost(MOST_FORCES)]


def _out_of_order(positions: tuple[float, ...]) -> str:
    """What is wrong with the order of positions, the first axle first; nothing if they rise."""
    for number, (before, position) in enumerate(pairwise(positions), 2):
        if position < before:
            texts = plain_number(position), plain_number(before)
            text = f"expected positions in rising order, got {texts[0]} (number {number}) after {texts[1]}"
            falling = all(b <= a for a, b in pairwise(positions))
            return f"{text}; count them backward from the first axle: change the signs" if falling else text
    return ""


class MovingLoad(Part):
    """Forces of constant size that cross the right beam.

    `positions` rise from the first force on, wherever that one stands: only their differences count.
    """

    model: Literal["moving-load"]
    forces: Forces
    positions: Positions = (0.0,)

    @property
    def behind(self) -> tuple[float, ...]:
        """Distance of each force behind the first [m]."""
        return tuple(position - self.positions[0] for position in self.positions)

    def oddities(self) -> Iterator[tuple[str, str]]:
        """Key and message where two neighbours are farther apart than the axles of a train."""
        gaps = [after - before for before, after in pairwise(self.positions)]
        widest = max(gaps, default=0.0)
        if widest > WIDEST_GAP:
            text = f"{plain_number(widest)} m behind the axle before is more than the usual"
            yield f"positions.{gaps.index(widest) + 1}", f"{text} {plain_number(WIDEST_GAP)} m"

    def check(self) -> None:
        """Raises BadValueError where forces and positions do not go together."""
        problem = ""
        if not self.forces:
            problem = "expected at least one force"
        elif len(self.positions) != len(self.forces):
            problem = (
                f"expected one position for each of the {len(self.forces)} forces, got {len(self.positions)}"
            )
        problem = problem or _out_of_order(self.positions)
        if problem:
            raise BadValueError(problem)

    @field_validator("positions")
    @classmethod
    def _in_order(cls, positions: tuple[float, ...]) -> tuple[float, ...]:
        if problem := _out_of_order(positions):
            raise rejected(problem)
        return positions

    @model_validator(mode="after")
    def _consistent(self) -> MovingLoad:
        try:
            self.check()
        except BadValueError as error:
            raise rejected(str(error)) from None
        return self
