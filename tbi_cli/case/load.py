"""From a case file to a Case: read, include, override, validate, and say everything that is wrong at once."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from tbi_cli.case.axes import Axis
from tbi_cli.case.checks import Finding, contradictions, oddities, sweep_contradictions
from tbi_cli.case.document import STUDIES, Document, ExtraAxis, case_path
from tbi_cli.case.files import case_folder
from tbi_cli.case.keys import accepts, fields_of, is_list, part_at
from tbi_cli.case.messages import (
    MOST_ERRORS,
    CaseError,
    Problem,
    fail,
    in_order,
    meant_by,
    of_many,
    quoted,
    suggestion,
)
from tbi_cli.case.mixed_units import mixed_lists
from tbi_cli.case.model import Case, union
from tbi_cli.case.places import Places, node_of, place_of, words_of
from tbi_cli.case.ranges import MAX_VALUES
from tbi_cli.case.studies import studies_in, told_once
from tbi_cli.case.sweep import Sweep, missing_but_swept
from tbi_cli.case.track_file import resolve_track
from tbi_cli.case.train import TRAINS, VEHICLES
from tbi_cli.case.yaml12 import Items, Mapping, Scalar, plain

# In a message: the value that was found, and why it is not accepted.
_QUOTED = re.compile(r'"[^"]*"')
_GOT = re.compile(r", got .*?( \([^()]*\))?$", re.DOTALL)


def load_case(
    source: str | Path | None = None,
    *,
    overrides: Sequence[str] = (),
    extra_axis: ExtraAxis | None = None,
    strict: bool = False,
) -> Case:
    """The case in a file, validated and in SI.

    source: a path, or the name of a built-in case (None: the paper's, `paper`). overrides: `KEY=VALUE`,
    applied in this order, VALUE being YAML; the value null takes a key away. extra_axis: one more swept axis.
    strict: odd values are errors too; otherwise they are in `warnings` of the case.

    Raises CaseError, whose text holds every problem found, each with its place.
    """
    path, name = case_path(source)
    with case_folder(path):
        return _loaded(Document(path, name), overrides, extra_axis, strict)


def _loaded(document: Document, overrides: Sequence[str], extra_axis: ExtraAxis | None, strict: bool) -> Case:
    for option in overrides:
        try:
            document.override(option)
        except CaseError as error:
            document.problems += error.problems
    for key in ("train", "bridge"):
        document.include(key)
    if STUDIES in document.root.entries:
        return _with_studies(document, extra_axis, strict)
    document.problems += resolve_track(document.root)
    if extra_axis is not None:
        document.add_axis(extra_axis)
    return _validated(document, Sweep(document.root), strict)


def _with_studies(document: Document, extra_axis: ExtraAxis | None, strict: bool) -> Case:
    """The case of a file with `studies:`, each of them a case of its own."""
    if extra_axis is not None:
        raise fail(f"sweep {extra_axis.name}", "the studies of this case have their own sweeps")
    studies: dict[str, Case] = {}
    found: dict[str, tuple[Problem, ...]] = {}
    most = MAX_VALUES
    for name, study in studies_in(document):
        for key in ("train", "bridge"):
            study.include(key)
        study.problems += resolve_track(study.root)
        try:
            sweep = Sweep(study.root, most)
            most -= sweep.size
            studies[name] = _validated(study, sweep, strict)
        except CaseError as error:
            found[name] = error.problems
    wrong = [problem for problem in document.problems if not problem.odd]
    problems = [*wrong, *told_once(found, len(studies) + len(found))]
    if problems:
        raise CaseError(in_order(problems, document.root.source))
    return union(studies, plain(document.root).get("title", "")).standing_at(Places(document.root))


def _validated(document: Document, sweep: Sweep, strict: bool) -> Case:
    root, axes = document.root, sweep.axes
    for path, value in missing_but_swept(axes):
        _set_if_missing(root, path, value)
    values = {key: value for key, value in plain(root).items() if key != "sweep"}
    problems = [*(problem for problem in document.problems if not problem.odd), *sweep.problems]
    case: Case | None = None
    try:
        case = Case.model_validate(values)
    except ValidationError as error:
        problems += [problem for problem in _problems(error, root) if problem.key not in document.failed]
    problems += _located(contradictions(values), root)
    if case is not None and not problems:
        problems += _located(sweep_contradictions(case, axes), root)
    if case is not None and not problems:
        has_unit = lru_cache(lambda key: _has_unit(root, key))
        warnings = [problem for problem in document.problems if problem.odd]
        warnings += [*mixed_lists(root, case.train.model), *sweep.warnings, *_without_effect(root, axes)]
        warnings += _located(oddities(case, axes, has_unit), root)
        if not strict or not warnings:
            texts = tuple(warning.render("warning") for warning in warnings)
            return case.swept(axes, texts).standing_at(Places(root))
        problems = warnings
    raise CaseError(in_order(problems, root.source))


def _set_if_missing(root: Mapping, path: str, value: float) -> None:
    """A swept key may be left out of the file; its first value stands in."""
    words = path.split(".")
    mapping = root
    sweep = root.entries["sweep"].value
    for depth, word in enumerate(words[:-1]):
        inner = mapping.get(word)
        if inner is None and (depth > 0 or word not in ("train", "bridge")):
            inner = Mapping(sweep.source, sweep.line, sweep.column)
            mapping.put(word, inner)
        if not isinstance(inner, Mapping):
            return
        mapping = inner
    if mapping.get(words[-1]) is None:
        mapping.put(words[-1], Scalar(sweep.source, sweep.line, sweep.column, value=value))


def _without_effect(root: Mapping, axes: Sequence[Axis]) -> Iterator[Problem]:
    """Options that set a key which the sweep sets again."""
    for axis in axes:
        for column in axis.members or (axis,):
            for path in column.paths:
                node = node_of(root, words_of(path))
                if (
                    node is not None
                    and node.source.is_option
                    and node.source is not root.entries["sweep"].source
                ):
                    cure = "" if axis.members else f"; set sweep.{path} to replace its values"
                    text = f"has no effect, as the sweep sets it{cure}"
                    yield Problem(place_of(root, words_of(path)), path, text)


def _located(findings: Iterable[Finding], root: Mapping) -> list[Problem]:
    return [Problem(place_of(root, words_of(key)), key, text) for key, text in findings]


def _has_unit(root: Mapping, key: str) -> bool:
    """Whether the value of a key, or every value of an axis, was written as a text."""
    node = node_of(root, words_of(key))
    nodes = node.items if isinstance(node, Items) else [node]
    return all(isinstance(item, Scalar) and isinstance(item.value, str) for item in nodes)


def _problems(error: ValidationError, root: Mapping) -> Iterable[Problem]:
    """pydantic's errors in our words; what is wrong with many values of a list is said of the first.

    A key that is missing because another word stands for it is said once, of that word.
    """
    meant: set[tuple[str | int, ...]] = set()
    missing: dict[tuple[str | int, ...], Problem] = {}
    for item, count in _alike(error.errors(include_url=False, include_context=True))[:MOST_ERRORS]:
        # Among the words are the models by which pydantic tells trains and vehicles apart: no keys.
        loc = item["loc"]
        tagged = {depth for depth in range(1, len(loc)) if loc[depth - 1] in ("train", "vehicle")}
        words = [w for depth, w in enumerate(loc) if not (depth in tagged and w in TRAINS)]
        if "damping" in words:
            # The coefficient may stand without its name.
            at = words.index("damping")
            if words[at + 1 :] == ["coefficient"] and not isinstance(node_of(root, words[: at + 1]), Mapping):
                words = words[: at + 1]
        if words[-1:] in (["train"], ["vehicle"]) and item["type"].startswith("union_tag"):
            words = [*words, "model"]
        words += item.get("ctx", {}).get("at", ())
        key = ".".join(str(word) for word in words)
        text = _text(item["type"], item, words, root)
        problem = Problem(place_of(root, words), key, of_many(text, count))
        if item["type"] in ("missing", "union_tag_not_found"):
            missing[tuple(words)] = problem
            continue
        if item["type"] == "extra_forbidden":
            meant.add((*words[:-1], meant_by(str(words[-1]), _known(words[:-1], root))))
        yield problem
    yield from (problem for words, problem in missing.items() if words not in meant)


def _alike(errors: Sequence[Any]) -> list[tuple[Any, int]]:
    """The first error of each kind in each list, and how many of it there are."""
    counts: Counter[Any] = Counter()
    first: dict[Any, Any] = {}
    for number, item in enumerate(errors):
        *around, last = item["loc"] or ("",)
        # The same but for the values in it.
        kind = _QUOTED.sub('""', _GOT.sub(r"\1", item["msg"])) if item["type"] == "tbi" else item["type"]
        key = (tuple(around), kind) if isinstance(last, int) else number
        counts[key] += 1
        first.setdefault(key, item)
    return [(item, counts[key]) for key, item in first.items()]


def _text(kind: str, item: Any, words: Sequence[str | int], root: Mapping) -> str:
    if kind == "tbi":
        return str(item["msg"])
    if kind == "extra_forbidden":
        return f"unknown key; {suggestion(str(words[-1]), _known(words[:-1], root))}"
    expected = _expected(words, root)
    if kind in ("missing", "union_tag_not_found"):
        return f"missing; expected {expected}"
    got = item["input"]
    return f"expected {expected}, got {quoted(got.get('model') if kind == 'union_tag_invalid' else got)}"


def _known(words: Sequence[str | int], root: Mapping) -> list[str]:
    """The keys of the mapping at these words."""
    around = part_at(words, root)
    return [*fields_of(around), *(["sweep", STUDIES] if around is Case else [])] if around else []


def _expected(words: Sequence[str | int], root: Mapping) -> str:
    if words[-1] == "model" and words[-2] in ("train", "vehicle"):
        return f"one of {', '.join(TRAINS if words[-2] == 'train' else VEHICLES)}"
    if words[-1] in ("train", "bridge", "vehicle"):
        return f"a file, a built-in {'bridge' if words[-1] == 'bridge' else 'train'} or a mapping"
    around = part_at(words[:-1], root)
    found = fields_of(around).get(str(words[-1])) if around and words else None
    part = part_at(words, root)
    if part is not None:
        each = "a list, each " if found and is_list(found[1]) and words[-1] == found[0] else ""
        return f"{each}a mapping with the keys {', '.join(fields_of(part))}"
    if found is None:
        return "something else"
    field = accepts(found[1])
    assert field is not None
    return f"a list, each {field.expected()}" if is_list(found[1]) else field.expected()
