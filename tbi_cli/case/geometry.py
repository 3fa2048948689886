"""Where the bogies, axles and springs of the full train are."""

from __future__ import annotations

from functools import cached_property
from math import isclose
from typing import Annotated

from pydantic import Field, model_validator

from tbi_cli.case.fields import LENGTH, BadValueError, Quantity, rejected
from tbi_cli.case.part import Part


def _two_arms(
    total: float | None, first: float | None, second: float | None, names: str
) -> tuple[float, float]:
    """The two arms of a distance, of which any may be left out that follows from the others."""
    whole, one, other = names.split()
    if first is not None and second is not None:
        if total is not None and not isclose(first + second, total, rel_tol=1e-9):
            raise BadValueError(f"{whole} = {total:.10g}, but {one} + {other} = {first + second:.10g}")
        return first, second
    if total is None:
        raise BadValueError(f"missing; expected {whole}, or both {one} and {other}")
    if first is None and second is None:
        return total / 2, total / 2
    arms = (total - (second or 0.0), second or 0.0) if first is None else (first, total - first)
    if min(arms) <= 0:
        given = one if second is None else other
        raise BadValueError(f"expected {given} smaller than {whole} = {total:.10g}, got {max(arms):.10g}")
    return arms


def _arm(text: str) -> Quantity:
    return Quantity(text, LENGTH, "8.75 m", usual=(0.3, 30))


def _height(text: str, example: str) -> Quantity:
    return Quantity(text, LENGTH, example, "any", usual=(-3, 3))


class Geometry(Part):
    """Distances of the train. Bogies and axles stand half-way unless their arms are given one by one.

    `l_b1` .. `l_w4` are always there to be read, whatever the file gives.
    """

    bogie_distance: (
        Annotated[float, Quantity("between the bogie centres, l_b1 + l_b2", LENGTH, "17.5 m", usual=(3, 40))]
        | None
    ) = None
    wheelbase: (
        Annotated[float, Quantity("between the axles of a bogie, l_w1 + l_w2", LENGTH, "2.5 m", usual=(1, 6))]
        | None
    ) = None
    given_l_b1: Annotated[float, _arm("car body centre to front bogie")] | None = Field(None, alias="l_b1")
    given_l_b2: Annotated[float, _arm("car body centre to rear bogie")] | None = Field(None, alias="l_b2")
    given_l_w1: Annotated[float, _arm("front bogie centre to axle 1")] | None = Field(None, alias="l_w1")
    given_l_w2: Annotated[float, _arm("front bogie centre to axle 2")] | None = Field(None, alias="l_w2")
    given_l_w3: Annotated[float, _arm("rear bogie centre to axle 3")] | None = Field(None, alias="l_w3")
    given_l_w4: Annotated[float, _arm("rear bogie centre to axle 4")] | None = Field(None, alias="l_w4")
    secondary_half_spacing: Annotated[
        float,
        Quantity("half the lateral distance of the secondary springs, a", LENGTH, "1.23 m", usual=(0.3, 3)),
    ]
    primary_half_spacing: Annotated[
        float, Quantity("half the lateral distance of the primary springs, d", LENGTH, "1 m", usual=(0.3, 3))
    ]
    car_body_to_secondary: Annotated[
        float, _height("car body centre above the secondary springs, h_c", "0.52 m")
    ]
    secondary_to_bogie: Annotated[float, _height("secondary springs above the bogie centre, h_b", "0.29 m")]
    bogie_to_axle: Annotated[float, _height("bogie centre above the axles, h_w", "0.08 m")]

    @cached_property
    def arms(self) -> tuple[float, float, float, float, float, float]:
        """l_b1, l_b2, l_w1, l_w2, l_w3, l_w4 [m]. Raises BadValueError where keys contradict each other."""
        bogies = _two_arms(self.bogie_distance, self.given_l_b1, self.given_l_b2, "bogie_distance l_b1 l_b2")
        front = _two_arms(self.wheelbase, self.given_l_w1, self.given_l_w2, "wheelbase l_w1 l_w2")
        rear = _two_arms(self.wheelbase, self.given_l_w3, self.given_l_w4, "wheelbase l_w3 l_w4")
        return (*bogies, *front, *rear)

    @property
    def l_b1(self) -> float:
        """Car body centre to front bogie centre [m]."""
        return self.arms[0]

    @property
    def l_b2(self) -> float:
        """Car body centre to rear bogie centre [m]."""
        return self.arms[1]

    @property
    def l_w1(self) -> float:
        """Front bogie centre to axle 1 [m]."""
        return self.arms[2]

    @property
    def l_w2(self) -> float:
        """Front bogie centre to axle 2 [m]."""
        return self.arms[3]

    @property
    def l_w3(self) -> float:
        """Rear bogie centre to axle 3 [m]."""
        return self.arms[4]

    @property
    def l_w4(self) -> float:
        """Rear bogie centre to axle 4 [m]."""
        return self.arms[5]

    @model_validator(mode="after")
    def _consistent(self) -> Geometry:
        try:
            _ = self.arms
        except BadValueError as error:
            raise rejected(str(error)) from None
        return self
