"""The heading of a table: which columns there are, by their names in any order, and their units."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

from tbi_cli.case.cells import SEPARATORS, Cell, Rows, cells_of
from tbi_cli.case.fields import Quantity
from tbi_cli.case.messages import CaseError, Place, Problem, quoted
from tbi_cli.case.units import UnitError, to_si

_BRACKETS = {"[": "]", "(": ")", "{": "}", "<": ">"}
_NO_UNIT = ("", "-")
_WHOLE = re.compile(r"[-+]?[0-9]+")
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
class Picked:
    """A column that is read: where it is in each row, the cell that names it, and the unit of its numbers."""

    column: Column
    index: int
    head: Cell
    unit: str = ""


def heading_of(rows: Rows, layout: Layout) -> tuple[Row, tuple[Row, ...]]:
    """The cells of the heading, if there is one, and the rows below it."""
    first = _trimmed(rows.rows[0])
    if not any(cell.is_number for cell in first) or _names_all(first, layout):
        return first, rows.rows[1:]
    if rows.comment is not None:
        line, text = rows.comment
        for separator in (rows.separator, *SEPARATORS):
            cells = _trimmed(tuple(cells_of(rows.source, text, line, separator)))
            if len(cells) == len(first) and _names_all(cells, layout):
                return cells, rows.rows
    return (), rows.rows


def _names_all(row: Row, layout: Layout) -> bool:
    """Whether the cells name the columns that are needed."""
    keys = {found[0].key for cell in row if (found := _named_by(cell, layout))}
    return all(keys.intersection(group) for group in layout.needed)


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


def by_name(rows: Rows, layout: Layout, heading: Row) -> tuple[list[Picked], list[Problem]]:
    """The columns that the heading names, and a warning that names the others."""
    picked: dict[str, Picked] = {}
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
        picked[column.key] = Picked(column, index, cell, _unit(rows, cell, unit, column))
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


def with_units(rows: Rows, picked: list[Picked], names: list[str], row: Row) -> list[Picked]:
    """The columns with the units that stand in a row of their own below the heading."""
    if len(row) < len(names):
        raise rows.odd_row(row[0].line, values_of(rows, names).replace("values", "units", 1))
    found: list[Picked] = []
    for one in picked:
        cell = row[one.index]
        text = cell.text
        inner = text[1:-1].strip() if text and _BRACKETS.get(text[0]) == text[-1] else text
        unit = _unit(rows, cell, inner, one.column)
        if unit and one.unit and unit != one.unit:
            raise rows.fault(cell, f"expected one unit, got {quoted(one.head.text)} and {quoted(text)}")
        found.append(Picked(one.column, one.index, one.head, unit or one.unit))
    return found


def by_order(rows: Rows, layout: Layout) -> list[Picked]:
    """The columns of a table without a heading."""
    first = _trimmed(rows.rows[0])
    most = len(layout.unnamed)
    if not layout.fewest <= len(first) <= most or not all(cell.is_number for cell in first):
        count = str(most) if layout.fewest == most else f"{layout.fewest} or {most}"
        expected = f"a heading with the columns {layout.said}, or {count} values"
        raise rows.odd_row(first[0].line, expected, commas(rows))
    # Without units, whole numbers everywhere may be what decimal commas have parted: -20,0,1.
    whole = all(_WHOLE.fullmatch(cell.text) for row in rows.rows for cell in row)
    if rows.separator == "," and len(first) > layout.fewest and whole and _any_but_zero(rows.rows):
        raise rows.odd_row(first[0].line, f"a heading with the columns {layout.said}", commas(rows))
    keys = zip(layout.unnamed, first, strict=False)
    return [Picked(layout.column(key), index, cell) for index, (key, cell) in enumerate(keys)]


def _any_but_zero(rows: tuple[Row, ...]) -> bool:
    return any(float(cell.text) != 0 for row in rows for cell in row[1:])


def commas(rows: Rows) -> str:
    """The cure where a comma that parts columns may have been meant as a decimal sign; else nothing."""
    if rows.separator != ",":
        return ""
    return "if the commas are decimal signs, part the columns with semicolons or tabs"


def values_of(rows: Rows, names: list[str]) -> str:
    """What a row should hold, in words."""
    parted = f" parted by {SEPARATORS[rows.separator]}" if len(names) > 1 else ""
    return f"{len(names)} values{parted}, {', '.join(name or 'one more' for name in names)}"
