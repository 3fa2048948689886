"""Checks of the verification: too small is as wrong as too large, and one that fails is told."""

from __future__ import annotations

import numpy as np
import pytest

from tbi_cli.verify.check import Outcome, Tolerance
from tbi_cli.verify.run import Group
from tbi_cli.verify.solved import Verification
from tbi_cli.verify.table import table, verdict

TOLERANCE = Tolerance(1e-3, "made up")


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize(("off", "passes"), [(0.9e-3, True), (1.1e-3, False)])
def test_deviations_of_either_sign(sign: int, off: float, passes: bool) -> None:
    """Of numbers and curves of either sign, by the reference's size: of a curve, its largest."""
    outcome, shape = Outcome(), np.array([0.3, -2.0, 1.1])
    for reference in (-7.0, 7.0):
        outcome.number("c", "q", "m", reference + sign * 7 * off, reference, "s", TOLERANCE)
    for place in range(3):
        # Wrong at one sample, by its share of the 2.0 that is largest.
        ours = shape + sign * 2.0 * off * (np.arange(3) == place)
        outcome.history("c", "q", "m", ours, shape, "s", TOLERANCE)
        outcome.zero("c", "q", "m", ours - shape, 2.0, "s", TOLERANCE)
    outcome.zero("c", "q", "m", sign * 5 * off, 5.0, "s", TOLERANCE)
    assert [check.passed for check in outcome.checks] == [passes] * 9


def test_a_single_check_that_fails() -> None:
    """Wherever it stands among those that pass, its group fails, and the last line says so."""
    for bad in range(3):
        outcome = Outcome()
        for place in range(3):
            outcome.number("c", "q", "m", 1.0 + 0.5 * (place == bad), 1.0, "s", TOLERANCE)
        group = Group(Verification(1, "Made up", "", {}, lambda solved: Outcome()), outcome, 0.0)
        assert not group.passed
        assert verdict([group]).startswith("1 of 3 checks FAILED")
        assert sum("FAIL" in line for line in table(group)) == 1
