"""The verification as lines of text."""

from __future__ import annotations

from collections.abc import Iterator

from tbi_cli.verify.check import Check
from tbi_cli.verify.run import Group

HEADINGS = ("case", "quantity", "reference", "source", "ours", "difference", "tolerance", "")


def cells(check: Check) -> tuple[str, ...]:
    """The columns of a check, as text, in the order of HEADINGS."""
    unit = "" if check.units in ("1", "SI") else f" {check.units}"
    return (
        check.case,
        check.quantity,
        f"{check.reference:.7g}{unit}",
        check.source,
        f"{check.ours:.7g}{unit}",
        f"{check.difference:.1e}",
        f"{check.tolerance.value:.1e}",
        "pass" if check.passed else "FAIL",
    )


def table(group: Group, *, failures_only: bool = False) -> Iterator[str]:
    """The lines of one group: its title and a row per check."""
    checks = [c for c in group.outcome.checks if not (failures_only and c.passed)]
    if not checks:
        return
    rows = [HEADINGS, *map(cells, checks)]
    widths = [max(len(row[k]) for row in rows) for k in range(len(HEADINGS))]
    yield f"{group.verification.number}. {group.verification.title}"
    for row in rows:
        yield "   " + "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
    yield ""


def verdict(groups: list[Group]) -> str:
    """One line: how many checks passed, and how long it took."""
    checks = [check for group in groups for check in group.outcome.checks]
    failed = sum(not check.passed for check in checks)
    seconds = sum(group.seconds for group in groups)
    start = f"{failed} of {len(checks)} checks FAILED" if failed else f"all {len(checks)} checks passed"
    return f"{start} in {seconds:.1f} s"
