"""The values of one swept key: a list, {from, to, step}, {from, to, count} or {log: {from, to, count}}."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import pairwise

from tbi_cli.case.fields import FACTOR, BadValueError, Numeric, Quantity
from tbi_cli.case.messages import Place, plain_number, quoted, suggestion
from tbi_cli.case.mixed_units import mixture
from tbi_cli.case.refinement import LEAST_PARTS, REFINE_KEYS, Refinement, read_refine, refined_values
from tbi_cli.case.spaced import by_ratio, by_steps
from tbi_cli.case.units import exact_si, has_unit
from tbi_cli.case.yaml12 import Items, Mapping, Node, entry_place, node_place, plain

MAX_VALUES = 500_000  # of all axes together
_FORMS = "a list of values, {from, to, step}, {from, to, count} or {log: {from, to, count}}"
_MOST_FAULTS = 100
_KEYS = ("from", "to", "step", "count", "log")
_ON_THE_GRID = Fraction(1, 10**9)  # of a step, by which `to` may be beside the grid
Given = dict[str, object]
Wanted = tuple[Node, Place, str, Numeric]


@dataclass(frozen=True)
class Fault:
    """One thing wrong with an axis, where it stands, and the key below the axis that it is about."""

    place: Place
    text: str
    key: str = ""


class AxisError(Exception):
    """All that is wrong with one axis."""

    def __init__(self, *faults: Fault) -> None:
        super().__init__("; ".join(fault.text for fault in faults))
        self.faults = faults


@dataclass(frozen=True)
class Range:
    """Reads the values of an axis.

    `leaf` is what its key accepts, `place` where it stands, `most` how many values there may be; `repeats`
    allows equal ones, `refines` a refinement, which is in `refinement` once the axis is read. `warnings` is
    what is odd about it.
    """

    leaf: Numeric
    place: Place
    most: int
    repeats: bool = False
    refines: bool = False
    refinement: Refinement | None = field(default=None, init=False)
    warnings: list[Fault] = field(default_factory=list, init=False)

    def read(self, node: Node) -> tuple[tuple[float, ...], Given | None]:
        """The values in SI, and the form in which they are given, if not as a list. Raises AxisError."""
        if isinstance(node, Items):
            return self._listed(node), None
        if not isinstance(node, Mapping) or not node.entries:
            raise AxisError(Fault(self.place, f"expected {_FORMS}, got {quoted(plain(node))}"))
        if self.refines and "refine" in node.entries:
            return self._refined(node)
        unknown = [key for key in node.entries if key not in _KEYS]
        if unknown:
            places = ((key, entry_place(node.entries[key])) for key in unknown)
            text = "unknown key; {}".format
            raise AxisError(*(Fault(place, text(suggestion(key, _KEYS)), key) for key, place in places))
        keys = set(node.entries)
        if keys == {"log"}:
            return self._logarithmic(node)
        if keys == {"from", "to", "step"}:
            return self._stepped(node)
        if keys == {"from", "to", "count"}:
            return self._counted(node)
        forms = _FORMS.removeprefix("a list of values, ")
        raise AxisError(Fault(self.place, f"expected {forms}, got {{{', '.join(node.entries)}}}"))

    def numbers(self, wanted: Iterable[Wanted]) -> list[float]:
        """The numbers at these nodes; the AxisError names those that are not accepted."""
        values: list[float] = []
        faults: list[Fault] = []
        wanted = list(wanted)
        for node, place, key, leaf in wanted:
            try:
                values.append(float(leaf.parse(plain(node))))
            except BadValueError as error:
                faults.append(Fault(place, str(error), key))
                if len(faults) == _MOST_FAULTS:
                    break
        if faults:
            raise AxisError(*faults)
        mixed = mixture([(plain(node), leaf) for node, _, _, leaf in wanted])
        if mixed:
            _, place, key, _ = wanted[mixed[0]]
            self.warnings.append(Fault(place, mixed[1], key))
        return values

    def _listed(self, node: Items) -> tuple[float, ...]:
        if not node.items:
            raise AxisError(Fault(self.place, "expected at least one value, got an empty list"))
        if len(node.items) > self.most:
            raise AxisError(Fault(self.place, self._too_many(len(node.items))))
        values = self.numbers((item, node_place(item), "", self.leaf) for item in node.items)
        first: dict[float, int] = {}
        for number, (value, item) in enumerate(zip(values, node.items, strict=True), 1):
            if value in first and not self.repeats:
                text = f"{quoted(plain(item))} is given twice, as value {first[value]} and value {number}"
                raise AxisError(Fault(node_place(item), text))
            first.setdefault(value, number)
        return tuple(values)

    def _stepped(self, node: Mapping) -> tuple[tuple[float, ...], Given]:
        (first, last, step), intervals, given = self._steps(node)
        values = by_steps(first, step, intervals + 1)
        if abs(last - first - intervals * step) > _ON_THE_GRID * abs(step):
            unit = self.leaf.dimension.unit if isinstance(self.leaf, Quantity) else "1"
            ends = [
                plain_number(end) + ("" if unit == "1" else f" {unit}") for end in (float(last), values[-1])
            ]
            text = f"{ends[0]} is not on a step; the last value is {ends[1]}"
            self.warnings.append(Fault(entry_place(node.entries["to"]), text, "to"))
        return self._checked(values, entry_place(node.entries["step"]), "step"), given

    def _steps(self, node: Mapping) -> tuple[tuple[Fraction, Fraction, Fraction], int, Given]:
        """From, to and step; how many steps there are; and how all is given."""
        dimension, example = (
            (self.leaf.dimension, self.leaf.example) if isinstance(self.leaf, Quantity) else (FACTOR, "1")
        )
        any_step = Quantity("step", dimension, example, "any")
        leaves: dict[str, Numeric] = {"from": self.leaf, "to": self.leaf, "step": any_step}
        (first, last, step), given = self._exact(node, leaves)
        where = entry_place(node.entries["step"])
        if step == 0:
            raise AxisError(Fault(where, "expected a step other than 0", "step"))
        if (last - first) * step < 0:
            direction = "positive" if last > first else "negative"
            ends = f"{float(first):.6g} to {float(last):.6g}"
            text = f"expected a {direction} step to go from {ends}, got {float(step):.6g}"
            raise AxisError(Fault(where, text, "step"))
        # `to` belongs to the axis when it lies on the grid, were it not for the rounding of what was written.
        intervals = math.floor((last - first) / step + _ON_THE_GRID)
        if intervals + 1 > self.most:
            raise AxisError(Fault(where, self._too_many(intervals + 1), "step"))
        return (first, last, step), intervals, given

    def _refined(self, node: Mapping) -> tuple[tuple[float, ...], Given]:
        """All values that {from, to, step, refine, tolerance, channels} may come to have."""
        keys = {"from", "to", "step", *REFINE_KEYS}
        wrong = [key for key in node.entries if key not in keys]
        absent = [key for key in ("from", "to", "step") if key not in node.entries]
        if wrong or absent:
            text = "expected {from, to, step, refine} and perhaps tolerance and channels"
            raise AxisError(Fault(self.place, f"{text}, got {{{', '.join(node.entries)}}}"))
        asked = {key: plain(node.entries[key].value) for key in REFINE_KEYS if key in node.entries}
        refinement, problems = read_refine(asked)
        if refinement is None:
            raise AxisError(*(Fault(entry_place(node.entries[key]), text, key) for key, text in problems))
        (first, last, step), intervals, given = self._steps(node)
        where = entry_place(node.entries["step"])
        if intervals < 1 or step < 0:
            raise AxisError(Fault(where, "expected a positive step, smaller than from to", "step"))
        if (intervals + 1) * LEAST_PARTS + 1 > self.most:
            raise AxisError(Fault(where, self._too_many(intervals * LEAST_PARTS + 1), "step"))
        values, refinement = refined_values((first, last), step, refinement, self.most)
        object.__setattr__(self, "refinement", refinement)
        shown = [] if refinement.channels is None else [("channels", list(refinement.channels))]
        return values, given | {"refine": "resonance", "tolerance": refinement.tolerance, **dict(shown)}

    def _counted(self, node: Mapping) -> tuple[tuple[float, ...], Given]:
        (first, last), given = self._exact(node, {"from": self.leaf, "to": self.leaf})
        count = self._count(node, "count", first, last)
        values = by_steps(first, (last - first) / max(count - 1, 1), count)
        return self._checked(values, entry_place(node.entries["count"]), "count"), given | {"count": count}

    def _logarithmic(self, outer: Mapping) -> tuple[tuple[float, ...], Given]:
        node = outer.entries["log"].value
        if not isinstance(node, Mapping) or set(node.entries) != {"from", "to", "count"}:
            raise AxisError(Fault(entry_place(outer.entries["log"]), "expected {from, to, count}", "log"))
        (first, last), given = self._exact(node, {"from": self.leaf, "to": self.leaf}, "log.")
        ends = (("from", first), ("to", last))
        bad = [
            Fault(entry_place(node.entries[key]), f"expected a positive number, got {end:.6g}", f"log.{key}")
            for key, end in ((key, float(end)) for key, end in ends)
            if end <= 0
        ]
        if bad:
            raise AxisError(*bad)
        count = self._count(node, "log.count", first, last)
        values = by_ratio(first, last, count)
        given = {"log": given | {"count": count}}
        return self._checked(values, entry_place(node.entries["count"]), "log.count"), given

    def _exact(
        self, node: Mapping, leaves: dict[str, Numeric], before: str = ""
    ) -> tuple[list[Fraction], Given]:
        """The numbers at these keys as they are written, and as they stand in a resolved case.

        There they are floats in SI, or with units where these would not give the same values: 100 km/h.
        """
        entries = [(node.entries[key], key, leaf) for key, leaf in leaves.items()]
        self.numbers((entry.value, entry_place(entry), before + key, leaf) for entry, key, leaf in entries)
        unit = self.leaf.dimension.unit if isinstance(self.leaf, Quantity) else "1"
        written = [plain(entry.value) for entry, _, _ in entries]
        exact = [exact_si(value, unit) for value in written]
        if all(exact_si(float(number), unit) == number for number in exact):
            return exact, {key: float(number) for key, number in zip(leaves, exact, strict=True)}
        texts = [str(value).strip() if has_unit(value) else f"{value} {unit}" for value in written]
        return exact, dict(zip(leaves, texts, strict=True))

    def _count(self, node: Mapping, key: str, first: Fraction, last: Fraction) -> int:
        entry = node.entries["count"]
        count = plain(entry.value)
        if isinstance(count, bool) or not isinstance(count, int) or count < 1:
            text = f"expected a whole number from 1 to {MAX_VALUES}, got {quoted(count)}"
            raise AxisError(Fault(entry_place(entry), text, key))
        if count > self.most:
            raise AxisError(Fault(entry_place(entry), self._too_many(count), key))
        if count == 1 and first != last:
            alone, left_out = (plain_number(float(end)) for end in (first, last))
            text = f"a count of 1 is the value {alone} alone; {left_out}, to, is left out"
            self.warnings.append(Fault(entry_place(entry), text, key))
        return count

    def _too_many(self, count: float) -> str:
        before = f" after the {MAX_VALUES - self.most} before" if self.most < MAX_VALUES else ""
        return f"expected at most {MAX_VALUES} values in all axes together, got {count:.7g}{before}"

    def _checked(self, values: tuple[float, ...], where: Place, key: str) -> tuple[float, ...]:
        """Values that follow from others: all different, and whole where the key wants whole numbers."""
        if any(a == b for a, b in pairwise(values)) and not self.repeats:
            raise AxisError(Fault(where, "the values are not all different", key))
        if isinstance(self.leaf, Quantity):
            return values
        odd = next((value for value in values if abs(value - round(value)) > 1e-9), None)
        if odd is not None:
            raise AxisError(Fault(where, f"expected whole numbers only, got {odd:.6g}", key))
        return tuple(float(round(value)) for value in values)
