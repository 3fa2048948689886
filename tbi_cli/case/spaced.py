"""Values that follow from a few exact numbers, each rounded once: the doubles nearest to the decimals meant.

From 20 by 0.1 the hundredth is the float that reads 30.0, as in any other sweep that meets this speed.
"""

from __future__ import annotations

import math
from decimal import Context, Decimal, localcontext
from fractions import Fraction

# So many digits that the roundings of a million products are far behind the 17 of a double.
_DIGITS = 60


def by_steps(first: Fraction, step: Fraction, count: int) -> tuple[float, ...]:
    """The values first + i step, i = 0 .. count - 1."""
    below = math.lcm(first.denominator, step.denominator)
    start, more = (number.numerator * (below // number.denominator) for number in (first, step))
    # The quotient of two whole numbers is rounded once.
    return tuple((start + i * more) / below for i in range(count))


def by_ratio(first: Fraction, last: Fraction, count: int) -> tuple[float, ...]:
    """As many values from first to last, both positive, each the one before times the same factor."""
    if count == 1:
        return (float(first),)
    with localcontext(Context(prec=_DIGITS)):
        value, end = (Decimal(number.numerator) / number.denominator for number in (first, last))
        ratio = (end / value) ** (Decimal(1) / (count - 1))
        values = []
        for _ in range(count - 1):
            values.append(float(value))
            value *= ratio
    return (*values, float(last))
