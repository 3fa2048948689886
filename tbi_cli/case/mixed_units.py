"""Numbers with a unit beside numbers without one: each is read as it stands, and that is said."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from tbi_cli.case.fields import Numeric, Quantity
from tbi_cli.case.keys import UnknownKeyError, find_number
from tbi_cli.case.messages import Problem, plain_number, quoted
from tbi_cli.case.units import has_unit
from tbi_cli.case.yaml12 import Items, Mapping, Node, Scalar, node_place, plain


def mixture(values: Sequence[tuple[object, Numeric]]) -> tuple[int, str] | None:
    """Where the first number without a unit stands among others with one, and what was read.

    `values` are accepted ones, as written, each with what its key takes.  None if all have a unit, or none.
    """
    first: dict[bool, int] = {}
    for place, (value, leaf) in enumerate(values):
        united = has_unit(value) if isinstance(leaf, Quantity) else None
        if united is not None:
            first.setdefault(united, place)
    if len(first) < 2:
        return None
    bare, full = (_reading(*values[first[kind]]) for kind in (False, True))
    return first[False], f"some numbers have a unit and some have none; {bare} and {full}"


def _reading(value: object, leaf: Numeric) -> str:
    assert isinstance(leaf, Quantity)
    unit = "" if leaf.dimension.unit == "1" else f" {leaf.dimension.unit}"
    return f"{quoted(value)} was read as {plain_number(leaf.parse(value))}{unit}"


def mixed_lists(root: Mapping, train_model: str | None) -> Iterator[Problem]:
    """Warnings about the lists of numbers of a valid case, those of its sweep aside."""
    lists = list(_lists(root, ""))
    case = plain(root) if lists else {}
    for key, node in lists:
        for path in (f"{key}.0", f"{key}.positions.0"):  # the stations of a bridge need not be named so
            try:
                leaf, _ = find_number(path, case, train_model)
            except UnknownKeyError:
                continue
            found = mixture([(plain(item), leaf) for item in node.items])
            if found:
                yield Problem(node_place(node.items[found[0]]), key, found[1])
            break


def _lists(node: Node, key: str) -> Iterator[tuple[str, Items]]:
    """The lists with texts in them, which may be numbers with a unit, by their dotted keys."""
    if isinstance(node, Mapping):
        for word, entry in node.entries.items():
            if key or word != "sweep":
                yield from _lists(entry.value, f"{key}.{word}" if key else word)
    elif isinstance(node, Items):
        if any(isinstance(item, Scalar) and isinstance(item.value, str) for item in node.items):
            yield key, node
        for number, item in enumerate(node.items):
            if not isinstance(item, Scalar):
                yield from _lists(item, f"{key}.{number}")
