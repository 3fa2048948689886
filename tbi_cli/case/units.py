"""Numbers with units to SI, once, at the edge. pint is imported only when a unit is met.

The registry is a small one of our own (units.txt): quick to load, and free of the surprises that a full
one has for an engineer (there `t` may be a ton, `h` Planck's constant). Factors are exact fractions, so that
"300 km/h" is the float nearest to 83.333... and "0.5 %" is 0.005.
"""

from __future__ import annotations

import math
import re
from decimal import Decimal
from fractions import Fraction
from functools import cache, lru_cache
from importlib import resources
from typing import Any

NUMBER = r"[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?"
_WITH_UNIT = re.compile(rf"({NUMBER})\s*(.*)", re.DOTALL)
# Only what looks like a unit reaches pint, whose parser would evaluate 9**9**9.
_POWER = r"[A-Za-z]+(?:(?:\^|\*\*)?-?[1-9])?"
_PRODUCT = rf"{_POWER}(?:[*/ ]{_POWER})*"
_UNIT = re.compile(rf"(?:1/)?(?:{_POWER}|\({_PRODUCT}\))(?:[*/ ](?:{_POWER}|\({_PRODUCT}\)))*")
Dimension = tuple[tuple[str, str], ...]  # base dimensions with their powers
_MAX_UNIT = 40
STANDARD_GRAVITY = 9.80665  # m/s^2, by which messages tell the weight of a mass
_MAX_NUMBER = 60
# As engineers type units: superscripts, dots for products, mm2 for mm^2, kNm for kN*m, a micro sign.
_TYPED = str.maketrans(
    dict(zip("⁻¹²³⁴", "-1234", strict=True))
    | {"·": "*", "×": "*", "⋅": "*", "µ": "u", "μ": "u", "%": "percent", "‰": "permille"}
)
_DOT = re.compile(r"(?<=[A-Za-z0-9])\.(?=[A-Za-z])")
_BARE_POWER = re.compile(r"(?<=[A-Za-z])(?=-?[1-9])")
_FUSED = re.compile(r"\b([kKMG]?N(?=mm|cm|m|s)|(?:[kK]g|t)(?=m))(mm|cm|m|s)((?:\*\*-?[1-9])?)(?![A-Za-z0-9])")


class UnitError(ValueError):
    """A text that is not a number with a fitting unit; the message is the reason, without the value."""


def to_si(text: str, unit: str) -> float:
    """The number in `text`, which may carry a unit, in the SI unit `unit` ("N/m", "1").

    A text without a unit is a number in SI. Raises UnitError when it is not a number with a unit of the same
    dimension as `unit`.
    """
    number, factor = _number_and_factor(text, unit)
    if factor is None:
        return float(number)
    # The quotient of two whole numbers is rounded once; fractions would do the same ten times slower.
    above, below = Decimal(number).as_integer_ratio()
    return (above * factor.numerator) / (below * factor.denominator)


def exact_si(value: str | float, unit: str) -> Fraction:
    """What `to_si` rounds to a float; a float is taken for the shortest decimal that reads as it: 0.1.

    Raises UnitError like `to_si`.
    """
    if not isinstance(value, str):
        return Fraction(float.__repr__(float(value)))
    number, factor = _number_and_factor(value, unit)
    return Fraction(number) * (1 if factor is None else factor)


def has_unit(value: object) -> bool | None:
    """Whether a number carries a unit; None for what is no number, and for 0, which needs none."""
    if isinstance(value, bool) or not isinstance(value, str | int | float):
        return None
    found = _WITH_UNIT.fullmatch(str(value).strip())
    if not found or len(found[1]) > _MAX_NUMBER or float(found[1]) == 0:
        return None
    return bool(found[2].strip())


def _number_and_factor(text: str, unit: str) -> tuple[str, Fraction | None]:
    """The digits of `text`, and the factor to `unit` of the unit that it carries, if it carries one."""
    found = _WITH_UNIT.fullmatch(text.strip())
    if not found or len(found[1]) > _MAX_NUMBER:
        raise UnitError("no number")
    number, written = found[1], found[2].strip()
    size = abs(float(number))
    if not math.isfinite(size):
        raise UnitError("too large")
    # Rounded to 0: its exact value would have as many digits as its exponent says.
    if size == 0 and not Decimal(number).is_zero():
        raise UnitError("too small")
    if not written:
        return number, None
    if size > 1e200 or 0 < size < 1e-200:
        raise UnitError("too large or too small")
    factor, dimension = _unit(written)
    if dimension != _unit(unit)[1]:
        raise UnitError(f'"{written}" is {_named(dimension)}{_weight(written, factor, dimension, unit)}')
    return number, factor


@lru_cache(maxsize=1024)
def _unit(written: str) -> tuple[Fraction, Dimension]:
    """Factor to SI and dimension of a unit such as "kN*s/m^2"."""
    if written == "1":
        return Fraction(1), ()
    text = _DOT.sub("*", re.sub(r"\s+", " ", written[:_MAX_UNIT].translate(_TYPED)))
    text = re.sub(r"\s*([*/^()])\s*", r"\1", text)
    # "Pas" would be the plural of Pa.
    if len(written) > _MAX_UNIT or not _UNIT.fullmatch(text) or re.search(r"Pas\b", text):
        raise UnitError(f'no unit "{written[:_MAX_UNIT]}"')
    import pint

    registry = _registry()
    try:
        powers = _BARE_POWER.sub("**", text.replace(" ", "*").replace("^", "**"))
        units = registry.parse_units(_FUSED.sub(r"(\1*\2\3)", powers))
        factor, base = registry.get_base_units(units)
    except (
        pint.errors.PintError,
        ValueError,
        TypeError,
        AttributeError,
        ArithmeticError,
        SyntaxError,
        KeyError,
    ):
        raise UnitError(f'no unit "{written}"') from None
    dimension = tuple(
        sorted((str(name), str(Fraction(power))) for name, power in base.dimensionality.items())
    )
    return Fraction(factor), dimension


@cache
def _registry() -> Any:
    import pint

    with resources.as_file(resources.files("tbi_cli.case") / "units.txt") as definitions:
        registry: Any = pint.UnitRegistry(str(definitions), non_int_type=Fraction)
    return registry


# What a unit measures, for messages; the first name that fits.
_NAMES = {
    "m": "a length",
    "s": "a time",
    "kg": "a mass",
    "m/s": "a speed",
    "m/s^2": "an acceleration",
    "N": "a force",
    "Pa": "a pressure",
    "N/m": "a stiffness",
    "N*s/m": "a damping",
    "N*s/m^2": "a damping per length",
    "kg/m": "a mass per length",
    "kg*m^2": "a moment of inertia",
    "m^4": "a second moment of area",
    "m^2": "an area",
    "m^3": "a volume",
    "Hz": "a frequency",
    "1": "a ratio",
}


def _weight(written: str, factor: Fraction, dimension: Dimension, unit: str) -> str:
    """What a mass weighs, where it stands for a force."""
    if (dimension, _unit(unit)[1]) != (_unit("kg")[1], _unit("N")[1]):
        return ""
    return f", 1 {written} weighs {float(factor) * STANDARD_GRAVITY / 1000:.4g} kN"


def _named(dimension: Dimension) -> str:
    for unit, name in _NAMES.items():
        if _unit(unit)[1] == dimension:
            return name
    return "something else"
