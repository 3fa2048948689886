"""The sweep of a case file as axes in SI, every value checked against its key."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from tbi_cli.case.axes import SHORT_NAMES, Axis, joined
from tbi_cli.case.fields import Numeric, Quantity
from tbi_cli.case.keys import Chain, UnknownKeyError, find_number
from tbi_cli.case.messages import Place, Problem, quoted, suggestion
from tbi_cli.case.ranges import MAX_VALUES, AxisError, Fault, Range
from tbi_cli.case.sample import read_sample
from tbi_cli.case.yaml12 import Entry, Items, Mapping, Node, Scalar, entry_place, plain

MAX_GRID = 10**12
ZIP, SAMPLE = "zip", "sample"


class Sweep:
    """Reads the axes under `sweep:`, of at most `most` values together.

    Afterwards `axes`, `problems` and `warnings` are what there is to know, and `size` is how many values
    there are.
    """

    def __init__(self, root: Mapping, most: int = MAX_VALUES) -> None:
        self._most = most
        self.size = 0
        self.axes: tuple[Axis, ...] = ()
        self.problems: list[Problem] = []
        self.warnings: list[Problem] = []
        self._case = plain(
            Mapping(root.source, 1, 1, entries={k: v for k, v in root.entries.items() if k != "sweep"})
        )
        train = self._case.get("train")
        model = train.get("model") if isinstance(train, dict) else None
        self._train_model = model if isinstance(model, str) else None
        entry = root.entries.get("sweep")
        if entry is None or (isinstance(entry.value, Scalar) and entry.value.value is None):
            return
        if isinstance(entry.value, Mapping):
            self._read(entry, entry.value)
        else:
            text = "expected a mapping of axes such as {velocity: {from: 2, to: 200, step: 0.5}}, "
            self._report("", Fault(entry_place(entry), text + f"got {quoted(plain(entry.value))}"))

    def _read(self, entry: Entry, sweep: Mapping) -> None:
        zipped = [name for group in _groups(sweep.get(ZIP)) for name in group]
        axes: list[Axis] = []
        for key, axis_entry in sweep.entries.items():
            if key == ZIP:
                continue
            most = self._most - self.size
            try:
                if key == SAMPLE:
                    axis, odd = read_sample(axis_entry, self.number_at, most)
                    self.warnings += [_problem(key, fault) for fault in odd]
                else:
                    axis = self.axis(key, axis_entry, most, repeats=key in zipped)
                self.size += len(axis) * max(len(axis.members), 1)
                clash = next((a for a in axes if set(a.paths) & set(axis.paths) or a.name == axis.name), None)
                if clash:
                    text = f"sets the same key as the axis {clash.key}"
                    raise AxisError(Fault(entry_place(axis_entry), text))
                axes.append(axis)
            except AxisError as error:
                for fault in error.faults:
                    self._report(key, fault)
        if ZIP in sweep.entries and not self.problems:
            try:
                axes = _zipped(axes, sweep.entries[ZIP])
            except AxisError as error:
                for fault in error.faults:
                    self._report(ZIP, fault)
        size = math.prod(len(axis) for axis in axes)
        if size > MAX_GRID:
            self._report(
                "", Fault(entry_place(entry), f"expected a grid of at most 1e12 cases, got {size:.3g}")
            )
        self.axes = tuple(axes)

    def _report(self, key: str, fault: Fault) -> None:
        self.problems.append(_problem(key, fault))

    def axis(self, key: str, entry: Entry, most: int, repeats: bool) -> Axis:
        """One axis of at most `most` values; `repeats` allows equal ones. Raises AxisError."""
        place = entry_place(entry)
        leaf, paths, chains = self.number_at(key, place)
        refines = paths == ("velocity",) and not repeats
        reader = Range(leaf, place, most, repeats, refines)
        values, given = reader.read(entry.value)
        self.warnings += [_problem(key, fault) for fault in reader.warnings]
        return Axis(
            key=key,
            name=key.replace(".", "_"),
            paths=paths,
            values=values,
            units=leaf.dimension.unit if isinstance(leaf, Quantity) else "1",
            long_name=leaf.text,
            whole=not isinstance(leaf, Quantity),
            chains=chains,
            given=given,
            refinement=reader.refinement,
        )

    def number_at(self, key: str, place: Place) -> tuple[Numeric, tuple[str, ...], tuple[Chain, ...]]:
        """What the numbers of an axis must be, and the dotted keys and chains of fields that it sets."""
        paths = SHORT_NAMES.get(key, (key,))
        bridge = self._case.get("bridge")
        if key == "damping" and not (isinstance(bridge, dict) and bridge.get("left") is not None):
            paths = paths[:1]
        if key == "car_body_mass" and self._train_model == "consist":
            groups = self._case["train"].get("consist")
            count = len(groups) if isinstance(groups, list) else 0
            paths = tuple(f"train.consist.{i}.vehicle.car_body.mass" for i in range(count)) or paths
        found: list[tuple[Numeric, Chain]] = []
        for path in paths:
            try:
                found.append(find_number(path, self._case, self._train_model))
            except UnknownKeyError as error:
                text = str(error) if path == key else f"a {self._train_model} train has no {path}"
                raise AxisError(Fault(place, text)) from None
        if any(chain[-1] != found[0][1][-1] for _, chain in found):
            text = "the two beams give their damping in different forms, so that one axis cannot set both"
            raise AxisError(Fault(place, text))
        return found[0][0], paths, tuple(chain for _, chain in found)


def _problem(key: str, fault: Fault) -> Problem:
    return Problem(fault.place, ".".join(filter(None, ("sweep", key, fault.key))), fault.text)


def _groups(node: Node | None) -> list[list[Any]]:
    """The groups of axis names under `zip:`: one list of names, or a list of such lists."""
    value = plain(node) if isinstance(node, Items) else []
    return value if value and all(isinstance(item, list) for item in value) else [value]


def _zipped(axes: list[Axis], entry: Entry) -> list[Axis]:
    """The axes with those named together under `zip:` made one, in the place of the first of them."""
    place = entry_place(entry)
    named = {axis.key: axis for axis in axes if not axis.members}
    groups = _groups(entry.value)
    result = list(axes)
    for group in groups:
        if len(group) < 2 or not all(isinstance(name, str) for name in group):
            text = "expected a list of two or more axes that move together, or a list of such lists"
            raise AxisError(Fault(place, f"{text}, got {quoted(plain(entry.value))}"))
        for number, name in enumerate(group):
            if name in group[:number] or (name not in named and any(axis.key == name for axis in axes)):
                raise AxisError(Fault(place, f"{quoted(name)} stands there twice"))
            if name not in named:
                text = f"{quoted(name)} is not an axis of this sweep; {suggestion(name, named)}"
                raise AxisError(Fault(place, text))
        members = tuple(named.pop(name) for name in group)
        if len({len(axis) for axis in members}) > 1:
            counts = ", ".join(f"{axis.key} has {len(axis)}" for axis in members)
            raise AxisError(Fault(place, f"expected axes with the same number of values, but {counts}"))
        rows = list(zip(*(axis.values for axis in members), strict=True))
        if len(set(rows)) < len(rows):
            raise AxisError(Fault(place, f"the values of {', '.join(group)} are together not all different"))
        name = "_and_".join(axis.name for axis in members)
        position = min(result.index(axis) for axis in members)
        result[position] = joined(ZIP, name, members, f"number of the case along {', '.join(group)}")
        result = [axis for axis in result if axis not in members]
    return result


def missing_but_swept(axes: tuple[Axis, ...]) -> Iterator[tuple[str, float]]:
    """Dotted keys that axes set, with the first value of each."""
    for axis in axes:
        if axis.members:
            yield from missing_but_swept(axis.members)
        for path in axis.paths if not axis.members else ():
            yield path, int(axis.values[0]) if axis.whole else axis.values[0]
