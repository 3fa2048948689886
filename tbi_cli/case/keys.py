"""Dotted keys of a case: what each accepts, and where it is found in a Case."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from difflib import get_close_matches
from typing import Annotated, Any, get_args, get_origin

from pydantic.fields import FieldInfo

from tbi_cli.case.axes import SHORT_NAMES
from tbi_cli.case.bridge import DAMPING_FORMS, Coefficient, Damping
from tbi_cli.case.fields import Accepts, Numeric, Quantity, Whole
from tbi_cli.case.messages import synonym
from tbi_cli.case.model import Case
from tbi_cli.case.part import Part
from tbi_cli.case.places import Words, node_of
from tbi_cli.case.train import TRAINS
from tbi_cli.case.yaml12 import Mapping, Scalar

Chain = tuple[str | int, ...]


class UnknownKeyError(ValueError):
    """Not a key, or not one that takes a number; the message says which is near."""


def fields_of(part: type[Part]) -> dict[str, tuple[str, FieldInfo]]:
    """Key of the case file -> name of the field and its pydantic description."""
    return {info.alias or name: (name, info) for name, info in part.model_fields.items()}


def accepts(info: FieldInfo) -> Accepts | None:
    """What the field takes, when it is a value and not a mapping."""
    found = next((item for item in info.metadata if isinstance(item, Accepts)), None)
    return found or next((item for item in _annotations(info.annotation) if isinstance(item, Accepts)), None)


def part_of(info: FieldInfo, train_model: str | None) -> type[Part] | None:
    """The mapping that the field holds, if it holds one; for a train or vehicle, that of the model named."""
    parts = [
        item for item in _annotations(info.annotation) if isinstance(item, type) and issubclass(item, Part)
    ]
    if len(parts) > 1:
        return TRAINS.get(train_model or "")
    return parts[0] if parts else None


def part_at(words: Words, root: Mapping) -> type[Part] | None:
    """What the mapping at these words should be; of a train or vehicle, by the model that it names."""
    part: type[Part] | None = Case
    for depth, word in enumerate(words):
        if isinstance(word, int):
            continue
        found = fields_of(part).get(word) if part else None
        model = node_of(root, [*words[: depth + 1], "model"])
        named = model.value if isinstance(model, Scalar) and isinstance(model.value, str) else None
        part = part_of(found[1], named) if found else None
    return part


def is_list(info: FieldInfo) -> bool:
    """Whether the field is a list of values."""
    return get_origin(info.annotation) is tuple


def _annotations(annotation: Any) -> Iterator[Any]:
    yield annotation
    if get_origin(annotation) is Annotated:
        yield from annotation.__metadata__
    for inner in get_args(annotation):
        yield from _annotations(inner)


def find_number(path: str, case: Any, train_model: str | None) -> tuple[Numeric, Chain]:
    """What the numeric key `path` accepts and the chain of fields to it.

    `case` is the case as plain values: it tells in which form a beam's damping is given.
    Raises UnknownKeyError.
    """
    words = path.split(".")
    part: type[Part] | None = Case
    chain: list[str | int] = []
    leaf: Accepts | None = None
    listed = False
    for depth, word in enumerate(words):
        if listed and isinstance(case, list) and word.isdigit() and not _indexes(case, word):
            raise UnknownKeyError(no_such_place(words[:depth], word, len(case)))
        case = case.get(word) if isinstance(case, dict) else case[int(word)] if _indexes(case, word) else None
        if listed and word.isdigit():
            chain.append(int(word))
            listed = False
            continue
        fields = fields_of(part) if part else {}
        if word not in fields:
            raise UnknownKeyError(_no_such_key(words[:depth], word, train_model))
        name, info = fields[word]
        chain.append(name)
        named = case.get("model") if isinstance(case, dict) else None
        model = named if isinstance(named, str) else train_model
        part, listed, leaf = part_of(info, model), is_list(info), accepts(info)
        if part is not None:
            leaf = None
    if part is Damping:
        form = next((f for f in DAMPING_FORMS if f in case), None) if isinstance(case, dict) else None
        name, info = fields_of(Damping)[form or "coefficient"]
        chain.append(name)
        leaf = accepts(info)
    if listed or not isinstance(leaf, Quantity | Whole):
        raise UnknownKeyError("not a key with a number, so it cannot be swept")
    leaf = replace(leaf, words=())
    return replace(leaf, swept=True) if isinstance(leaf, Coefficient) else leaf, tuple(chain)


def _indexes(case: Any, word: str) -> bool:
    return isinstance(case, list) and word.isdigit() and len(word) < 6 and int(word) < len(case)


def no_such_place(before: Sequence[str], word: str, count: int) -> str:
    """What is said of a list, at the words before, that has no place of that name."""
    there = f"0 to {count - 1}" if count > 1 else "0 alone" if count else "none"
    return f"{'.'.join(before)} has no {word}; counted from 0, there is {there}"


def _no_such_key(before: list[str], word: str, train_model: str | None) -> str:
    """The nearest dotted key or short name, by the whole of it or by its last word."""
    keys = numeric_keys(train_model)
    tried = ".".join([*before, word])
    by_last_word = {key.rpartition(".")[2]: key for key in reversed(keys)} | {key: key for key in SHORT_NAMES}
    if other := synonym(tried, SHORT_NAMES):
        return f"no such key; did you mean {other}?"
    if word in by_last_word:
        return f"no such key; did you mean {by_last_word[word]}?"
    near = get_close_matches(tried[:80], [*SHORT_NAMES, *keys], n=1, cutoff=0.7)
    near += [by_last_word[name] for name in get_close_matches(word[:80], by_last_word, n=1, cutoff=0.7)]
    if near:
        return f"no such key; did you mean {near[0]}?"
    return (
        f"no such key; expected one of {', '.join(SHORT_NAMES)}, or a key such as bridge.right.youngs_modulus"
    )


def numeric_keys(train_model: str | None) -> list[str]:
    """All dotted keys that take one number, for a train of this model."""

    def walk(part: type[Part], before: str) -> Iterator[str]:
        for key, (_, info) in fields_of(part).items():
            inner = part_of(info, train_model)
            if inner is Damping:
                yield before + key
            elif inner is not None and is_list(info):
                continue
            elif inner is not None:
                yield from walk(inner, f"{before}{key}.")
            elif isinstance(accepts(info), Quantity | Whole) and not is_list(info):
                yield before + key

    return list(walk(Case, ""))
