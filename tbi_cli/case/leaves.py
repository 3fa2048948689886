"""A resolved case as kept in a results file, key by key, to tell two of them apart."""

from __future__ import annotations

from collections.abc import Iterator

from tbi_cli.case.messages import Source
from tbi_cli.case.yaml12 import Items, Mapping, Node, plain, read_yaml


def leaves_of(text: str) -> dict[str, object]:
    """The values of a case by their dotted keys; a list of values counts as one value.

    Raises CaseError where the text is no case file or has more values than one may have: it may be a
    stranger's.
    """
    node, _ = read_yaml(Source("case", text))
    return dict(_leaves(node, ""))


def _leaves(node: Node, key: str) -> Iterator[tuple[str, object]]:
    inner: dict[str, Node] = {}
    if isinstance(node, Mapping):
        inner = {name: entry.value for name, entry in node.entries.items()}
    elif isinstance(node, Items) and any(isinstance(item, Mapping) for item in node.items):
        inner = {str(number): item for number, item in enumerate(node.items)}
    for name, value in inner.items():
        yield from _leaves(value, f"{key}.{name}" if key else name)
    if not inner:
        yield key, plain(node)
