"""Rails as measured, from a CSV file."""

from __future__ import annotations

from tbi_cli.case.heading import Column, Layout
from tbi_cli.case.messages import CaseError, Problem
from tbi_cli.case.table import read_table
from tbi_cli.case.track import LEVELS, MOST_POINTS, PLACES
from tbi_cli.case.yaml12 import Items, Mapping, Scalar, entry_place

RAILS = Layout(
    columns=(
        Column("x", ("x", "place", "position", "station", "chainage", "distance"), PLACES),
        Column("right", ("right", "right rail"), LEVELS),
        Column("left", ("left", "left rail"), LEVELS),
    ),
    needed=(("x",), ("right",)),
    unnamed=("x", "right", "left"),
    fewest=2,
    said="x, right and left (or x and right)",
    rows="points",
    most=MOST_POINTS,
)


def resolve_track(root: Mapping) -> list[Problem]:
    """Replaces `track.irregularity.profile.csv` by the numbers in that file, each with its place there.

    Returns what is wrong, or odd.
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
    both = [name for name in RAILS.unnamed if name in profile.entries]
    try:
        if both:
            text = f"expected either csv, or x, right and left, got csv and {' and '.join(both)}"
            raise CaseError([Problem(None, "", text)])
        path = named.source.folder / str(named.value)
        table = read_table(path, RAILS)
    except CaseError as error:
        first = error.problems[0]
        text = f"{first.key}: {first.text}".removeprefix(": ")
        # Reported once: two points stand in for what could not be read.
        here = (named.source, named.line, named.column, 1, 1)
        profile.entries.clear()
        for name, values in (("x", (0.0, 1.0)), ("right", (0.0, 0.0))):
            profile.put(name, Items(*here, items=[Scalar(*here, value=value) for value in values]))
        return [first if first.place else Problem(entry_place(entry), f"{key}.csv", text)]
    for name, column in table.columns.items():
        profile.put(name, column)
    return table.warnings
