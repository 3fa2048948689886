"""A case as one tree of keys: the file, what `train:` and `bridge:` name, and the command line's options."""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from tbi_cli.case.axes import SHORT_NAMES
from tbi_cli.case.builtin import Kind, builtin_names, builtin_path
from tbi_cli.case.files import checked, read_source
from tbi_cli.case.forms import axis_words, becomes_mapping, make_room, put_axis
from tbi_cli.case.keys import no_such_place
from tbi_cli.case.messages import CaseError, Problem, Source, fail, quoted, suggestion
from tbi_cli.case.places import node_of
from tbi_cli.case.train_files import resolve_train
from tbi_cli.case.yaml12 import (
    Entry,
    Items,
    Mapping,
    Node,
    Scalar,
    entry_place,
    node_place,
    plain,
    read_yaml,
)
from tbi_cli.printable import printable

_INCLUDED: dict[str, Kind] = {"train": "train", "bridge": "bridge"}
STUDIES = "studies"


@dataclass(frozen=True)
class ExtraAxis:
    """An axis given on the command line, its values as written there ("2", "10 km/h").

    Give `values`, or `start`, `stop` and `step`; with none of them only velocity has a range of its own.
    """

    name: str
    start: str | float | None = None
    stop: str | float | None = None
    step: str | float | None = None
    values: str | Sequence[str | float] | None = None


class Document:
    """The tree of a case under construction, and the problems met so far."""

    def __init__(self, path: Path, name: str) -> None:
        self.problems: list[Problem] = []
        self.root = self._mapping(path, name, "a case: a mapping with the keys train, bridge, velocity, ...")
        self._file = os.path.realpath(path)
        # Included keys that could not be read, so that nothing more can be said of them.
        self.failed: set[str] = set()

    def like(self, root: Mapping) -> Document:
        """Another tree from the same file, with no problems yet but what is odd in both."""
        other = object.__new__(Document)
        other.root, other._file, other.failed = root, self._file, set(self.failed)
        other.problems = [problem for problem in self.problems if problem.odd]
        return other

    def override(self, option: str) -> None:
        """Applies one `--set KEY=VALUE`."""
        key, sign, value = option.partition("=")
        source = Source(f"--set {printable(option[:200])}", value, is_option=True)
        words = self._override_path(key.strip())
        if not sign or not all(words):
            raise fail(source.name, "expected KEY=VALUE, e.g. velocity=50")
        if not value.strip():
            raise fail(source.name, 'expected a value after "="')
        node, problems = read_yaml(checked(source))
        self.problems += problems
        # What a study changes is a case of its own, of which much is outside of it.
        study = 2 if words[0] == STUDIES else 0
        roots = [root for root in (node_of(self.root, words[:study]), self.root) if isinstance(root, Mapping)]
        around: Mapping | Items = self.root
        for depth, word in enumerate(words[:-1]):
            if depth == 0 and word in _INCLUDED:
                self.include(word)
            inner = _child(around, words[: depth + 1], source.name)
            if isinstance(inner, Items) and not words[depth + 1].isdigit():
                inner = None if becomes_mapping(words[study : depth + 1], roots) else inner
            if isinstance(inner, Mapping) and inner.source is not source:
                # An alias may stand in several places: change this one only.
                inner = Mapping(inner.source, inner.line, inner.column, 1, inner.size, dict(inner.entries))
            elif isinstance(inner, Items):
                inner = Items(inner.source, inner.line, inner.column, 1, inner.size, list(inner.items))
            elif not isinstance(inner, Mapping):
                inner = Mapping(source, 1, 1)
            _put(around, word, inner)
            around = inner
        _child(around, words, source.name)
        last = words[-1]
        if isinstance(around, Items):
            around.items[int(last)] = node
        elif isinstance(node, Scalar) and node.value is None:
            around.entries.pop(last, None)
        elif words[study:-1] == ["sweep"]:
            put_axis(around, last, node, source)
        else:
            entry = Entry(node.line, node.column, node.width, source, node)
            make_room(around, _numbered(words[study:-1]), roots, {last: entry})
            _put(around, last, node)

    def _override_path(self, key: str) -> list[str]:
        """The words of a dotted key, where the names of axes, which are dotted, are one word."""
        words = key.split(".")
        before, rest = (words[:2], words[2:]) if words[0] == STUDIES else ([], words)
        around = node_of(self.root, before)
        if rest[:1] == ["sweep"] and len(rest) > 1:
            sweep = around.get("sweep") if isinstance(around, Mapping) else None
            return [*before, "sweep", *axis_words(rest[1:], sweep)]
        if not before or around is None:
            return words
        # What the study does not have itself is changed where it comes from, by a dotted key.
        own = 0
        while own < len(rest) - 1 and isinstance(
            node_of(around, _numbered(rest[: own + 1])), Mapping | Items
        ):
            own += 1
        return [*before, *rest[:own], ".".join(rest[own:])]

    def add_axis(self, extra: ExtraAxis) -> None:
        """Appends an axis to the sweep, or puts it in the place of the one that sets the same keys."""
        source = Source(f"sweep {printable(extra.name[:80])}", is_option=True)
        value = _axis_node(extra, source)
        sweep = self.root.get("sweep")
        if not isinstance(sweep, Mapping):
            sweep = Mapping(source, 1, 1)
            self.root.put("sweep", sweep)
        put_axis(sweep, extra.name, value, source)

    def include(self, key: str) -> None:
        """Puts the mapping that `train: NAME` or `bridge: NAME` names in the place of the name."""
        entry = self.root.entries.get(key)
        if entry is None:
            return
        if not self._include(entry, key, _INCLUDED[key]):
            del self.root.entries[key]
        elif key == "train" and isinstance(entry.value, Mapping):
            self.problems += resolve_train(entry.value, key, lambda e, at: self._include(e, at, "train"))

    def _include(self, entry: Entry, key: str, kind: Kind) -> bool:
        """Replaces the name in `entry`, whose dotted key is `key`; False if that failed, and was reported."""
        if not isinstance(entry.value, Scalar) or not isinstance(entry.value.value, str):
            return True
        if key in self.failed:
            return False
        written = entry.value.value
        try:
            path, name = _included_path(kind, written, entry.value.source)
            if os.path.realpath(path) == self._file:
                raise CaseError([Problem(None, "", f"{quoted(written)} includes itself")])
            entry.value = self._mapping(path, name, f"a {kind}: a mapping")
        except CaseError as error:
            if error.problems and error.problems[0].place is None:
                only = error.problems[0]
                error = CaseError(
                    [Problem(entry_place(entry), key, f"{only.key}: {only.text}".removeprefix(": "))]
                )
            # Reported once; an empty mapping would only add that every key is missing.
            self.problems += error.problems
            self.failed.add(key)
            return False
        return True

    def _mapping(self, path: Path, name: str, expected: str) -> Mapping:
        node, problems = read_yaml(read_source(path, name))
        if not isinstance(node, Mapping):
            raise CaseError(
                [Problem(node_place(node), "", f"expected {expected}, got {quoted(plain(node))}")]
            )
        self.problems += problems
        return node


