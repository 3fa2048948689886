"""YAML with the numbers and booleans of YAML 1.2, where every key and value knows its place.

PyYAML follows YAML 1.1, where `1.176e6` is a string and `on` is true. Here its scanner is used (libyaml),
and scalars are read by the core schema of YAML 1.2. Left out on purpose: tags, merge keys, several
documents; a case file has no use for them. Nesting and size are bounded, so that no file takes long.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import yaml

from tbi_cli.case.messages import UNPRINTABLE, CaseError, Place, Problem, Source

MAX_DEPTH = 24
MAX_NODES = 100_000
MAX_KEYS = 200  # of one mapping
MAX_ALL_KEYS = 20_000
_INTEGER = re.compile(r"[-+]?[0-9]+\Z")
_FLOAT = re.compile(r"[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?\Z")
_OTHER: dict[str, object] = {
    **dict.fromkeys(("", "~", "null", "Null", "NULL"), None),
    **dict.fromkeys(("true", "True", "TRUE"), True),
    **dict.fromkeys(("false", "False", "FALSE"), False),
    **{sign + word: float(sign + "inf") for sign in ("", "+", "-") for word in (".inf", ".Inf", ".INF")},
    **dict.fromkeys((".nan", ".NaN", ".NAN"), float("nan")),
}
_LOADER: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)

type_of_scalar = str | int | float | bool | None


@dataclass(slots=True)
class Node:
    """A value and where it stands. `size` counts the values in it, repeated ones each time."""

    source: Source
    line: int
    column: int
    width: int = 1
    size: int = 1


@dataclass(slots=True)
class Scalar(Node):
    value: type_of_scalar = None


@dataclass(slots=True)
class Items(Node):
    items: list[Node] = field(default_factory=list)


@dataclass(slots=True)
class Entry:
    """A key of a mapping, with its value and its own place."""

    line: int
    column: int
    width: int
    source: Source
    value: Node


@dataclass(slots=True)
class Mapping(Node):
    entries: dict[str, Entry] = field(default_factory=dict)

    def put(self, key: str, value: Node) -> None:
        """Sets a key from elsewhere (an option); its place is that of the value."""
        self.entries[key] = Entry(value.line, value.column, value.width, value.source, value)

    def get(self, key: str) -> Node | None:
        """The value of `key`, or None."""
        entry = self.entries.get(key)
        return entry.value if entry else None


def entry_place(entry: Entry) -> Place:
    """The place of a key, with that of its value when both stand on one line."""
    value = entry.value
    beside = isinstance(value, Scalar) and value.source is entry.source and value.line == entry.line
    shown = (value.column, value.width) if beside and value.column != entry.column else (0, 0)
    return Place(entry.source, entry.line, entry.column, entry.width, *shown)


def node_place(node: Node) -> Place:
    """The place of a value."""
    return Place(node.source, node.line, node.column, node.width)


def plain(node: Node) -> Any:
    """The value without its places: dict, list, str, int, float, bool or None."""
    if isinstance(node, Scalar):
        return node.value
    if isinstance(node, Items):
        return [plain(item) for item in node.items]
    assert isinstance(node, Mapping)
    return {key: plain(entry.value) for key, entry in node.entries.items()}


def read_yaml(source: Source) -> tuple[Node, list[Problem]]:
    """The one document in `source`, and the problems that leave it readable (duplicate keys).

    Raises CaseError when it is not YAML, empty, too deep or too large, or uses what is left out here.
    """
    composer = _Composer(source)
    try:
        node = composer.document(yaml.parse(source.text, Loader=_LOADER))
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        where = (mark.line + 1, mark.column + 1) if mark else (1, 1)
        text = f"not valid YAML: {error.problem or error.context}"
        if source.line(where[0])[where[1] - 1 : where[1]] == "\t":
            text += " (a tab; YAML indents with spaces)"
        raise CaseError([Problem(Place(source, *where), "", text)]) from None
    except yaml.YAMLError as error:
        raise CaseError([Problem(Place(source), "", f"not valid YAML: {error}")]) from None
    return node, composer.problems


def scalar_value(text: str) -> type_of_scalar:
    """A plain scalar by the core schema of YAML 1.2: null, boolean, integer, float, or else a string."""
    if text in _OTHER:
        return _OTHER[text]  # type: ignore[return-value]
    if text[0] not in "0123456789+-.":
        return text
    # A float is exact to 2^53; longer integers would only cost time.
    if _INTEGER.match(text) and len(text) <= 16:
        return int(text)
    if _FLOAT.match(text):
        return float(text)
    if text.startswith(("0x", "0o")) and len(text) <= 14:
        try:
            return int(text, 0)
        except ValueError:
            return text
    return text


class _Composer:
    """Builds nodes from the events of PyYAML's parser."""

    def __init__(self, source: Source) -> None:
        self.source = source
        self.problems: list[Problem] = []
        self.anchors: dict[str, Node | None] = {}
        self.count = self.keys = 0

    def stop(self, mark: Any, text: str) -> CaseError:
        return CaseError([Problem(Place(self.source, mark.line + 1, mark.column + 1), "", text)])

    def document(self, events: Iterator[Any]) -> Node:
        node: Node | None = None
        for event in events:
            if isinstance(event, yaml.DocumentStartEvent):
                if node is not None:
                    raise self.stop(event.start_mark, "a second document; a case file is one document")
                if event.tags or event.version:
                    raise self.stop(event.start_mark, "directives (%) are not used in case files")
                node = self.node(next(events), events, 0)
        if node is None:
            raise CaseError([Problem(Place(self.source), "", "the file is empty")])
        return node

    def node(self, event: Any, events: Iterator[Any], depth: int) -> Node:
        mark = event.start_mark
        if isinstance(event, yaml.AliasEvent):
            return self.alias(event)
        if event.tag is not None:
            raise self.stop(mark, f"tags are not used in case files, got {event.tag[:60]!r}")
        if depth > MAX_DEPTH:
            raise self.stop(mark, f"nested deeper than {MAX_DEPTH} levels")
        self.grow(mark, 1)
        if event.anchor is not None:
            self.anchors[event.anchor] = None
        node: Node
        if isinstance(event, yaml.ScalarEvent):
            node = self.scalar(event)
        elif isinstance(event, yaml.SequenceStartEvent):
            node = self.items(mark, events, depth)
        else:
            node = self.mapping(mark, events, depth)
        if event.anchor is not None:
            self.anchors[event.anchor] = node
        return node

    def grow(self, mark: Any, by: int) -> None:
        self.count += by
        if self.count > MAX_NODES:
            raise self.stop(mark, f"more than {MAX_NODES} values (aliases counted each time)")

    def alias(self, event: Any) -> Node:
        if event.anchor not in self.anchors:
            raise self.stop(event.start_mark, f"unknown alias *{event.anchor[:60]}")
        node = self.anchors[event.anchor]
        if node is None:
            raise self.stop(event.start_mark, f"alias *{event.anchor[:60]} stands inside of what it names")
        self.grow(event.start_mark, node.size)
        return node

    def scalar(self, event: Any) -> Scalar:
        mark: Any = event.start_mark
        end: Any = event.end_mark
        value: type_of_scalar = event.value
        if not event.style or event.style == "":
            value = scalar_value(event.value)
        elif UNPRINTABLE.search(event.value.replace("\n", " ")):
            raise self.stop(mark, "a string with control characters")
        width = end.column - mark.column if end.line == mark.line else 1
        return Scalar(self.source, mark.line + 1, mark.column + 1, width, 1, value)

    def items(self, mark: Any, events: Iterator[Any], depth: int) -> Items:
        items: list[Node] = []
        size = 1
        for event in events:
            if isinstance(event, yaml.SequenceEndEvent):
                break
            items.append(self.node(event, events, depth + 1))
            size += items[-1].size
        return Items(self.source, mark.line + 1, mark.column + 1, 1, size, items)

    def mapping(self, mark: Any, events: Iterator[Any], depth: int) -> Mapping:
        entries: dict[str, Entry] = {}
        size = 1
        for event in events:
            if isinstance(event, yaml.MappingEndEvent):
                break
            if not isinstance(event, yaml.ScalarEvent) or event.tag is not None or event.anchor is not None:
                raise self.stop(event.start_mark, "expected a plain word as the key of a mapping")
            if UNPRINTABLE.search(event.value):
                raise self.stop(event.start_mark, "a key with control characters")
            if len(entries) == MAX_KEYS:
                raise self.stop(event.start_mark, f"more than {MAX_KEYS} keys in one mapping")
            self.keys += 1
            if self.keys > MAX_ALL_KEYS:
                raise self.stop(event.start_mark, f"more than {MAX_ALL_KEYS} keys")
            value = self.node(next(events), events, depth + 1)
            start: Any = event.start_mark
            end: Any = event.end_mark
            width = max(end.column - start.column, 1)
            entry = Entry(start.line + 1, start.column + 1, width, self.source, value)
            first = entries.get(event.value)
            if first:
                text = f"given twice, on lines {first.line} and {entry.line}"
                self.problems.append(Problem(entry_place(entry), event.value, text))
            else:
                entries[event.value] = entry
            size += value.size
        return Mapping(self.source, mark.line + 1, mark.column + 1, 1, size, entries)
