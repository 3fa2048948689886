"""What a train's mapping names outside of itself: the files of its vehicles, and tables of axle forces."""

from __future__ import annotations

from collections.abc import Callable
from decimal import Decimal

from tbi_cli.case.fields import LENGTH, BadValueError, Quantity
from tbi_cli.case.heading import Column, Layout
from tbi_cli.case.messages import CaseError, Problem, quoted
from tbi_cli.case.simple_vehicles import FORCE_OF_AXLE, MOST_FORCES, POSITION_OF_AXLE
from tbi_cli.case.table import Table, read_table
from tbi_cli.case.yaml12 import Entry, Items, Mapping, Scalar, entry_place, node_place

SPACING = Quantity("distance behind the axle before", LENGTH, "2.5 m", "not negative")
_WHICH = (
    "may be a position or a spacing: name it position (from the first axle) or spacing (from the axle before)"
)
_MASS = "is not a force: multiply by 9.81 m/s^2, and name the column force"
AXLES = Layout(
    columns=(
        Column("position", ("position", "positions", "axle position", "pos", "x"), POSITION_OF_AXLE),
        Column("spacing", ("spacing", "spacings", "axle spacing", "pitch"), SPACING, may_begin_empty=True),
        Column(
            "force",
            ("force", "forces", "axle force", "load", "axle load", "weight", "axle weight", "p", "f"),
            FORCE_OF_AXLE,
        ),
    ),
    needed=(("position", "spacing"), ("force",)),
    unnamed=("position", "force"),
    fewest=2,
    said="position (or spacing) and force",
    rows="forces",
    most=MOST_FORCES,
    refused={"distance": _WHICH, "axle distance": _WHICH, "mass": _MASS, "axle mass": _MASS},
)
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
    """Replaces `csv` by the `positions` and `forces` in that file, each value with its place there.

    Returns what is wrong, or odd.
    """
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
        table = read_table(path, AXLES)
        problems += table.warnings
        positions, forces = _positions_and_forces(table)
    except CaseError as error:
        first = error.problems[0]
        text = f"{first.key}: {first.text}".removeprefix(": ")
        problems = [first if first.place else Problem(entry_place(entry), f"{key}.csv", text)]
    train.put("positions", positions)
    train.put("forces", forces)
    return problems


def _positions_and_forces(table: Table) -> tuple[Items, Items]:
    """The two lists of a train; positions may be given by the spacing of the axles.  Raises CaseError."""
    spacings = table.columns.get("spacing")
    if spacings is None:
        return table.columns["position"], table.columns["force"]
    positions = Items(spacings.source, spacings.line, spacings.column, spacings.width, spacings.size)
    # Decimals, so that 2.6 and 7.8 are 10.4.
    position = Decimal(0)
    united: set[bool] = set()
    for number, item in enumerate(spacings.items):
        assert isinstance(item, Scalar)
        written = item.value
        if number == 0 and written == "":
            written = 0.0
        try:
            spacing = SPACING.parse(written)
        except BadValueError as error:
            raise CaseError([Problem(node_place(item), "spacing", str(error))]) from None
        if spacing != 0:
            united.add(isinstance(written, str))
        text = ""
        if number == 0 and spacing != 0:
            text = "expected 0 or nothing for the first axle: a spacing is the distance to the axle before"
        elif len(united) > 1:
            text = "expected a unit for every spacing, or for none, best in the heading"
        if text:
            raise CaseError([Problem(node_place(item), "spacing", f"{text}, got {quoted(written)}")])
        position += Decimal(repr(spacing))
        place = (item.source, item.line, item.column, item.width, 1)
        positions.items.append(Scalar(*place, value=float(position)))
    return positions, table.columns["force"]
