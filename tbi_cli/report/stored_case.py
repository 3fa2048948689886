"""The case that a results file came from, read back from the YAML kept in it."""

from __future__ import annotations

import tempfile
from pathlib import Path

from tbi_cli.case import Case, CaseError, load_case
from tbi_cli.case.messages import Source
from tbi_cli.case.yaml12 import Mapping, Node, read_yaml


def stored_case(text: str) -> Case | None:
    """The case in `text`; None if it is none that this version of tbi reads.

    A resolved case is complete: one that names other files is not of our making, and nothing is read for it.
    """
    try:
        root, _ = read_yaml(Source("case", text))
        if not isinstance(root, Mapping) or not all(map(_is_complete, _grids(root))):
            return None
        with tempfile.TemporaryDirectory(prefix="tbi-case-") as folder:
            file = Path(folder) / "case.yaml"
            file.write_text(text, encoding="utf-8")
            return load_case(file).standing_at(None)  # the file is gone when a message would name it
    except (CaseError, UnicodeError):
        return None


def _grids(root: Mapping) -> list[Node | None]:
    """The studies of a case, or the case itself where it is one grid."""
    studies = root.get("studies")
    if studies is None:
        return [root]
    return [entry.value for entry in studies.entries.values()] if isinstance(studies, Mapping) else [None]


def _is_complete(case: Node | None) -> bool:
    return isinstance(case, Mapping) and all(
        isinstance(case.get(key), Mapping) for key in ("train", "bridge")
    )
