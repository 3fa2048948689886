"""A table of a report: cells as they are printed, written as CSV."""

from __future__ import annotations

import csv
import io
from dataclasses import dataclass

Cell = str | float | int | None


@dataclass(frozen=True)
class Table:
    """Rows under column heads.  `name` is that of its file; numbers keep all their digits in the CSV."""

    name: str
    heading: str
    columns: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]
    note: str = ""

    def to_csv(self) -> str:
        """RFC 4180, a head line, empty cells for what is not known."""
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\r\n")
        writer.writerow(self.columns)
        for row in self.rows:
            writer.writerow(["" if cell is None or cell != cell else _csv(cell) for cell in row])
        return text.getvalue()


def shown(cell: Cell) -> str:
    """A cell for people: five digits."""
    if cell is None or cell != cell:
        return "–"
    return f"{cell:.5g}" if isinstance(cell, float) else str(cell)


def _csv(cell: Cell) -> str:
    # A text that a spreadsheet would take for a formula is a text all the same.
    if isinstance(cell, str):
        return f"'{cell}" if cell[:1] in ("=", "+", "-", "@", "\t", "\r") else cell
    return f"{cell:.12g}" if isinstance(cell, float) else str(cell)
