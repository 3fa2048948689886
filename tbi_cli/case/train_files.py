"""What a train's mapping names outside of itself: the files of its vehicles, and tables of axle forces."""

from __future__ import annotations

import re
from collections.abc import Callable

from tbi_cli.case.files import read_source
from tbi_cli.case.messages import CaseError, Place, Problem, Source, quoted
from tbi_cli.case.simple_vehicles import MOST_FORCES
from tbi_cli.case.units import NUMBER
from tbi_cli.case.yaml12 import Entry, Items, Mapping, Scalar, entry_place, scalar_value

# Puts the mapping that an entry names in the place of the name; False if that failed, and was reported.
Include = Callable[[Entry, str], bool]


def resolve_train(train: Mapping, key: str, include: Include) -> list[Problem]:
    """Completes a train's mapping in place, so that it names no file any more; returns what is wrong.

    `train: {consist: ...}` needs no `model`; each `vehicle:` may be a file or a built-in name, relative to
    the file in which it stands; `csv:` becomes `positions` and `forces`.
    """
    problems = _complete(train, key)
    groups = train.get("consist")
    for number, group in enumerate(groups.items if isinstance(groups, Items) else ()):
        entry = group.entries.get("vehicle") if isinstance(group, Mapping) else None
        at = f"{key}.consist.{number}.vehicle"
        if entry is not None and include(entry, at) and isinstance(entry.value, Mapping):
            problems += _complete(entry.value, at)
    return problems


def _complete(vehicle: Mapping, key: str) -> list[Problem]:
    """Adds what a vehicle's mapping says of itself without words, and the numbers from its CSV file."""
    if "consist" in vehicle.entries and "model" not in vehicle.entries:
        place = vehicle.entries["consist"]
        vehicle.put("model", Scalar(place.source, place.line, place.column, place.width, 1, "consist"))
    model = vehicle.get("model")
    named = isinstance(model, Scalar) and model.value == "axle-forces"
    return _read_csv(vehicle, key) if named else []


def _read_csv(train: Mapping, key: str) -> list[Problem]:
    """Replaces `csv` by the `positions` and `forces` in that file, each value with its place there."""
    entry = train.entries.get("csv")
    if entry is None or not isinstance(entry.value, Scalar):
        return []
    named = entry.value
    # Reported once: a single force stands in for what could not be read.
    here = (named.source, named.line, named.column, 1, 1)
    positions, forces = (Items(*here, items=[Scalar(*here, value=value)]) for value in (0.0, 1.0))
    both = [name for name in ("positions", "forces") if name in train.entries]
    if both or not isinstance(named.value, str):
        train.put("positions", positions)
        train.put("forces", forces)
        text = f"expected either csv, or positions and forces, got csv and {' and '.join(both)}"
        return [Problem(entry_place(entry), f"{key}.csv", text)] if both else []
    del train.entries["csv"]
    path = named.source.folder / named.value
    problems: list[Problem] = []
    try:
        positions, forces = _columns(read_source(path, str(path)))
    except CaseError as error:
        first = error.problems[0]
        text = f"{first.key}: {first.text}".removeprefix(": ")
        problems = [first if first.place else Problem(entry_place(entry), f"{key}.csv", text)]
    train.put("positions", positions)
    train.put("forces", forces)
    return problems


def _columns(source: Source) -> tuple[Items, Items]:
    """The two columns of a table: numbers in SI or with a unit, one force a line, the first line a heading.

    Lines that are empty or begin with # are left out; commas, semicolons or tabs part the columns.  Raises
    CaseError.
    """
    columns = Items(source, 1, 1), Items(source, 1, 1)
    for number, line in enumerate(source.text.splitlines(), 1):
        cells = re.split("[,;\t]", line)
        texts = [cell.strip().strip('"').strip() for cell in cells]
        if not line.strip() or texts[0].startswith("#"):
            continue
        if not columns[0].items and not any(re.match(NUMBER, text) for text in texts):
            continue
        if len(texts) != 2 or not all(texts):
            text = f"expected two values, position and force, got {quoted(line.strip())}"
            raise CaseError([Problem(Place(source, number), "", text)])
        if len(columns[0].items) == MOST_FORCES:
            raise CaseError([Problem(Place(source, number), "", f"expected at most {MOST_FORCES} forces")])
        before = 0
        for column, cell, text in zip(columns, cells, texts, strict=True):
            start = before + len(cell) - len(cell.lstrip()) + 1
            column.items.append(Scalar(source, number, start, len(text), 1, scalar_value(text)))
            column.size += 1
            before += len(cell) + 1
    if not columns[0].items:
        raise CaseError([Problem(Place(source), "", "expected lines of position and force, got none")])
    return columns
