"""`studies:` of a case file: the same case several times, each with its own sweep and its own changes."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace

from tbi_cli.case.document import Document
from tbi_cli.case.messages import CaseError, Problem, quoted
from tbi_cli.case.yaml12 import MAX_NODES, Entry, Items, Mapping, Node, Scalar, entry_place, plain

STUDIES = "studies"
#: What a study may be called: it names a group of the results file, and a folder while the run goes on.
NAME = r"[A-Za-z][A-Za-z0-9_-]{0,63}"
MOST_STUDIES = 64


def studies_in(document: Document) -> Iterator[tuple[str, Document]]:
    """Each study's name and the whole case that it is: the rest of the file with the study's keys changed.

    A study's keys may be dotted, and a mapping changes only the keys that it has; but a sweep, a damping and
    a train that says its model replace what was there.  Null takes a key away.  Raises CaseError.
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
        for word, change in study.value.entries.items():
            part = word.partition(".")[0]
            if part in ("train", "bridge") and (part != word or isinstance(change.value, Mapping)):
                case.include(part)  # there may be a name yet, of what is to be changed
            only = Mapping(study.source, study.line, study.column, entries={word: change})
            _changed(case.root, only, key)
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


def _changed(base: Mapping, changes: Mapping, at: str) -> Mapping:
    """`base`, which is ours to change, with the keys that `changes` has."""
    for dotted, entry in changes.entries.items():
        word, dot, rest = dotted.partition(".")
        value = entry.value
        if dot:
            inner = Entry(entry.line, entry.column, entry.width, entry.source, value)
            value = Mapping(entry.source, entry.line, entry.column, entries={rest: inner})
        old = base.get(word)
        if isinstance(value, Scalar) and value.value is None:
            base.entries.pop(word, None)
            continue
        if dot and isinstance(old, Items):
            value = _changed_list(old, value, f"{at}.{dotted}", entry)
        elif isinstance(value, Mapping) and isinstance(old, Mapping) and not _replaces(word, value):
            value = _changed(old, value, f"{at}.{word}")
        elif isinstance(value, Mapping):
            # Nothing to change: dotted keys in it are still to be spelled out, but for those of a sweep.
            whole = word == "sweep"
            empty = Mapping(value.source, value.line, value.column, value.width)
            value = _copied(value) if whole else _changed(empty, value, f"{at}.{word}")
        else:
            value = _copied(value)
        base.entries[word] = Entry(entry.line, entry.column, entry.width, entry.source, value)
    return base


def _replaces(word: str, value: Mapping) -> bool:
    return word in ("sweep", "damping") or (word in ("train", "vehicle") and "model" in value.entries)


def _changed_list(old: Items, changes: Node, at: str, entry: Entry) -> Items:
    """A list with the items changed that dotted keys such as `train.consist.0.count` name."""
    assert isinstance(changes, Mapping)
    ((dotted, inner),) = changes.entries.items()
    word = dotted.partition(".")[0]
    if not (word.isdigit() and len(word) < 7 and int(word) < len(old.items)):
        raise _fault(entry, at, f"expected one of 0 to {len(old.items) - 1}, got {quoted(word)}")
    around = Mapping(entry.source, entry.line, entry.column)
    around.put(word, old.items[int(word)])
    key = Mapping(entry.source, entry.line, entry.column, entries={dotted: inner})
    old.items[int(word)] = _changed(around, key, at).entries[word].value
    return old


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
