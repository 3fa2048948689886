"""Where the keys of a case stand, so that what is found out after it was read names file and line too."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from tbi_cli.case.axes import Axis
from tbi_cli.case.messages import Place
from tbi_cli.case.yaml12 import Items, Mapping, Node, entry_place, node_place

# Names of axes and changes of studies are dotted themselves, of so many words at most.
_WORDS_OF_A_KEY = 10

Words = Sequence[str | int]


@dataclass(frozen=True)
class Places:
    """The tree that a case was read from: its file, files that it names, and options."""

    root: Mapping = field(repr=False)

    def of(self, key: str, axes: Sequence[Axis] = ()) -> Place:
        """The place of a dotted key: of the axis that sets it, or its own, or of what is around it."""
        for axis in axes:
            for column in axis.members or (axis,):
                if key in column.paths:
                    over = f"{axis.key}.over." if axis.key == "sample" else ""
                    return place_of(self.root, words_of(f"sweep.{over}{column.key}"))
        return place_of(self.root, words_of(key))


def words_of(key: str) -> list[str | int]:
    """The words of a dotted key; numbers are places in a list."""
    return [int(word) if word.isdigit() and len(word) < 7 else word for word in key.split(".")]


def place_of(root: Mapping, words: Words) -> Place:
    """The place of a key, or of the nearest mapping around it that is there."""
    return _found(root, words)[0]


def node_of(root: Node, words: Words) -> Node | None:
    """The value at a key; None if there is none."""
    return _found(root, words)[1]


def _found(root: Node, words: Words) -> tuple[Place, Node | None]:
    place, node = node_place(root), root
    done = 0
    while done < len(words):
        word = words[done]
        if isinstance(node, Items) and isinstance(word, int) and word < len(node.items):
            node, done = node.items[word], done + 1
            place = node_place(node)
            continue
        key, count = _entry(node, words[done : done + _WORDS_OF_A_KEY])
        if not count:
            return place, None
        assert isinstance(node, Mapping)
        entry, done = node.entries[key], done + count
        included = isinstance(entry.value, Mapping) and entry.value.source is not entry.source
        place, node = (node_place(entry.value) if included else entry_place(entry)), entry.value
    return place, node


def _entry(node: Node, words: Words) -> tuple[str, int]:
    """The key of a mapping that is the first of the words, or some of them with dots; and of how many."""
    if isinstance(node, Mapping):
        for count in range(1, len(words) + 1):
            key = ".".join(map(str, words[:count]))
            if key in node.entries:
                return key, count
    return "", 0
