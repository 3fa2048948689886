"""Rails as measured, from a CSV file."""

from __future__ import annotations

import re

from tbi_cli.case.files import read_source
from tbi_cli.case.messages import CaseError, Place, Problem, Source, quoted
from tbi_cli.case.track import MOST_POINTS
from tbi_cli.case.units import NUMBER
from tbi_cli.case.yaml12 import Items, Mapping, Scalar, entry_place, scalar_value

_COLUMNS = ("x", "right", "left")
_HEADING = re.compile(r"([a-z]+)\s*(?:[\[(]\s*([^\])]*?)\s*[\])])?", re.IGNORECASE)


def resolve_track(root: Mapping) -> list[Problem]:
    """Replaces `track.irregularity.profile.csv` by the numbers in that file, each with its place there.

    Returns what is wrong.
    """
    profile = root
    for word in ("track", "irregularity", "profile"):
        inner = profile.get(word)
        if not isinstance(inner, Mapping):
            return []
        profile = inner
    entry, key = profile.entries.get("csv"), "track.irregularity.profile"
    if entry is None or not isinstance(entry.value, Scalar) or not isinstance(entry.value.value, str):
        return []
    named = entry.value
    del profile.entries["csv"]
    both = [name for name in _COLUMNS if name in profile.entries]
    try:
        if both:
            text = f"expected either csv, or x, right and left, got csv and {' and '.join(both)}"
            raise CaseError([Problem(None, "", text)])
        path = named.source.folder / str(named.value)
        columns = _columns(read_source(path, str(path)))
    except CaseError as error:
        first = error.problems[0]
        text = f"{first.key}: {first.text}".removeprefix(": ")
        # Reported once: two points stand in for what could not be read.
        here = (named.source, named.line, named.column, 1, 1)
        profile.entries.clear()
        for name, values in (("x", (0.0, 1.0)), ("right", (0.0, 0.0))):
            profile.put(name, Items(*here, items=[Scalar(*here, value=value) for value in values]))
        return [first if first.place else Problem(entry_place(entry), f"{key}.csv", text)]
    for name, column in columns.items():
        profile.put(name, column)
    return []


def _columns(source: Source) -> dict[str, Items]:
    """The columns of a table by their names: numbers in SI, with a unit, or in the unit of the heading.

    Without a heading the columns are x and right, or x, right and left.  Lines that are empty or begin with #
    are left out; commas, semicolons or tabs part the columns.  Raises CaseError.
    """
    columns: dict[str, Items] = {}
    units: list[str] = []
    points = 0
    for number, line in enumerate(source.text.splitlines(), 1):
        cells = re.split("[,;\t]", line)
        texts = [cell.strip().strip('"').strip() for cell in cells]
        if not line.strip() or texts[0].startswith("#"):
            continue
        if not columns:
            heading = not any(re.match(NUMBER, text) for text in texts)
            names, units = _heading(texts, Place(source, number)) if heading else (_COLUMNS[: len(texts)], [])
            columns = {name: Items(source, number, 1) for name in names}
            if heading:
                continue
            if len(texts) not in (2, 3):
                text = f"expected two or three values, x, right and left, got {quoted(line.strip())}"
                raise CaseError([Problem(Place(source, number), "", text)])
        if len(texts) != len(columns) or not all(texts):
            text = f"expected {len(columns)} values, {', '.join(columns)}, got {quoted(line.strip())}"
            raise CaseError([Problem(Place(source, number), "", text)])
        points += 1
        if points > MOST_POINTS:
            raise CaseError([Problem(Place(source, number), "", f"expected at most {MOST_POINTS} points")])
        before = 0
        for k, (column, cell, text) in enumerate(zip(columns.values(), cells, texts, strict=True)):
            start = before + len(cell) - len(cell.lstrip()) + 1
            value = scalar_value(text)
            if units and units[k] and isinstance(value, int | float) and not isinstance(value, bool):
                value = f"{text} {units[k]}"
            column.items.append(Scalar(source, number, start, len(text), 1, value))
            column.size += 1
            before += len(cell) + 1
    if points == 0:
        raise CaseError([Problem(Place(source), "", "expected lines of x, right and left, got none")])
    return columns


def _heading(texts: list[str], place: Place) -> tuple[list[str], list[str]]:
    """Names and units of the columns from a heading such as "x [m], right [mm], left [mm]"."""
    found = [_HEADING.fullmatch(text) for text in texts]
    names = [match[1].lower() if match else "" for match in found]
    if names not in ([*_COLUMNS[:2]], [*_COLUMNS], ["x", "left", "right"]):
        text = "expected the columns x, right and left (or x and right), each with its unit if it is not m"
        raise CaseError([Problem(place, "", f"{text}, got {quoted(', '.join(texts))}")])
    return names, [match[2] or "" if match else "" for match in found]
