"""A swept velocity that grows speeds of its own: {from, to, step, refine: resonance}."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, Literal

from pydantic import ValidationError

from tbi_cli.case.fields import RATIO, Choice, Quantity
from tbi_cli.case.part import Part
from tbi_cli.case.settings import ChannelNames

# Of a power of two, so that the speeds of the step are the same with refinement and without.
SPEEDS_IN_A_STEP = 1024
REFINE_KEYS = ("refine", "tolerance", "channels")


class Refine(Part):
    """How a swept velocity is refined: where, how closely, and by which channels."""

    refine: Annotated[Literal["resonance"], Choice("where speeds are added: resonance", ("resonance",))]
    tolerance: Annotated[
        float,
        Quantity("by how much a peak may still change", RATIO, "1 %", usual=(1e-4, 0.1), largest=1),
    ] = 0.01
    channels: Annotated[
        tuple[str, ...] | None, ChannelNames("channels that are looked at; all: those of the bridge")
    ] = None


@dataclass(frozen=True)
class Refinement:
    """A refined axis: its values are all that there may be, `per_step` of them in each of its steps.

    Those of the steps themselves are solved in any case.  `tolerance` is relative; `channels` are those of
    the tables whose peaks decide, None: deflection and acceleration of the bridge at mid-span.
    """

    per_step: int
    tolerance: float
    channels: tuple[str, ...] | None


def read_refine(values: dict[str, Any]) -> tuple[Refinement | None, list[tuple[str, str]]]:
    """The refinement in the keys of an axis, or else what is wrong: (key, message)."""
    try:
        given = Refine.model_validate(values)
    except ValidationError as error:
        found = []
        for item in error.errors(include_url=False):
            text = str(item["msg"]) if item["type"] == "tbi" else "expected resonance"
            found.append((str(item["loc"][0]), text))
        return None, found
    return Refinement(SPEEDS_IN_A_STEP, given.tolerance, given.channels), []
