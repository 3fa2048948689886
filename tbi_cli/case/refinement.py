"""A swept velocity that grows speeds of its own: {from, to, step, refine: resonance}."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Annotated, Any, Literal

from pydantic import ValidationError

from tbi_cli.case.fields import RATIO, Choice, Quantity
from tbi_cli.case.part import Part
from tbi_cli.case.settings import ChannelNames
from tbi_cli.case.spaced import by_steps

#: Into so many parts a step is cut at least, and for peaks into more; a power of two, to be halved.
LEAST_PARTS = 32
# The narrowest peaks that are thought of, by their damping ratio, and how many speeds an axis may have so
# that they are settled.
_NARROWEST = 0.001
_MOST_SPEEDS = 2**15
# Where `to` is by less than this share of a step beside the last one, it is that.
_NO_STEP = Fraction(1, 10**6)
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

    The last step may be shorter.  The ends of the steps are solved in any case.  `tolerance` is relative;
    `channels` are those of the tables whose peaks decide, None: deflection and acceleration of the bridge at
    mid-span.
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
    return Refinement(LEAST_PARTS, given.tolerance, given.channels), []


def refined_values(
    ends: tuple[Fraction, Fraction], step: Fraction, refinement: Refinement, most: int
) -> tuple[tuple[float, ...], Refinement]:
    """All speeds (m/s) from the first to the last that there may be, and the refinement that has them.

    The last speed ends a step, if need be a shorter one.  Steps are cut into so many parts, a power of two,
    that a peak of a mode of 0.1 % damping at the slowest speed can be settled: a resonance has lost the
    tolerance at sqrt(2 tolerance) zeta v beside its top.  But all speeds are some 33 000 and `most` at most,
    unless 32 parts are more.
    """
    first, last = ends
    steps = math.floor((last - first) / step + _NO_STEP)
    short = (last - first - steps * step) > _NO_STEP * step
    finest = math.sqrt(2 * refinement.tolerance) * _NARROWEST * float(first)
    parts = LEAST_PARTS
    while parts * finest < step and 2 * parts * (steps + short) < min(_MOST_SPEEDS + 1, most):
        parts *= 2
    values = by_steps(first, step / parts, steps * parts + 1)
    if short:
        last_step = first + steps * step
        values = (*values, *by_steps(last_step, (last - last_step) / parts, parts + 1)[1:])
    return values, replace(refinement, per_step=parts)
