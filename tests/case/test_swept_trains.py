"""Axes over trains of several vehicles."""

from __future__ import annotations

from tbi_cli.case import Consist, FullTrain
from tests.core.crossings import paper


def test_the_car_body_mass_is_that_of_every_group() -> None:
    """Groups of other vehicles and counts; nothing else changes."""
    groups = (
        "{vehicle: trains/paper.yaml, count: 2, spacing: 25}",
        "{vehicle: trains/zhai-passenger.yaml, spacing: 24.6}",
        "{vehicle: trains/paper.yaml, count: 3, spacing: 26}",
    )
    case = paper(
        f"train={{consist: [{', '.join(groups)}]}}",
        "contact.static_load=physical",
        "sweep={car_body_mass: [31 t, 57 t]}",
    )
    first, second = (case.at({"car_body_mass": mass}).train for mass in (31e3, 57e3))
    assert isinstance(first, Consist) and isinstance(second, Consist)
    for light, heavy in zip(first.consist, second.consist, strict=True):
        assert isinstance(light.vehicle, FullTrain) and isinstance(heavy.vehicle, FullTrain)
        assert (light.vehicle.car_body.mass, heavy.vehicle.car_body.mass) == (31e3, 57e3)
        assert light.vehicle.car_body.replacing("mass", 57e3) == heavy.vehicle.car_body
        assert light.vehicle.front_bogie == heavy.vehicle.front_bogie
        assert (light.count, light.spacing) == (heavy.count, heavy.spacing)
