"""Random designs: `sample:` under `sweep:` as one axis on which all its keys move together."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from tbi_cli.case.axes import Axis, joined
from tbi_cli.case.fields import BadValueError, Numeric, Quantity
from tbi_cli.case.keys import Chain
from tbi_cli.case.messages import Place, quoted, suggestion
from tbi_cli.case.ranges import AxisError, Fault, Range, Wanted
from tbi_cli.case.yaml12 import Entry, Items, Mapping, entry_place, node_place, plain

KINDS = ("latin-hypercube", "sobol", "random")
KEYS = ("kind", "count", "seed", "over")
# Distribution -> what its numbers are.
DISTRIBUTIONS = {
    "uniform": ("low", "high"),
    "loguniform": ("low", "high"),
    "normal": ("mean", "standard deviation"),
    "triangular": ("low", "mode", "high"),
}
WITHIN = "within"
MAX_KEYS = 50
NumberAt = Callable[[str, Place], tuple[Numeric, tuple[str, ...], tuple[Chain, ...]]]


@dataclass(frozen=True)
class Distribution:
    """How one key is distributed: its kind, its numbers in SI, and the bounds to which it is cut."""

    kind: str
    numbers: tuple[float, ...]
    within: tuple[float, float] | None

    def quantiles(self, probabilities: Any) -> Any:
        """Values (n,) at these cumulative probabilities (n,), by the inverse of the distribution function."""
        from scipy import stats

        low, high = self.numbers[0], self.numbers[-1]
        spread: Any
        if self.kind == "uniform":
            spread = stats.uniform(low, high - low)
        elif self.kind == "loguniform":
            spread = stats.loguniform(low, high)
        elif self.kind == "triangular":
            spread = stats.triang((self.numbers[1] - low) / (high - low), low, high - low)
        else:
            spread = stats.norm(low, high)
        if self.within:
            first, last = spread.cdf(self.within[0]), spread.cdf(self.within[1])
            probabilities = first + probabilities * (last - first)
        return spread.ppf(probabilities)

    def given(self) -> dict[str, object]:
        """As in a case file, in SI."""
        given: dict[str, object] = {self.kind: list(self.numbers)}
        return given | {WITHIN: list(self.within)} if self.within else given


def read_sample(entry: Entry, number_at: NumberAt, most: int) -> tuple[Axis, list[Fault]]:
    """The axis `sample` of at most `most` cases, and what is odd about it. Raises AxisError.

    The draws depend on the seed, the kind, the count and the order of the keys alone, so that every shard
    of a run and every resumed run sees the same.
    """
    place = entry_place(entry)
    node = entry.value
    if not isinstance(node, Mapping) or not set(node.entries) >= {"kind", "count", "over"}:
        raise AxisError(
            Fault(place, f"expected a mapping with the keys {', '.join(KEYS)}, got {quoted(plain(node))}")
        )
    faults = [
        Fault(entry_place(node.entries[key]), f"unknown key; {suggestion(key, KEYS)}", key)
        for key in node.entries
        if key not in KEYS
    ]
    kind, count = plain(node.entries["kind"].value), plain(node.entries["count"].value)
    seed = plain(node.entries["seed"].value) if "seed" in node.entries else 0
    if not isinstance(kind, str) or kind not in KINDS:
        faults.append(
            Fault(
                entry_place(node.entries["kind"]),
                f"expected one of {', '.join(KINDS)}, got {quoted(kind)}",
                "kind",
            )
        )
    over = node.entries["over"]
    if not isinstance(over.value, Mapping) or not 1 <= len(over.value.entries) <= MAX_KEYS:
        text = f"expected a mapping of 1 to {MAX_KEYS} keys to distributions, got {quoted(plain(over.value))}"
        raise AxisError(*faults, Fault(entry_place(over), text, "over"))
    most //= len(over.value.entries)
    for key, value, low, high in (("count", count, 1, most), ("seed", seed, 0, 2**32 - 1)):
        if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
            text = f"expected a whole number from {low} to {high}, got {quoted(value)}"
            faults.append(Fault(entry_place(node.entries[key]), text, key))
    found: list[tuple[str, Distribution, Quantity, tuple[str, ...], tuple[Chain, ...]]] = []
    odd: list[Fault] = []
    for key, item in over.value.entries.items():
        where = entry_place(item)
        try:
            leaf, paths, chains = number_at(key, where)
            if not isinstance(leaf, Quantity):
                raise AxisError(Fault(where, "a whole number cannot be drawn from a distribution"))
            if any(set(paths) & set(other[3]) for other in found):
                raise AxisError(Fault(where, "sets the same key as another one"))
            distribution, mixed = _distribution(item, leaf, where)
            found.append((key, distribution, leaf, paths, chains))
            odd += _below(f"over.{key}", mixed)
        except AxisError as error:
            faults += _below(f"over.{key}", error.faults)
    if faults:
        raise AxisError(*faults)
    draws = _draws(kind, count, len(found), seed)
    members = []
    for column, (key, distribution, leaf, paths, chains) in enumerate(found):
        values = tuple(float(value) for value in distribution.quantiles(draws[:, column]))
        _check(values, leaf, entry_place(over.value.entries[key]), key)
        name = key.replace(".", "_")
        members.append(Axis(key, name, paths, values, leaf.dimension.unit, leaf.text, chains=chains))
    axis = joined("sample", "sample", tuple(members), "number of the case in the sample")
    given = {"kind": kind, "count": count, "seed": seed, "over": {key: d.given() for key, d, *_ in found}}
    return Axis(**{**axis.__dict__, "given": given}), odd


def _below(key: str, faults: Iterable[Fault]) -> list[Fault]:
    return [Fault(fault.place, fault.text, f"{key}.{fault.key}".rstrip(".")) for fault in faults]


def _draws(kind: str, count: int, keys: int, seed: int) -> Any:
    """Cumulative probabilities (count, keys), strictly inside of (0, 1)."""
    import numpy as np
    from scipy.stats import qmc

    generator = np.random.default_rng(seed)
    if kind == "random":
        draws = generator.random((count, keys))
    elif kind == "latin-hypercube":
        draws = qmc.LatinHypercube(keys, rng=generator).random(count)
    else:
        # Sobol points come in powers of two; the first `count` of them are taken.
        draws = qmc.Sobol(keys, rng=generator).random_base2(math.ceil(math.log2(count)))[:count]
    tiny = np.finfo(float).eps
    return np.clip(draws, tiny, 1 - tiny)


def _distribution(entry: Entry, leaf: Quantity, place: Place) -> tuple[Distribution, list[Fault]]:
    node = entry.value
    kinds = [key for key in node.entries if key in DISTRIBUTIONS] if isinstance(node, Mapping) else []
    if not isinstance(node, Mapping) or len(kinds) != 1 or set(node.entries) - {*kinds, WITHIN}:
        forms = ", ".join(f"{{{kind}: [{', '.join(what)}]}}" for kind, what in DISTRIBUTIONS.items())
        got = (
            f"{{{', '.join(node.entries)}}}"
            if isinstance(node, Mapping) and node.entries
            else quoted(plain(node))
        )
        raise AxisError(Fault(place, f"expected one of {forms}, got {got}"))
    kind = kinds[0]
    spread = Quantity(leaf.text, leaf.dimension, leaf.example, "positive")
    leaves = [spread if what == "standard deviation" else leaf for what in DISTRIBUTIONS[kind]]
    wanted = _wanted(node.entries[kind], kind, DISTRIBUTIONS[kind], leaves)
    if WITHIN in node.entries:
        wanted += _wanted(node.entries[WITHIN], WITHIN, ("low", "high"), [leaf, leaf])
    reader = Range(leaf, place, len(wanted))
    values = reader.numbers(wanted)
    numbers, within = values[: len(leaves)], values[len(leaves) :]
    for key, rising in ((kind, numbers if kind != "normal" else []), (WITHIN, within)):
        if rising and not (sorted(rising) == rising and rising[0] < rising[-1]):
            raise AxisError(Fault(entry_place(node.entries[key]), "expected rising numbers", key))
    if kind == "loguniform" and numbers[0] <= 0:
        raise AxisError(Fault(entry_place(node.entries[kind]), "expected positive numbers", kind))
    return Distribution(kind, tuple(numbers), (within[0], within[1]) if within else None), reader.warnings


def _wanted(entry: Entry, key: str, names: Sequence[str], leaves: Sequence[Quantity]) -> list[Wanted]:
    node, place = entry.value, entry_place(entry)
    if not isinstance(node, Items) or len(node.items) != len(names):
        raise AxisError(Fault(place, f"expected [{', '.join(names)}], got {quoted(plain(node))}", key))
    return [(item, node_place(item), key, leaf) for item, leaf in zip(node.items, leaves, strict=True)]


def _check(values: Sequence[float], leaf: Quantity, place: Place, key: str) -> None:
    """Draws of an unbounded distribution may leave what the key allows."""
    for number, value in enumerate(values, 1):
        try:
            leaf.checked(value, value)
        except BadValueError as error:
            hint = "bound the distribution with within: [low, high]"
            raise AxisError(Fault(place, f"draw {number}: {error}; {hint}", f"over.{key}")) from None
