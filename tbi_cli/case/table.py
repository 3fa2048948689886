"""Tables that a case names: columns found by the names and units of their heading, in any order."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

from tbi_cli.case.cells import SEPARATORS, Cell, Rows, cells_of, read_rows, with_points
from tbi_cli.case.fields import Quantity
from tbi_cli.case.files import read_table_source
from tbi_cli.case.messages import CaseError, Place, Problem, quoted
from tbi_cli.case.units import NUMBER, UnitError, to_si
from tbi_cli.case.yaml12 import Items, Scalar, scalar_value

_BRACKETS = {"[": "]", "(": ")", "{": "}", "<": ">"}
_NO_UNIT = ("", "-")
_WHOLE = re.compile(r"[-+]?[0-9]+")
_NUMBER = re.compile(NUMBER)
Row = tuple[Cell, ...]


@dataclass(frozen=True)
class Column:
    """What a table may hold: its key, the words of a heading that name it, and what its values are.

    may_begin_empty: the first row needs no value.
    """

    key: str
    words: tuple[str, ...]
    quantity: Quantity
    may_begin_empty: bool = False


@dataclass(frozen=True)
class Layout:
    """A kind of table.

    needed: of each of these groups of keys one column must be there, and the first is taken; unnamed: the
    keys of the columns, in this order, where there is no heading, and `fewest` how many there must be; said
    and rows: the columns and the rows in words; refused: words that may mean several things, and the cure.
    """

    columns: tuple[Column, ...]
    needed: tuple[tuple[str, ...], ...]
    unnamed: tuple[str, ...]
    fewest: int
    said: str
    rows: str
    most: int
    refused: Mapping[str, str] = field(default_factory=dict)

    @cached_property
    def patterns(self) -> list[tuple[re.Pattern[str], Column]]:
        """What matches a cell of the heading that names a column, and what follows; longest first."""
        words = [(word, column) for column in self.columns for word in column.words]
        words.sort(key=lambda pair: -len(pair[0]))
        return [(_named(word), column) for word, column in words]

    def column(self, key: str) -> Column:
        """The column of this key."""
        return next(column for column in self.columns if column.key == key)


@dataclass(frozen=True)
class Table:
    """The columns that were read, by their keys, each value with its place; and what is to be warned of."""

    columns: dict[str, Items]
    warnings: list[Problem]


@dataclass(frozen=True)
class _Picked:
    """A column that is read: where it is in each row, the cell that names it, and the unit of its numbers."""

    column: Column
    index: int
    head: Cell
    unit: str = ""


def read_table(path: Path, layout: Layout) -> Table:
    """The columns of the table in `path` that `layout` knows; numbers get the unit of their heading.

    Empty lines and those that begin with # are left out; but a comment right above numbers without a heading
    may be that heading.  Below a heading there may be a row of units.  Raises CaseError.
    """
    rows = read_rows(read_table_source(path, str(path)))
    none = CaseError([Problem(Place(rows.source), "", f"expected lines of {layout.said}, got none")])
    if not rows.rows:
        raise none
    heading, body = _heading(rows, layout)
    warnings: list[Problem] = []
    if heading:
        picked, warnings = _by_name(rows, layout, heading)
        names = [cell.text for cell in heading]
        if body and not any(cell.is_number for cell in body[0]):
            picked = _with_units(rows, picked, names, body[0])
            body = body[1:]
    else:
        picked = _by_order(rows, layout)
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


def _heading(rows: Rows, layout: Layout) -> tuple[Row, tuple[Row, ...]]:
    """The cells of the heading, if there is one, and the rows below it."""
    first = rows.rows[0]
    if not any(cell.is_number for cell in first):
        return _trimmed(first), rows.rows[1:]
    if rows.comment is not None:
        line, text = rows.comment
        for separator in (rows.separator, *SEPARATORS):
            cells = _trimmed(tuple(cells_of(rows.source, text, line, separator)))
            keys = {found[0].key for cell in cells if (found := _named_by(cell, layout))}
            if len(cells) == len(_trimmed(first)) and all(keys.intersection(any_) for any_ in layout.needed):
                return cells, rows.rows
    return (), rows.rows


def _trimmed(row: Row) -> Row:
    """The row without empty cells at its end."""
    count = max((k for k, cell in enumerate(row, 1) if cell.text), default=0)
    return row[:count]


def _named(word: str) -> re.Pattern[str]:
    spelled = re.escape(word).replace(r"\ ", r"[\s_-]+")
    return re.compile(rf"{spelled}(?![^\W_])(.*)", re.IGNORECASE | re.DOTALL)


def _named_by(cell: Cell, layout: Layout) -> tuple[Column, str] | None:
    """The column that a cell names, and its unit: `force [kN]`, `F (kN)`, `force_kN`, `P / kN`, `x in m`.

    In brackets anything is taken for a unit, elsewhere only what is one.
    """
    for pattern, column in layout.patterns:
        found = pattern.fullmatch(cell.text)
        if found is None:
            continue
        rest = found[1].strip(" \t_.:")
        if rest and _BRACKETS.get(rest[0]) == rest[-1]:
            return column, rest[1:-1].strip()
        unit = re.sub(r"^(?:[\s_/,:-]+|in\s)+", "", rest)
        if not unit or not _why_not(unit, column.quantity).startswith("no unit"):
            return column, unit
    return None


def _why_not(unit: str, quantity: Quantity) -> str:
    """Why this is no unit of the quantity; empty if it is one."""
    try:
        to_si(f"1 {unit}", quantity.dimension.unit)
    except UnitError as error:
        return str(error)
    return ""


def _unit(rows: Rows, cell: Cell, unit: str, column: Column) -> str:
    """The unit of a column, if there is one and it fits."""
    if unit in _NO_UNIT:
        return ""
    reason = _why_not(unit, column.quantity)
    if reason:
        dimension = column.quantity.dimension
        example = dimension.forgotten or dimension.unit
        text = f"expected the unit of a {dimension.noun}, e.g. {column.words[0]} [{example}]"
        raise rows.fault(cell, f"{text}, got {quoted(cell.text)} ({reason})")
    return unit


def _by_name(rows: Rows, layout: Layout, heading: Row) -> tuple[list[_Picked], list[Problem]]:
    """The columns that the heading names, and a warning that names the others."""
    picked: dict[str, _Picked] = {}
    others: list[Cell] = []
    for index, cell in enumerate(heading):
        found = _named_by(cell, layout)
        if found is None:
            others.append(cell)
            continue
        column, unit = found
        if column.key in picked:
            raise rows.fault(
                cell, f"{quoted(picked[column.key].head.text)} and {quoted(cell.text)} name one column"
            )
        picked[column.key] = _Picked(column, index, cell, _unit(rows, cell, unit, column))
    for group in layout.needed:
        there = [key for key in group if key in picked]
        others += [picked.pop(key).head for key in there[1:]]
        if not there:
            raise _missing(rows, layout, others, heading)
    if not others:
        return list(picked.values()), []
    others.sort(key=lambda cell: cell.column)
    names = ", ".join(quoted(cell.text) if cell.text else "a column without a name" for cell in others)
    place = Place(rows.source, others[0].line, others[0].column, max(len(others[0].text), 1))
    text = f"left out, as it is not {layout.said}: {names}"
    return list(picked.values()), [Problem(place, "", text, odd=True)]


def _missing(rows: Rows, layout: Layout, others: list[Cell], heading: Row) -> CaseError:
    """That a column is not there; of a word that may mean several things, which ones."""
    for cell in others:
        for word, cure in layout.refused.items():
            if _named(word).fullmatch(cell.text):
                return rows.fault(cell, f"{quoted(cell.text)} {cure}")
    names = quoted(", ".join(cell.text for cell in heading))
    text = f"expected a heading with the columns {layout.said}, with their units if not SI, got {names}"
    cure = "lines that are neither heading nor numbers begin with #"
    return CaseError([Problem(Place(rows.source, heading[0].line), "", f"{text}; {cure}")])


def _with_units(rows: Rows, picked: list[_Picked], names: list[str], row: Row) -> list[_Picked]:
    """The columns with the units that stand in a row of their own below the heading."""
    if len(row) < len(names):
        raise rows.odd_row(row[0].line, _values(rows, names).replace("values", "units", 1))
    found: list[_Picked] = []
    for one in picked:
        cell = row[one.index]
        text = cell.text
        inner = text[1:-1].strip() if text and _BRACKETS.get(text[0]) == text[-1] else text
        unit = _unit(rows, cell, inner, one.column)
        if unit and one.unit and unit != one.unit:
            raise rows.fault(cell, f"expected one unit, got {quoted(one.head.text)} and {quoted(text)}")
        found.append(_Picked(one.column, one.index, one.head, unit or one.unit))
    return found


def _by_order(rows: Rows, layout: Layout) -> list[_Picked]:
    """The columns of a table without a heading."""
    first = _trimmed(rows.rows[0])
    most = len(layout.unnamed)
    if not layout.fewest <= len(first) <= most or not all(cell.is_number for cell in first):
        count = str(most) if layout.fewest == most else f"{layout.fewest} or {most}"
        expected = f"a heading with the columns {layout.said}, or {count} values"
        raise rows.odd_row(first[0].line, expected, _commas(rows))
    # Without units, whole numbers everywhere may be what decimal commas have parted: -20,0,1.
    whole = all(_WHOLE.fullmatch(cell.text) for row in rows.rows for cell in row)
    if rows.separator == "," and len(first) > layout.fewest and whole and _any_but_zero(rows.rows):
        raise rows.odd_row(first[0].line, f"a heading with the columns {layout.said}", _commas(rows))
    keys = zip(layout.unnamed, first, strict=False)
    return [_Picked(layout.column(key), index, cell) for index, (key, cell) in enumerate(keys)]


def _any_but_zero(rows: tuple[Row, ...]) -> bool:
    return any(float(cell.text) != 0 for row in rows for cell in row[1:])


def _commas(rows: Rows) -> str:
    if rows.separator != ",":
        return ""
    return "if the commas are decimal signs, part the columns with semicolons or tabs"


def _wanted(rows: Rows, row: Row, picked: list[_Picked], names: list[str], *, first: bool) -> list[Cell]:
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
        raise rows.odd_row(row[0].line, _values(rows, names), _commas(rows) if spare else "")
    return cells


def _values(rows: Rows, names: list[str]) -> str:
    parted = f" parted by {SEPARATORS[rows.separator]}" if len(names) > 1 else ""
    return f"{len(names)} values{parted}, {', '.join(name or 'one more' for name in names)}"


def _value(rows: Rows, cell: Cell, unit: str) -> Scalar:
    """The number in a cell, with the unit of its column if it has none itself."""
    value: str | int | float | bool | None = cell.text
    if _NUMBER.fullmatch(cell.text):
        value = f"{cell.text} {unit}" if unit else scalar_value(cell.text)
    return Scalar(rows.source, cell.line, cell.column, max(len(cell.text), 1), 1, value)
