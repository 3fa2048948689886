"""`studies:` of a case file: the same case several times, each with its own sweep and its own changes."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace

from tbi_cli.case.document import STUDIES, Document
from tbi_cli.case.forms import becomes_mapping, make_room
from tbi_cli.case.keys import no_such_place
from tbi_cli.case.messages import CaseError, Problem, quoted
from tbi_cli.case.yaml12 import MAX_NODES, Entry, Items, Mapping, Node, Scalar, entry_place, plain

#: What a study may be called: it names a group of the results file, and a folder while the run goes on.
NAME = r"[A-Za-z][A-Za-z0-9_-]{0,63}"
MOST_STUDIES = 64


def studies_in(document: Document) -> Iterator[tuple[str, Document]]:
    """Each study's name and the whole case that it is: the rest of the file with the study's keys changed.

    A study's keys may be dotted, and a mapping changes only the keys that it has; but a sweep and a train
    that says its model replace what was there, and so does one form of what can be given in several.  Null
    takes a key away.  Raises CaseError.
    """
    root = document.root
    entry = root.entries[STUDIES]
    if not isinstance(entry.value, Mapping) or not entry.value.entries:
        text = "expected a mapping of studies such as {masses: {sweep: {...}}, spans: {sweep: {...}}}"
        raise _fault(entry, STUDIES, f"{text}, got {quoted(plain(entry.value))}")
    studies = entry.value.entries
    base = Mapping(root.source, root.line, root.column)
    base.entries = {key: value for key, value in root.entries.items() if key != STUDIES}
    size = sum(value.value.size for value in base.entries.values())
    if len(studies) > MOST_STUDIES or len(studies) * size > MAX_NODES:
        text = f"expected at most {MOST_STUDIES} studies, and {MAX_NODES} values in all of them together"
        raise _fault(entry, STUDIES, f"{text}; got {len(studies)} of {size} values and more")
    for name, study in studies.items():
        key = f"{STUDIES}.{name}"
        if re.fullmatch(NAME, name) is None:
            text = "expected a name of at most 64 letters, digits, - and _ that begins with a letter"
            raise _fault(study, key, f"{text}, got {quoted(name)}")
        if not isinstance(study.value, Mapping):
            text = "expected a mapping of the keys that this study changes, such as {sweep: {...}}"
            raise _fault(study, key, f"{text}, got {quoted(plain(study.value))}")
        output = study.value.get("output")
        if "output.file" in study.value.entries or (isinstance(output, Mapping) and output.get("file")):
            raise _fault(study, key, "all studies are in one file: output.file stands outside of them")
        case = document.like(_copied_mapping(base))
        changed = _Study(name, case.root)
        for word, change in study.value.entries.items():
            part = word.partition(".")[0]
            if part in ("train", "bridge") and (part != word or isinstance(change.value, Mapping)):
                case.include(part)  # there may be a name yet, of what is to be changed
            only = Mapping(study.source, study.line, study.column, entries={word: change})
            changed.change(case.root, only, [])
        yield name, case


def told_once(found: dict[str, tuple[Problem, ...]], studies: int) -> list[Problem]:
    """What is wrong with studies: what all of them have wrong stands outside of them, and is told once."""
    counts = Counter(problem for problems in found.values() for problem in dict.fromkeys(problems))
    told = [problem for problem, count in counts.items() if count == studies]
    for name, problems in found.items():
        own = [problem for problem in problems if counts[problem] < studies]
        told += [replace(p, key=f"{STUDIES}.{name}.{p.key}".rstrip(".")) for p in own]
    return told


def _fault(entry: Entry, key: str, text: str) -> CaseError:
    return CaseError([Problem(entry_place(entry), key, text)])


class _Study:
    """Makes the changes of one study to `root`, which is ours to change."""

    def __init__(self, name: str, root: Mapping) -> None:
        self._name, self._root = name, root
        # What the study has put there, beside which its own other forms are not to vanish without a word.
        self._fresh: dict[int, Entry] = {}

    def change(self, base: Mapping, changes: Mapping, words: list[str | int]) -> Mapping:
        """`base`, which stands at these words, with the keys that `changes` has."""
        whole = {key: entry for key, entry in changes.entries.items() if "." not in key}
        make_room(base, words, [self._root], whole, self._fresh)
        for dotted, entry in changes.entries.items():
            word, dot, rest = dotted.partition(".")
            value, here = entry.value, [*words, word]
            if dot:
                inner = Entry(entry.line, entry.column, entry.width, entry.source, value)
                value = Mapping(entry.source, entry.line, entry.column, entries={rest: inner})
            old = base.get(word)
            if isinstance(value, Scalar) and value.value is None:
                base.entries.pop(word, None)
                continue
            if dot and isinstance(old, Items) and not becomes_mapping(here, [self._root]):
                value = self._change_list(old, value, here, entry)
            elif isinstance(value, Mapping) and isinstance(old, Mapping) and not _replaces(word, value):
                value = self.change(old, value, here)
            elif isinstance(value, Mapping):
                # Nothing to change: dotted keys in it are still to be spelled out, but for those of a sweep.
                empty = Mapping(value.source, value.line, value.column, value.width)
                value = _copied(value) if word == "sweep" else self.change(empty, value, here)
            else:
                value = _copied(value)
            new = Entry(entry.line, entry.column, entry.width, entry.source, value)
            base.entries[word] = self._fresh[id(new)] = new
        return base

    def _change_list(self, old: Items, changes: Node, words: list[str | int], entry: Entry) -> Items:
        """A list with the items changed that dotted keys such as `train.consist.0.count` name."""
        assert isinstance(changes, Mapping)
        ((dotted, inner),) = changes.entries.items()
        word, _, rest = dotted.partition(".")
        if not (word.isdigit() and len(word) < 7 and int(word) < len(old.items)):
            at = [STUDIES, self._name, *map(str, words)]
            raise _fault(entry, ".".join(at), no_such_place(at, word, len(old.items)))
        item = old.items[int(word)]
        if rest:
            around = item if isinstance(item, Mapping) else Mapping(entry.source, entry.line, entry.column)
            key = Mapping(entry.source, entry.line, entry.column, entries={rest: inner})
            old.items[int(word)] = self.change(around, key, [*words, int(word)])
        else:
            old.items[int(word)] = _copied(inner.value)
        return old


def _replaces(word: str, value: Mapping) -> bool:
    return word == "sweep" or (word in ("train", "vehicle") and "model" in value.entries)


def _copied(node: Node) -> Node:
    """The same tree anew: what is done to one study must not be done to another."""
    if isinstance(node, Mapping):
        return _copied_mapping(node)
    if isinstance(node, Items):
        items = [_copied(item) for item in node.items]
        return Items(node.source, node.line, node.column, node.width, node.size, items)
    return node


def _copied_mapping(node: Mapping) -> Mapping:
    entries = {
        key: Entry(e.line, e.column, e.width, e.source, _copied(e.value)) for key, e in node.entries.items()
    }
    return Mapping(node.source, node.line, node.column, node.width, node.size, entries)
