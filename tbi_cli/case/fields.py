"""What a key of the case file accepts: a quantity, a whole number, a choice, a switch, a text.

Each is the metadata of a pydantic field (`Annotated[float, Quantity(...)]`), does the conversion to SI and
the checks, and carries what messages, the JSON Schema and the results file say of the key.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar, Literal

from pydantic import GetCoreSchemaHandler
from pydantic_core import PydanticCustomError, core_schema

from tbi_cli.case.messages import UNPRINTABLE, plain_number, quoted
from tbi_cli.case.units import STANDARD_GRAVITY, UnitError, to_si

# Far outside of anything physical, but such that products of a few values stay finite.
LARGEST, SMALLEST = 1e15, 1e-15
Sign = Literal["positive", "not negative", "any"]


class BadValueError(ValueError):
    """A value that a key does not accept: "expected ..., got ..."."""


@dataclass(frozen=True)
class Accepts:
    """A key's description; subclasses say what values it takes."""

    text: str

    def expected(self) -> str:
        """What a message says after "expected"."""
        raise NotImplementedError

    def parse(self, value: Any) -> Any:
        """The value in SI; raises BadValueError."""
        raise NotImplementedError

    def bad(self, value: Any, reason: str = "") -> BadValueError:
        """The message about a value that is not accepted."""
        return BadValueError(
            f"expected {self.expected()}, got {quoted(value)}" + (f" ({reason})" if reason else "")
        )

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> core_schema.CoreSchema:
        return core_schema.no_info_plain_validator_function(_as_pydantic(self.parse))


def rejected(text: str, *at: str | int) -> PydanticCustomError:
    """The error by which a validator says `text` of a value, or of what is in it under the keys `at`."""
    return PydanticCustomError("tbi", "{text}", {"text": text, "at": at})


@dataclass(frozen=True)
class AtMost:
    """Of a list: no more values than that, or else none of them is looked at."""

    most: int

    def _check(self, value: Any) -> Any:
        if isinstance(value, list | tuple) and len(value) > self.most:
            raise rejected(f"expected at most {self.most} values in this list, got {len(value)}")
        return value

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> Any:
        return core_schema.no_info_before_validator_function(self._check, handler(source))


def _as_pydantic(parse: Callable[[Any], Any]) -> Callable[[Any], Any]:
    def validate(value: Any) -> Any:
        try:
            return parse(value)
        except BadValueError as error:
            raise rejected(str(error)) from None

    return validate


@dataclass(frozen=True)
class Dimension:
    """An SI unit: as in the results file, what it measures, and the unit that is easily left off a number."""

    unit: str
    noun: str
    forgotten: str = ""


HEAVIEST_AXLE = 50.0  # t: a number in place of a force that may be the mass of an axle


LENGTH = Dimension("m", "length")
MASS = Dimension("kg", "mass", "t")
INERTIA = Dimension("kg m^2", "moment of inertia", "t*m^2")
STIFFNESS = Dimension("N/m", "stiffness", "kN/m")
DAMPING = Dimension("N s/m", "damping", "kN*s/m")
PRESSURE = Dimension("Pa", "pressure", "GPa")
AREA_MOMENT = Dimension("m^4", "second moment of area")
LINE_MASS = Dimension("kg/m", "mass per length", "t/m")
LINE_DAMPING = Dimension("N s/m^2", "damping per length", "kN*s/m^2")
SPEED = Dimension("m/s", "speed", "km/h")
ACCELERATION = Dimension("m/s^2", "acceleration")
FORCE = Dimension("N", "force", "kN")
TIME = Dimension("s", "time", "ms")
FREQUENCY = Dimension("Hz", "frequency", "kHz")
RATIO = Dimension("1", "ratio", "%")
FACTOR = Dimension("1", "number")


