"""The bridge: one or two simply supported beams of the same length; every number in SI."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi, sqrt
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, model_validator

from tbi_cli.case.fields import (
    AREA_MOMENT,
    FREQUENCY,
    LENGTH,
    LINE_DAMPING,
    LINE_MASS,
    PRESSURE,
    RATIO,
    AtMost,
    Quantity,
    Whole,
    rejected,
)
from tbi_cli.case.part import Part

DampingForm = Literal["coefficient", "first_mode_ratio", "ratio"]
DAMPING_FORMS: tuple[DampingForm, ...] = ("coefficient", "first_mode_ratio", "ratio")
USUAL_RATIO = (1e-5, 0.2)
MOST_STATIONS = 100
_HOW = ", or {first_mode_ratio: 2.36 %}, or {ratio: 1 %}"
_HOW_SWEPT = " (ratios, where the bridge's own damping is one, as {ratio: 1 %})"


@dataclass(frozen=True)
class Coefficient(Quantity):
    """The damping coefficient of a beam; a bare percentage is answered with the keys that take one."""

    swept: bool = False

    def expected(self) -> str:
        return super().expected() + (_HOW_SWEPT if self.swept else _HOW)


COEFFICIENT = Coefficient("damping coefficient c of the beam", LINE_DAMPING, "10 kN*s/m^2", "not negative")


class Damping(Part):
    """Damping of a beam, given in one of three forms.

    coefficient: c [N s/m2]; first_mode_ratio: zeta of the first mode, c = 2 zeta mu omega_1; ratio: one zeta
    for all modes. `form` says which, `value` is the number.
    """

    forms = tuple(frozenset({form}) for form in DAMPING_FORMS)

    coefficient: Annotated[float, COEFFICIENT] | None = None
    first_mode_ratio: (
        Annotated[
            float,
            Quantity(
                "damping ratio of the first mode; c follows from it",
                RATIO,
                "2.36 %",
                "not negative",
                largest=10,
            ),
        ]
        | None
    ) = None
    ratio: (
        Annotated[
            float,
            Quantity(
                "damping ratio of every mode", RATIO, "1 %", "not negative", usual=USUAL_RATIO, largest=10
            ),
        ]
        | None
    ) = None

    @property
    def form(self) -> DampingForm:
        """The form in which the damping is given."""
        if self.coefficient is not None:
            return "coefficient"
        return "ratio" if self.first_mode_ratio is None else "first_mode_ratio"

    @property
    def value(self) -> float:
        """The number given, in the unit of its form."""
        value: float = getattr(self, self.form)
        return value

    def replacing(self, name: str, value: object) -> Damping:
        """This damping with one number changed; a number of another form replaces the form."""
        others = dict.fromkeys(DAMPING_FORMS, None)
        return super(Damping, Damping.model_construct(**others)).replacing(name, value)

    @model_validator(mode="after")
    def _one_form(self) -> Damping:
        given = [name for name in DAMPING_FORMS if getattr(self, name) is not None]
        if len(given) != 1:
            got = f"{' and '.join(given)}" if given else "none of them"
            text = f"expected one of {', '.join(DAMPING_FORMS)}, got {got}"
            raise rejected(text)
        return self


def _coefficient_unless_mapping(value: Any) -> Any:
    if isinstance(value, dict | Damping):
        return value
    if value is None:
        raise rejected(str(COEFFICIENT.bad(value)))
    return {"coefficient": value}


class Beam(Part):
    """One simply supported Euler-Bernoulli beam."""

    youngs_modulus: Annotated[float, Quantity("Young's modulus E", PRESSURE, "207 GPa", usual=(1e8, 1e12))]
    second_moment: Annotated[
        float, Quantity("second moment of area I", AREA_MOMENT, "0.2 m^4", usual=(1e-4, 1e3))
    ]
    mass_per_length: Annotated[float, Quantity("mass per length mu", LINE_MASS, "20 t/m", usual=(100, 200e3))]
    damping: Annotated[Damping, BeforeValidator(_coefficient_unless_mapping)]

    def first_mode_damping_ratio(self, length: float) -> float:
        """Damping ratio of the first mode of a span of `length` [m]; omega_1 by Eq. (14)."""
        if self.damping.form != "coefficient":
            return self.damping.value
        omega_1 = (pi / length) ** 2 * sqrt(self.youngs_modulus * self.second_moment / self.mass_per_length)
        return self.damping.value / (2 * self.mass_per_length * omega_1)


_POSITION = Quantity("distance from the beginning of the span", LENGTH, "12.5 m", "not negative", (0, 300))
_FRACTION = Quantity("share of the span", RATIO, "25 %", "not negative", largest=1)


class Stations(Part):
    """Where the beams are looked at besides mid-span: positions, or fractions of the span."""

    forms = (frozenset({"positions"}), frozenset({"fractions"}))

    positions: Annotated[tuple[Annotated[float, _POSITION], ...], AtMost(MOST_STATIONS)] = ()
    fractions: Annotated[tuple[Annotated[float, _FRACTION], ...], AtMost(MOST_STATIONS)] = ()

    @model_validator(mode="after")
    def _one_list(self) -> Stations:
        given = self.positions or self.fractions
        if not given or (self.positions and self.fractions):
            raise rejected("expected a list of positions, or {fractions: [...]}, and at least one of them")
        return self


NO_STATIONS = Stations.model_construct(positions=(), fractions=())


def _positions_unless_mapping(value: Any) -> Any:
    if isinstance(value, dict | Stations):
        return value
    return {"positions": value}


class Bridge(Part):
    """The span, its number of modes and its beams. `left` is absent for vehicles that run on one beam."""

    length: Annotated[float, Quantity("span L", LENGTH, "50 m", usual=(2, 300))]
    modes: Annotated[int, Whole("number of modes n of each beam", 1, 20)] = 4
    right: Beam
    left: Beam | None = None
    stations: Annotated[Stations, BeforeValidator(_positions_unless_mapping)] = NO_STATIONS
    low_pass: Annotated[
        float | Literal["none", "en-1990"],
        Quantity(
            "cut-off of the low-passed accelerations; en-1990: 1.5 times the largest of 30 Hz, 1.5 f1, f3",
            FREQUENCY,
            "30 Hz",
            usual=(5, 200),
            words=("none", "en-1990"),
        ),
    ] = "none"

    @property
    def places(self) -> tuple[float, ...]:
        """The stations as distances (m) from the beginning of the span."""
        return self.stations.positions or tuple(x * self.length for x in self.stations.fractions)
