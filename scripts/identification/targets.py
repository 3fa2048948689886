"""The numbers to be met: the claims of trust `reported`, each with its error."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from decimal import Decimal
from importlib import resources
from typing import Any

import numpy as np
import yaml

from identification.trials import Solved
from tbi_cli.report.evidence import si
from tbi_cli.report.readings import read

# Not results of the train and bridge, or no number with digits.
LEFT_OUT = {
    "paper_seconds_50kmh": "seconds of the authors' machine",
    "paper_seconds_300kmh": "seconds of the authors' machine",
    "mode_4_up": "the paper says negligible, not a number",
}
# The run with 0.001 s at 50 km/h is the costliest; its numbers are within 0.1 % of those with 0.01 s.
_TOO_SLOW = ("_50kmh", "0.001")


@dataclass(frozen=True)
class Target:
    """A number of the paper.

    half_unit: of the last digit printed; error: what a residual is measured in; how, at, place: its reading.
    """

    id: str
    what: str
    unit: str
    value: float
    half_unit: float
    error: float
    how: dict[str, Any]
    at: tuple[tuple[str, float], ...] = ()
    place: int | None = None

    def ours(self, solved: Solved) -> float:
        """Our number, read as `tbi reproduce` does; NaN where a curve has too few peaks."""
        found = read(solved, self.how, dict(self.at))  # type: ignore[arg-type]
        if self.place is not None:
            found = found[self.place] if isinstance(found, list) and self.place < len(found) else None
        return float(found) if isinstance(found, float | int) else float("nan")


def targets(floor: float, left_out: Sequence[str] = ()) -> list[Target]:
    """The reported numbers; error: half a unit of the last digit and, in quadrature, `floor` of the value.

    The floor is for what no parameter can mend: the paper's step (0.01 s), its grid of velocities, times read
    off curves.  Readings of one run (Table 4's intervals, one number for all masses) share the weight of one.
    """
    text = resources.files("tbi_cli.report").joinpath("claims.yaml").read_text(encoding="utf-8")
    claims = yaml.load(text, Loader=yaml.BaseLoader)  # digits as printed: 0.50 stays 0.50
    return [
        target
        for name, claim in claims.items()
        if claim.get("trust", "reported") == "reported"
        and "statement" not in claim
        and name not in LEFT_OUT
        and name not in left_out
        for target in _targets(name, claim, floor)
    ]


def _targets(name: str, claim: dict[str, Any], floor: float) -> Iterator[Target]:
    how = _numbers(claim["read"])
    if "by" in claim:
        ((key, printed),) = claim["by"].items()
        alike = key == "sampling" or len(set(printed.values())) == 1
        share = len(printed) if alike else 1
        for given, text in printed.items():
            if name.endswith(_TOO_SLOW[0]) and given == _TOO_SLOW[1]:
                continue
            at = (key, si(key, float(given) if key == "sampling" else given))
            yield _target(name, claim, f": {given}", text, floor, share, how, (at,), None)
    elif isinstance(claim["value"], list):
        for k, text in enumerate(claim["value"]):
            yield _target(name, claim, f" ({k + 1})", text, floor, 1, how, (), k)
    else:
        yield _target(name, claim, "", claim["value"], floor, 1, how, (), None)


def _target(
    name: str,
    claim: dict[str, Any],
    which: str,
    text: str,
    floor: float,
    share: int,
    how: dict[str, Any],
    at: tuple[tuple[str, float], ...],
    place: int | None,
) -> Target:
    value, half = float(text), half_unit(text)
    error = float(np.hypot(half, floor * abs(value)) * np.sqrt(share))
    return Target(name, claim["what"] + which, claim["unit"], value, half, error, how, at, place)


def half_unit(text: str) -> float:
    """Half a unit of the last digit of a number as printed."""
    exponent = Decimal(text).as_tuple().exponent
    assert isinstance(exponent, int)
    return 0.5 * 10.0**exponent


def _numbers(how: dict[str, Any]) -> dict[str, Any]:
    """A reading whose whole numbers are texts, as they should be."""
    return {
        key: _numbers(value)
        if isinstance(value, dict)
        else (int(value) if isinstance(value, str) and value.isdigit() else value)
        for key, value in how.items()
    }