@dataclass(frozen=True)
class Quantity(Accepts):
    """A number in SI, or a string with a unit; `words` may stand in its place ("auto").

    `usual` is the range outside of which a value is physically odd; 0 is never odd where it is allowed.
    `hint` is said of a value of the wrong sign.
    """

    dimension: Dimension
    example: str
    sign: Sign = "positive"
    usual: tuple[float, float] | None = None
    words: tuple[str, ...] = ()
    largest: float = LARGEST
    smallest: float = SMALLEST
    hint: str = ""

    def expected(self) -> str:
        noun = self.dimension.noun
        article = "an" if noun[0] in "aeiou" else "a"
        named = {
            "positive": f"a positive {noun}",
            "not negative": f"{article} {noun} >= 0",
            "any": f"{article} {noun}",
        }
        number = to_si(self.example, self.dimension.unit)
        examples = [f'"{self.example}" or {plain_number(number)}' if " " in self.example else self.example]
        words = "".join(f", or {word}" for word in self.words)
        return f"{named[self.sign]}, e.g. {examples[0]}{words}"

    def parse(self, value: Any) -> Any:
        if isinstance(value, str):
            if value in self.words:
                return value
            try:
                number = to_si(value, self.dimension.unit)
            except UnitError as error:
                raise self.bad(value, str(error) if error.args[0] != "no number" else "") from None
        elif isinstance(value, bool) or not isinstance(value, int | float):
            raise self.bad(value)
        else:
            number = float(value)
        return self.checked(number, value)

    def checked(self, number: float, written: Any) -> float:
        """The SI number, if its sign and size are allowed."""
        if not math.isfinite(number):
            raise self.bad(written)
        if (self.sign == "positive" and number <= 0) or (self.sign == "not negative" and number < 0):
            raise self.bad(written, self.hint)
        if abs(number) > self.largest:
            raise self.bad(written, f"larger than {plain_number(self.largest)}")
        if 0 < abs(number) < self.smallest:
            raise self.bad(written, f"smaller than {plain_number(self.smallest)}")
        return number

    def odd(self, number: float, has_unit: bool) -> str:
        """Why a value is physically odd; empty when it is not. One written without a unit may lack it."""
        if self.usual is None or number == 0 or self.usual[0] <= number <= self.usual[1]:
            return ""
        low, high = (plain_number(bound) for bound in self.usual)
        unit = "" if self.dimension.unit == "1" else f" {self.dimension.unit}"
        text = f"{plain_number(number)}{unit} is outside the usual {low} to {high}{unit}"
        if self.dimension.forgotten and not has_unit:
            meant = f"{plain_number(number)} {self.dimension.forgotten}"
            if self.usual[0] <= to_si(meant, self.dimension.unit) <= self.usual[1]:
                text += f'; was "{meant}" meant?'
                if self.dimension is FORCE and number <= HEAVIEST_AXLE:
                    text += f" (a mass of {plain_number(number)} t weighs {number * STANDARD_GRAVITY:.4g} kN)"
        return text


@dataclass(frozen=True)
class Whole(Accepts):
    """A whole number from `low` to `high`, or one of `words`."""

    low: int
    high: int
    words: tuple[str, ...] = ()
    usual: ClassVar[None] = None

    def expected(self) -> str:
        return f"a whole number from {self.low} to {self.high}" + "".join(
            f", or {word}" for word in self.words
        )

    def parse(self, value: Any) -> Any:
        if isinstance(value, str) and value in self.words:
            return value
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise self.bad(value)
        if not self.low <= value <= self.high or value != int(value):
            raise self.bad(value)
        return int(value)


Numeric = Quantity | Whole


@dataclass(frozen=True)
class Choice(Accepts):
    """One of a few words."""

    words: tuple[str, ...]

    def expected(self) -> str:
        return f"one of {', '.join(self.words)}" if len(self.words) > 1 else self.words[0]

    def parse(self, value: Any) -> Any:
        if not isinstance(value, str) or value not in self.words:
            raise self.bad(value)
        return value


@dataclass(frozen=True)
class Switch(Accepts):
    """true or false, and nothing else."""

    def expected(self) -> str:
        return "true or false"

    def parse(self, value: Any) -> Any:
        if not isinstance(value, bool):
            raise self.bad(value)
        return value


@dataclass(frozen=True)
class Text(Accepts):
    """One line of text."""

    longest: int = 500

    def expected(self) -> str:
        return f"a text of one line, at most {self.longest} characters"

    def parse(self, value: Any) -> Any:
        if not isinstance(value, str):
            raise self.bad(value, "put it in quotes" if value is not None else "")
        if len(value) > self.longest or UNPRINTABLE.search(value):
            raise self.bad(value)
        return value
