"""The rows and cells of a text table, each with its place; what they mean is not asked here."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator
from dataclasses import dataclass

from tbi_cli.case.messages import CaseError, Place, Problem, Source, quoted

SEPARATORS = {";": "semicolons", "\t": "tabs", ",": "commas", " ": "spaces"}
_STATED = re.compile(r'"?sep=([;,\t])"?', re.IGNORECASE)
_QUOTED = re.compile(r'"[^"]*"')
# Between spaces, a unit in brackets belongs to the name before it.
_WORD = re.compile(r'"([^"]*)"|[^\s"]+(?:\s*[\[(][^\])]*[\])])?')
_SPACED_NUMBERS = re.compile(r"[0-9]\s+[-+]?[.0-9]")
_BARE_NUMBER = re.compile(r"[-+]?[.,]?[0-9]")
# A number with a comma in it, and what follows: an exponent, a unit, or more than a number should have.
_COMMA = re.compile(r"([-+]?[0-9]*),([0-9]+)((?:[eE][-+]?[0-9]+)?)(.*)", re.DOTALL)
_POINT = re.compile(r"[-+]?[0-9]*\.[0-9]")
_MAYBE_THOUSANDS = re.compile(r"[-+]?[1-9][0-9]{0,2},[0-9]{3}(?![0-9eE])")


@dataclass(frozen=True, slots=True)
class Cell:
    """A cell without its quotes and blanks, and where it begins in its line, from 1."""

    text: str
    line: int
    column: int

    @property
    def is_number(self) -> bool:
        """Whether it begins like one."""
        return _BARE_NUMBER.match(self.text) is not None


@dataclass(frozen=True)
class Rows:
    """The lines of a table that are neither empty nor comments, parted by one separator.

    `comment` is the last line that begins with # before the first of them, a blank in the place of that sign.
    """

    source: Source
    separator: str
    rows: tuple[tuple[Cell, ...], ...]
    comment: tuple[int, str] | None = None

    def fault(self, cell: Cell, text: str) -> CaseError:
        """What is wrong with one cell."""
        place = Place(self.source, cell.line, cell.column, max(len(cell.text), 1))
        return CaseError([Problem(place, "", text)])

    def odd_row(self, line: int, expected: str, cure: str = "") -> CaseError:
        """What is wrong with a whole line."""
        text = f"expected {expected}, got {quoted(self.source.line(line).strip())}"
        return CaseError([Problem(Place(self.source, line), "", text + (f"; {cure}" if cure else ""))])


def read_rows(source: Source) -> Rows:
    """The cells of a table.  The first line that counts tells what parts them: `;`, a tab, `,` or blanks.

    Raises CaseError where that cannot be told.
    """
    comment: tuple[int, str] | None = None
    stated = ""
    lines: list[tuple[int, str]] = []
    for number, line in enumerate(re.split(r"\r\n|\r|\n", source.text), 1):
        text = line.strip().lstrip('"').lstrip()
        if not lines and text.startswith("#"):
            comment = number, line.replace("#", " ", 1).replace('"', " ", line.count('"') % 2)
        if not lines and (found := _STATED.fullmatch(line.strip(" "))):
            stated = found[1]
        elif text and not text.startswith("#"):
            lines.append((number, line))
    separator = stated or (_separator(source, *lines[0]) if lines else ",")
    rows = tuple(tuple(cells_of(source, line, number, separator)) for number, line in lines)
    return Rows(source, separator, tuple(row for row in rows if any(cell.text for cell in row)), comment)


def _separator(source: Source, number: int, line: str) -> str:
    bare = _QUOTED.sub('""', line)
    found = next((separator for separator in SEPARATORS if separator in bare.strip()), " ")
    if found == "," and any(_SPACED_NUMBERS.search(cell) for cell in bare.split(",")):
        text = "a comma may part the columns here or be a decimal sign; part them with semicolons or tabs"
        raise CaseError([Problem(Place(source, number), "", f"{text}, got {quoted(line.strip())}")])
    return found


def cells_of(source: Source, line: str, number: int, separator: str) -> Iterator[Cell]:
    """The cells of one line."""
    if separator == " ":
        parts = [found[1] if found[1] is not None else found[0] for found in _WORD.finditer(line)]
    else:
        try:
            (parts,) = csv.reader([line], delimiter=separator, skipinitialspace=True)
        except (csv.Error, ValueError):
            text = f"expected cells parted by {SEPARATORS[separator]}, got {quoted(line.strip())}"
            raise CaseError([Problem(Place(source, number), "", text)]) from None
    start = 0
    for part in parts:
        text = part.strip()
        found = max(line.find(text, start), start)
        yield Cell(text.replace("\N{MINUS SIGN}", "-"), number, found + 1)
        start = found + len(text)


def with_points(rows: Rows, cells: list[Cell]) -> list[Cell]:
    """These cells with a decimal point in each number that has a decimal comma.

    Raises CaseError where a comma parts the columns, where both signs occur, and where every comma may be one
    of thousands; and where a cell holds what parts columns in other tables.
    """
    for cell in cells:
        if any(separator in cell.text for separator in ";\t"):
            before = f"columns parted by {SEPARATORS[rows.separator]}, as on line {rows.rows[0][0].line}"
            raise rows.odd_row(cell.line, before)
    commas = [cell for cell in cells if _COMMA.match(cell.text)]
    if not commas:
        return cells
    first = commas[0]
    if rows.separator == ",":
        text = f"a comma parts the columns here, so that {quoted(first.text)} cannot be read"
        raise rows.fault(first, f"{text}; write a decimal point, or part the columns with semicolons")
    point = next((cell for cell in cells if _POINT.match(cell.text)), None)
    if point is not None:
        text = f"expected one decimal sign, got {quoted(point.text)} and {quoted(first.text)}"
        raise rows.fault(first, f"{text}; write numbers without signs between thousands")
    for cell in commas:
        if "," in _COMMA.fullmatch(cell.text)[4]:  # type: ignore[index]
            raise rows.fault(
                cell, f"expected a number without signs between thousands, got {quoted(cell.text)}"
            )
    if all(_MAYBE_THOUSANDS.match(cell.text) for cell in commas):
        plain, whole = first.text.replace(",", ".", 1), first.text.replace(",", "", 1)
        raise rows.fault(first, f"{quoted(first.text)} may be {plain} or {whole}; write one of these")
    return [Cell(_COMMA.sub(r"\1.\2\3\4", cell.text), cell.line, cell.column) for cell in cells]
