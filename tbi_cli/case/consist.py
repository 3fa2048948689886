"""Trains of several vehicles, coupled one behind the other on the track but not to each other."""

from __future__ import annotations

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


class Vehicles(Part):
    """A number of equal vehicles in a row.

    `spacing` is the length of each over its couplers, in the middle of which its axles stand: equal vehicles
    follow each other at this distance, axle by axle.
    """

    vehicle: Annotated[Vehicle, Field(discriminator="model")]
    count: Annotated[int, Whole("number of these vehicles in a row", 1, MOST_VEHICLES)] = 1
    spacing: Annotated[
        float, Quantity("length of one vehicle over its couplers", LENGTH, "25 m", usual=(5, 50))
    ]

    @property
    def wheelbase(self) -> float:
        """Distance (m) from the first axle to the last of one vehicle."""
        vehicle = self.vehicle
        if isinstance(vehicle, FullTrain):
            arms = vehicle.geometry
            return arms.l_b1 + arms.l_w1 + arms.l_b2 + arms.l_w4
        if isinstance(vehicle, RigidBeam):
            return vehicle.support_distance
        if isinstance(vehicle, SprungMass):
            return 0.0
        return vehicle.positions[-1] - vehicle.positions[0]

    def check(self) -> None:
        """Raises BadValueError where the axles of neighbours would stand beyond each other's."""
        if self.spacing <= self.wheelbase:
            least, got = plain_number(self.wheelbase), plain_number(self.spacing)
            text = f"expected a spacing of more than {least} m, from the first axle to the last, got {got} m"
            raise BadValueError(text)

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

        Couplers meet: a vehicle's first axle is half of what its spacing leaves behind its coupler.
        """
        found: list[tuple[float, ...]] = []
        coupler = -(self.consist[0].spacing - self.consist[0].wheelbase) / 2
        for group in self.consist:
            first = coupler + (group.spacing - group.wheelbase) / 2
            found.append(tuple(first + k * group.spacing for k in range(group.count)))
            coupler += group.count * group.spacing
        return tuple(found)
