"""Tables that a case names, read as columns of numbers with their units, each with its place."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from tbi_cli.case.cells import Cell, Rows, read_rows, with_points
from tbi_cli.case.files import read_table_source
from tbi_cli.case.heading import (
    Layout,
    Picked,
    Row,
    by_name,
    by_order,
    commas,
    heading_of,
    values_of,
    with_units,
)
from tbi_cli.case.messages import CaseError, Place, Problem
from tbi_cli.case.units import NUMBER
from tbi_cli.case.yaml12 import Items, Scalar, scalar_value

_NUMBER = re.compile(NUMBER)


@dataclass(frozen=True)
class Table:
    """The columns that were read, by their keys, each value with its place; and what is to be warned of."""

    columns: dict[str, Items]
    warnings: list[Problem]


def read_table(path: Path, layout: Layout) -> Table:
    """The columns of the table in `path` that `layout` knows; numbers get the unit of their heading.

    Empty lines and those that begin with # are left out; but a comment right above numbers without a heading
    may be that heading.  Below a heading there may be a row of units.  Raises CaseError.
    """
    rows = read_rows(read_table_source(path, str(path)))
    none = CaseError([Problem(Place(rows.source), "", f"expected lines of {layout.said}, got none")])
    if not rows.rows:
        raise none
    heading, body = heading_of(rows, layout)
    warnings: list[Problem] = []
    if heading:
        picked, warnings = by_name(rows, layout, heading)
        names = [cell.text for cell in heading]
        if body and not any(body[0][one.index].is_number for one in picked if one.index < len(body[0])):
            picked = with_units(rows, picked, names, body[0])
            body = body[1:]
    else:
        picked = by_order(rows, layout)
        names = [one.column.words[0] for one in picked]
    if not body:
        raise none
    if len(body) > layout.most:
        text = f"expected at most {layout.most} {layout.rows}"
        raise CaseError([Problem(Place(rows.source, body[layout.most][0].line), "", text)])
    lines = [_wanted(rows, row, picked, names, first=row is body[0]) for row in body]
    cells = iter(with_points(rows, [cell for line in lines for cell in line]))
    columns = [Items(rows.source, one.head.line, one.head.column) for one in picked]
    for _ in body:
        for one, column in zip(picked, columns, strict=True):
            column.items.append(_value(rows, next(cells), one.unit))
            column.size += 1
    return Table({one.column.key: column for one, column in zip(picked, columns, strict=True)}, warnings)


def _wanted(rows: Rows, row: Row, picked: list[Picked], names: list[str], *, first: bool) -> list[Cell]:
    """The cells of a row that are read; empty ones at the end may be too many.

    But not between commas and beside columns that are not read: `2,5,180,` may be of `position,force,remark`.
    """
    spare = row[len(names) :]
    doubtful = rows.separator == "," and len(picked) < len(names)
    whole = len(row) >= len(names) and not any(cell.text or doubtful for cell in spare)
    cells = [row[one.index] for one in picked] if whole else []
    empty = any(
        not cell.text and not (first and one.column.may_begin_empty)
        for cell, one in zip(cells, picked, strict=False)
    )
    if empty or not whole:
        raise rows.odd_row(row[0].line, values_of(rows, names), commas(rows) if spare else "")
    return cells


def _value(rows: Rows, cell: Cell, unit: str) -> Scalar:
    """The number in a cell, with the unit of its column if it has none itself."""
    value: str | int | float | bool | None = cell.text
    if _NUMBER.fullmatch(cell.text):
        value = f"{cell.text} {unit}" if unit else scalar_value(cell.text)
    return Scalar(rows.source, cell.line, cell.column, max(len(cell.text), 1), 1, value)
