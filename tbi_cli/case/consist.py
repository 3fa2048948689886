"""Trains of several vehicles, coupled one behind the other on the track but not to each other."""

from __future__ import annotations

from math import isclose
from typing import Annotated, Literal

from pydantic import Field, model_validator

from tbi_cli.case.axle_forces import AxleForces, HslmA
from tbi_cli.case.fields import LENGTH, AtMost, BadValueError, Quantity, Whole, rejected
from tbi_cli.case.full_train import FullTrain
from tbi_cli.case.messages import plain_number
from tbi_cli.case.part import Part
from tbi_cli.case.simple_vehicles import MovingLoad, RigidBeam, SprungMass

MOST_VEHICLES = 200
Vehicle = FullTrain | SprungMass | RigidBeam | MovingLoad | AxleForces | HslmA


def wheelbase_of(vehicle: Vehicle) -> float:
    """Distance (m) from the first axle of a vehicle to its last."""
    if isinstance(vehicle, FullTrain):
        arms = vehicle.geometry
        return arms.l_b1 + arms.l_w1 + arms.l_b2 + arms.l_w4
    if isinstance(vehicle, RigidBeam):
        return vehicle.support_distance
    return 0.0 if isinstance(vehicle, SprungMass) else vehicle.positions[-1] - vehicle.positions[0]


def _overhang(which: str) -> Quantity:
    text = f"from the {which} axle of one vehicle to its coupler there; half of the rest of spacing"
    return Quantity(text, LENGTH, "2.5 m", "not negative", usual=(0.5, 10))


class Vehicles(Part):
    """A number of equal vehicles in a row.

    Couplers meet, and equal vehicles follow each other at `spacing`, axle by axle.  What of it is not between
    the first and the last axle of a vehicle is its two overhangs, equal unless one of them is given.
    `spacing`, `front_overhang` and `rear_overhang` are always there to be read, whatever the file gives.
    """

    vehicle: Annotated[Vehicle, Field(discriminator="model")]
    count: Annotated[int, Whole("number of these vehicles in a row", 1, MOST_VEHICLES)] = 1
    given_spacing: (
        Annotated[float, Quantity("length of one vehicle over its couplers", LENGTH, "25 m", usual=(5, 50))]
        | None
    ) = Field(None, alias="spacing")
    given_front_overhang: Annotated[float, _overhang("first")] | None = Field(None, alias="front_overhang")
    given_rear_overhang: Annotated[float, _overhang("last")] | None = Field(None, alias="rear_overhang")

    @property
    def wheelbase(self) -> float:
        """Distance (m) from the first axle to the last of one vehicle."""
        return wheelbase_of(self.vehicle)

    @property
    def overhangs(self) -> tuple[float, float]:
        """In front of the first axle and behind the last (m), as far as the couplers.

        Raises BadValueError where they do not follow from the keys, or these contradict each other.
        """
        front, rear, spacing = self.given_front_overhang, self.given_rear_overhang, self.given_spacing
        if spacing is None:
            if front is None or rear is None:
                raise BadValueError("missing; expected spacing, or both front_overhang and rear_overhang")
            return front, rear
        rest = spacing - self.wheelbase
        if front is None:
            return (rest / 2, rest / 2) if rear is None else (rest - rear, rear)
        if rear is None:
            return front, rest - front
        if not isclose(front + rear, rest, rel_tol=1e-9, abs_tol=1e-9):
            whole, between, got = (
                plain_number(x) for x in (front + self.wheelbase + rear, self.wheelbase, spacing)
            )
            raise BadValueError(
                f"expected a spacing of {whole} m, as front_overhang, {between} m from the first axle to the "
                f"last, and rear_overhang add up to, got {got} m; it may be left out"
            )
        return front, rear

    @property
    def front_overhang(self) -> float:
        """From the first axle forward to the coupler (m)."""
        return self.overhangs[0]

    @property
    def rear_overhang(self) -> float:
        """From the last axle back to the coupler (m)."""
        return self.overhangs[1]

    @property
    def spacing(self) -> float:
        """Length of one vehicle over its couplers (m)."""
        if self.given_spacing is not None:
            return self.given_spacing
        return self.front_overhang + self.wheelbase + self.rear_overhang

    def check(self) -> None:
        """Raises BadValueError where the axles of neighbours would stand beyond each other's."""
        overhangs, least = self.overhangs, plain_number(self.wheelbase)
        if self.spacing <= self.wheelbase:
            got = plain_number(self.spacing)
            text = f"expected a spacing of more than {least} m, from the first axle to the last, got {got} m"
            raise BadValueError(text)
        if min(overhangs) < -1e-9:
            name = "front_overhang" if overhangs[0] > overhangs[1] else "rear_overhang"
            most, got = plain_number(self.spacing - self.wheelbase), plain_number(max(overhangs))
            raise BadValueError(
                f"expected a {name} of at most {most} m, which spacing leaves beside {least} m from the "
                f"first axle to the last, got {got} m"
            )

    @model_validator(mode="after")
    def _room_for_all(self) -> Vehicles:
        try:
            self.check()
        except BadValueError as error:
            raise rejected(str(error)) from None
        return self


class Consist(Part):
    """Several vehicles, the first in front, each with its own count and spacing."""

    model: Literal["consist"]
    consist: Annotated[tuple[Vehicles, ...], AtMost(MOST_VEHICLES)]

    @model_validator(mode="after")
    def _some(self) -> Consist:
        count = sum(group.count for group in self.consist)
        if not 1 <= count <= MOST_VEHICLES:
            raise rejected(f"expected 1 to {MOST_VEHICLES} vehicles in all, got {count}")
        return self

    @property
    def on_two_beams(self) -> bool:
        """Whether the vehicles run on both beams."""
        return isinstance(self.consist[0].vehicle, FullTrain)

    @property
    def fronts(self) -> tuple[tuple[float, ...], ...]:
        """Distance (m) of the first axle of each vehicle behind the train's first axle, group by group.

        Couplers meet: a vehicle's first axle is its front overhang behind its coupler.
        """
        found: list[tuple[float, ...]] = []
        coupler = -self.consist[0].front_overhang
        for group in self.consist:
            first = coupler + group.front_overhang
            found.append(tuple(first + k * group.spacing for k in range(group.count)))
            coupler += group.count * group.spacing
        return tuple(found)

    @property
    def wheelbase(self) -> float:
        """Distance (m) from the first axle of the train to its last."""
        return self.fronts[-1][-1] + self.consist[-1].wheelbase