def _child(around: Mapping | Items, words: Sequence[str], name: str) -> Node | None:
    """What stands at the last word, in a mapping or a list; raises CaseError for no place of a list."""
    word = words[-1]
    if isinstance(around, Mapping):
        return around.get(word)
    if not (word.isdigit() and len(word) < 7 and int(word) < len(around.items)):
        raise fail(name, no_such_place(words[:-1], word, len(around.items)))
    return around.items[int(word)]


def _numbered(words: Sequence[str]) -> list[str | int]:
    return [int(word) if word.isdigit() else word for word in words]


def _put(around: Mapping | Items, word: str, node: Node) -> None:
    """Sets what stands at a key or place; a key whose value is only copied keeps its place in the file."""
    if isinstance(around, Items):
        around.items[int(word)] = node
    elif word in around.entries and around.entries[word].value.source is node.source:
        around.entries[word].value = node
    else:
        around.put(word, node)


def case_path(source: str | Path | None) -> tuple[Path, str]:
    """The file of a case and its name in messages; raises CaseError where there is none."""
    if source is None:
        source = "paper"
    written = str(source)
    path = Path(source)
    is_file = path.suffix.lower() in (".yaml", ".yml") or isinstance(source, Path)
    builtin = builtin_path("case", written)
    if builtin is not None and not (is_file and _exists(path)):
        return builtin, f"{builtin.name} (built-in)"
    if not is_file and not _exists(path):
        names = builtin_names("case")
        raise fail(written, f"no such file, and no built-in case of that name; {suggestion(written, names)}")
    return path, written


def _included_path(kind: Kind, written: str, source: Source) -> tuple[Path, str]:
    beside = source.folder / written
    builtin = builtin_path(kind, written)
    is_file = beside.suffix.lower() in (".yaml", ".yml")
    if builtin is not None and not (is_file and _exists(beside)):
        return builtin, f"{kind}s/{builtin.name} (built-in)"
    if not _exists(beside):
        names = builtin_names(kind)
        text = "no such file in the working folder" if source.is_option else "no such file beside the case"
        raise fail(
            quoted(written), f"{text}, and no built-in {kind} of that name; {suggestion(written, names)}"
        )
    return beside, str(beside)


def _exists(path: Path) -> bool:
    try:
        path.lstat()
    except (OSError, ValueError):
        return False
    return True


def _axis_node(extra: ExtraAxis, source: Source) -> Node:
    ends = {"from": extra.start, "to": extra.stop, "step": extra.step}
    given = {key: value for key, value in ends.items() if value is not None}
    if extra.values is not None:
        if given:
            raise fail(source.name, "expected --values or --from, --to and --step, got both")
        values = extra.values
        items = re.split(r"\s*,\s*", values.strip()) if isinstance(values, str) else list(values)
        return Items(source, 1, 1, items=[_value_node(item, source) for item in items if item != ""])
    if not given and SHORT_NAMES.get(extra.name, (extra.name,)) == ("velocity",):
        given = {"from": 2.0, "to": 200.0, "step": 0.5}
    if len(given) < len(ends):
        missing = ", ".join(f"--{key}" for key in ends if key not in given)
        raise fail(source.name, f"missing {missing}; expected --from, --to and --step, or --values")
    node = Mapping(source, 1, 1)
    for key, value in given.items():
        node.put(key, _value_node(value, source))
    return node


def _value_node(value: str | float, source: Source) -> Node:
    if not isinstance(value, str):
        return Scalar(source, 1, 1, value=value)
    node, _ = read_yaml(checked(Source(source.name, value or '""', is_option=True)))
    return node
