"""How a case is solved and what is kept: contact, solver, output."""

from __future__ import annotations

from dataclasses import dataclass
from types import MappingProxyType
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, model_validator

from tbi_cli.case.fields import (
    DAMPING,
    FACTOR,
    LENGTH,
    STIFFNESS,
    TIME,
    BadValueError,
    Choice,
    Quantity,
    Switch,
    Text,
    Whole,
    rejected,
)
from tbi_cli.case.messages import quoted
from tbi_cli.case.part import Part

HISTORY_WORDS = ("none", "all")

# Per wheel.  Hertz's contact under a force Q yields by G Q^(2/3): its tangent is k_H = 3/2 Q^(1/3)/G, with
# G = 3.86e-8 R^-0.115 m/N^(2/3) for worn wheels of radius R (Zhai, Vehicle-Track Coupled Dynamics), so
# 1.4 GN/m for Q = 64 kN and R = 0.45 m.  Running circles are nominally 1.5 m apart on standard gauge.
HERTZ_SPRING = {"stiffness": 1.4e9, "damping": 0.0, "running_circle": 0.75}


@dataclass(frozen=True)
class ContactSpring:
    """What a wheel of the contact `hertz` stands on: N/m, N s/m, and where its running circle is (m)."""

    stiffness: float
    damping: float
    running_circle: float


class Contact(Part):
    """How wheels stand on the beams."""

    needs = MappingProxyType(dict.fromkeys(HERTZ_SPRING, ("model", "hertz")))

    model: Annotated[
        Literal["paper", "hertz"],
        Choice(
            "contact model; paper: Eqs. (12b, d, e); hertz: wheels with mass on springs that may lift off",
            ("paper", "hertz"),
        ),
    ] = "paper"
    static_load: Annotated[
        Literal["physical", "paper"],
        Choice(
            "static wheel load; paper: Eq. (13a) literally, physical: the weight of the train",
            ("physical", "paper"),
        ),
    ] = "physical"
    convective: Annotated[
        bool, Switch("whether the damper feels the convective part v phi' q of the beam's rate")
    ] = False
    stiffness: (
        Annotated[float, Quantity("linearised Hertz stiffness k_H of one wheel", STIFFNESS, "1.4e9")] | None
    ) = None
    damping: (
        Annotated[float, Quantity("damping of one wheel on its rail", DAMPING, "0", "not negative")] | None
    ) = None
    running_circle: (
        Annotated[float, Quantity("distance of a running circle from the track's middle", LENGTH, "0.75 m")]
        | None
    ) = None

    @model_validator(mode="before")
    @classmethod
    def _spring(cls, values: Any) -> Any:
        """Fills in the contact spring of `hertz`; the other model has none."""
        if isinstance(values, dict) and values.get("model") == "hertz":
            return HERTZ_SPRING | values
        return values

    @property
    def spring(self) -> ContactSpring | None:
        """The contact spring of a wheel, where there is one."""
        if self.stiffness is None or self.damping is None or self.running_circle is None:
            return None
        return ContactSpring(self.stiffness, self.damping, self.running_circle)


class Solver(Part):
    """Time integration: sampling interval, substeps in each, and how long."""

    needs = MappingProxyType({"substeps": ("method", "rk4")})

    method: Annotated[
        Literal["rk4", "exact"],
        Choice(
            "rk4: classical fourth-order Runge-Kutta; exact: closed form, for trains of constant forces",
            ("rk4", "exact"),
        ),
    ] = "rk4"
    sampling: Annotated[
        float | Literal["auto"],
        Quantity("sampling interval", TIME, "0.001 s", usual=(1e-6, 0.5), words=("auto",)),
    ] = "auto"
    substeps: Annotated[
        int | Literal["auto"], Whole("steps in each sampling interval", 1, 1_000_000, ("auto",))
    ] = "auto"
    duration: Annotated[
        float,
        Quantity(
            "window, in times of crossing (L + train length)/v", FACTOR, "5", usual=(1, 100), largest=1e4
        ),
    ] = 5.0


class ChannelNames(Text):
    """A list of channel names, or all."""

    def expected(self) -> str:
        return "all, or a list of channel names such as [car_body_y, right_midspan]"

    def parse(self, value: Any) -> Any:
        if value == "all":
            return None
        if not isinstance(value, list | tuple) or not value:
            raise self.bad(value)
        names = [name for name in value if isinstance(name, str) and name.replace("_", "").isalnum()]
        if len(names) != len(value):
            raise self.bad(next(name for name in value if name not in names))
        if len(set(names)) != len(names):
            raise BadValueError(f"{next(name for name in names if names.count(name) > 1)} is given twice")
        return tuple(names)


class Histories(Part):
    """Which time histories are stored: `channels` is () for none, None for all of them."""

    channels: Annotated[tuple[str, ...] | None, ChannelNames("channels to store")] = None
    every: (
        Annotated[
            float, Quantity("interval of stored samples; a multiple of sampling, unless auto", TIME, "0.01 s")
        ]
        | None
    ) = None

    @property
    def stored(self) -> bool:
        """Whether any history is stored."""
        return self.channels is None or bool(self.channels)


NO_HISTORIES = Histories.model_construct(channels=(), every=None)


def _histories(value: Any) -> Any:
    if value is None or value == "none":
        return NO_HISTORIES
    if value == "all":
        return Histories()
    if isinstance(value, dict | Histories):
        return value
    raise rejected(f"expected none, all or {{channels: [...], every: 0.01 s}}, got {quoted(value)}")


class Output(Part):
    """Where the results go, and which histories with them."""

    file: Annotated[str, Text("results file", 1000)] = "results.h5"
    histories: Annotated[Histories, BeforeValidator(_histories)] = NO_HISTORIES
    coaches: Annotated[
        Literal["extremes", "each"],
        Choice(
            "tables of a consist; extremes: over all its vehicles, each: every vehicle's own as well",
            ("extremes", "each"),
        ),
    ] = "extremes"
