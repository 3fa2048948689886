"""Forms of a mapping that exclude each other: a change that gives one of them takes the other away."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from collections.abc import Mapping as Keys

from tbi_cli.case.axes import SHORT_NAMES
from tbi_cli.case.keys import fields_of, is_list, part_at
from tbi_cli.case.messages import Source
from tbi_cli.case.part import Part
from tbi_cli.case.places import Words, node_of
from tbi_cli.case.refinement import REFINE_KEYS
from tbi_cli.case.sample import DISTRIBUTIONS
from tbi_cli.case.sweep import SAMPLE
from tbi_cli.case.train import TRAINS
from tbi_cli.case.yaml12 import Entry, Items, Mapping, Node, Scalar

_RANGE_FORMS = (
    frozenset({"from", "to", "step", *REFINE_KEYS}),
    frozenset({"from", "to", "count"}),
    frozenset({"log"}),
)
_DISTRIBUTION_FORMS = tuple(frozenset({name}) for name in DISTRIBUTIONS)


def make_room(
    around: Mapping,
    words: Words,
    roots: Collection[Mapping],
    changes: Keys[str, Entry],
    fresh: Collection[int] = (),
) -> None:
    """Takes away from a mapping what cannot stand beside the keys that are about to be put there.

    words: of the mapping, in a case; roots: cases that tell of which model its train is, the first that does.
    fresh: the ids of entries that stay beside others of the same source: an author who gives two forms is
    told of it.
    """
    for key, entry in changes.items():
        if isinstance(entry.value, Scalar) and entry.value.value is None:
            continue
        for rival in list(_rivals(around, words, roots, key, entry.value)):
            old = around.entries[rival]
            if rival not in changes and not (id(old) in fresh and old.source is entry.source):
                del around.entries[rival]


def put_axis(sweep: Mapping, name: str, value: Node, source: Source) -> None:
    """Puts an axis into a sweep, in the place of those that set the same keys."""
    paths = set(SHORT_NAMES.get(name, (name,)))
    entry = Entry(value.line, value.column, value.width, source, value)
    entries, sweep.entries = sweep.entries, {}
    for key, other in entries.items():
        same = bool(paths & set(SHORT_NAMES.get(key, (key,))))
        sweep.entries.setdefault(name if same else key, entry if same else other)
    sweep.entries.setdefault(name, entry)


def becomes_mapping(words: Words, roots: Collection[Mapping]) -> bool:
    """Whether the list at these words is the short form of a mapping."""
    info = next((fields_of(around).get(str(words[-1])) for around in _parts(words[:-1], roots)), None)
    return info is not None and not is_list(info[1]) and any(True for _ in _parts(words, roots))


def axis_words(words: list[str], sweep: Node | None) -> list[str]:
    """Words below `sweep:` as the keys there: the name of an axis is dotted, and what is below it is not."""
    if words[0] == SAMPLE:
        over = node_of(sweep, [SAMPLE, "over"]) if isinstance(sweep, Mapping) else None
        return [*words[:2], *axis_words(words[2:], over)] if words[1:2] == ["over"] and words[2:] else words
    for count in range(len(words) - 1, 0, -1):
        axis = ".".join(words[:count])
        if isinstance(sweep, Mapping) and isinstance(sweep.get(axis), Mapping | Items):
            return [axis, *words[count:]]
    return [".".join(words)]


def _rivals(
    around: Mapping, words: Words, roots: Collection[Mapping], key: str, value: Node
) -> Iterator[str]:
    """The keys of a mapping that cannot stand beside a key with that value."""
    chosen = value.value if isinstance(value, Scalar) else None
    if words and words[-1] in ("train", "vehicle"):
        model = "consist" if key == "consist" else chosen if key == "model" else None
        if model in TRAINS:
            known = fields_of(TRAINS[str(model)]).keys() - ({"model"} if key == "consist" else set())
            yield from (other for other in around.entries if other not in known and other != key)
            return
    forms, needs = _forms(words, roots)
    allowed = {other for form in forms if key in form for other in form}
    for other in around.entries:
        excluded = allowed and other not in allowed and any(other in form for form in forms)
        name, word = needs.get(other, (key, chosen))
        if other != key and (excluded or (name == key and word != chosen)):
            yield other


def _forms(
    words: Words, roots: Collection[Mapping]
) -> tuple[tuple[frozenset[str], ...], Keys[str, tuple[str, str]]]:
    """The forms of the mapping at these words, and its keys that need a word at another key."""
    if words[:1] == ["sweep"]:
        sampled = len(words) == 4 and words[1] == SAMPLE
        return _DISTRIBUTION_FORMS if sampled else _RANGE_FORMS if len(words) == 2 else (), {}
    part = next(_parts(words, roots), Part)
    return part.forms, part.needs


def _parts(words: Words, roots: Collection[Mapping]) -> Iterator[type[Part]]:
    return (part for root in roots if (part := part_at(words, root)) is not None)
