"""What a verification says: checks (a number against a reference, with a tolerance) and curves."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from tbi_cli.verify.references.parameters import Array


@dataclass(frozen=True)
class Tolerance:
    """The largest difference that passes, dimensionless, and the error estimate behind it."""

    value: float
    reason: str


@dataclass(frozen=True)
class Check:
    """One line of the table: a quantity of a case, ours and the reference's (from `source`).

    `difference` is dimensionless: the deviation over the size of the reference, or over what `quantity` names
    after a slash. The check passes if it is at most the tolerance.
    """

    case: str
    quantity: str
    units: str
    reference: float
    source: str
    ours: float
    difference: float
    tolerance: Tolerance

    @property
    def passed(self) -> bool:
        """True if the difference is a number within the tolerance."""
        return math.isfinite(self.difference) and self.difference <= self.tolerance.value


@dataclass(frozen=True)
class Line:
    """One line of a figure: x and y (n,), its label, and whether it is the reference."""

    label: str
    x: Array
    y: Array
    reference: bool = False


@dataclass(frozen=True)
class Curve:
    """A figure of the page: our lines drawn over the reference's."""

    title: str
    x_label: str
    y_label: str
    lines: tuple[Line, ...]
    logarithmic: bool = False


@dataclass
class Outcome:
    """All checks and figures of one group of cases."""

    checks: list[Check] = field(default_factory=list)
    curves: list[Curve] = field(default_factory=list)

    def number(
        self,
        case: str,
        quantity: str,
        units: str,
        ours: float,
        reference: float,
        source: str,
        tolerance: Tolerance,
    ) -> None:
        """Check one number; the difference is relative to the reference."""
        difference = abs(ours - reference) / abs(reference)
        self.checks.append(Check(case, quantity, units, reference, source, ours, difference, tolerance))

    def history(
        self,
        case: str,
        quantity: str,
        units: str,
        ours: Array,
        reference: Array,
        source: str,
        tolerance: Tolerance,
    ) -> None:
        """Check a curve everywhere: the largest deviation over the reference's largest size.

        The two values shown are those where the curves differ most.
        """
        difference = np.abs(ours - reference)
        worst = int(np.argmax(difference))
        relative = float(difference[worst]) / float(np.abs(reference).max())
        self.checks.append(
            Check(
                case,
                quantity,
                units,
                float(reference[worst]),
                source,
                float(ours[worst]),
                relative,
                tolerance,
            )
        )

    def zero(
        self,
        case: str,
        quantity: str,
        units: str,
        ours: Array | float,
        scale: float,
        source: str,
        tolerance: Tolerance,
    ) -> None:
        """Check that something stays zero: its largest size over `scale`, which `quantity` names."""
        largest = float(np.max(np.abs(ours)))
        self.checks.append(Check(case, quantity, units, 0.0, source, largest, largest / scale, tolerance))

    def at_least(
        self, case: str, quantity: str, ours: float, reference: float, source: str, shortfall: Tolerance
    ) -> None:
        """Check a number that may be larger than the reference, but smaller by the shortfall at most."""
        difference = max(0.0, (reference - ours) / reference) if math.isfinite(ours) else math.nan
        self.checks.append(Check(case, quantity, "1", reference, source, ours, difference, shortfall))


def worst_channel(pairs: Mapping[str, tuple[Array, Array]]) -> str:
    """The channel whose two histories (ours, reference) differ most, over the reference's largest value."""

    def difference(name: str) -> float:
        ours, reference = pairs[name]
        deviation, scale = float(np.abs(ours - reference).max()), float(np.abs(reference).max())
        if deviation == 0.0:
            return 0.0
        return deviation / scale if scale > 0 and math.isfinite(deviation) else math.inf

    return max(pairs, key=difference)
