"""Docstrings that users read, also under `python -OO`, which leaves them out."""

from __future__ import annotations

import ast
import inspect
import sys
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import Any


def docstring(thing: Callable[..., Any]) -> str:
    """The docstring of a function or class of a module, read from its source where Python did not keep it."""
    if sys.flags.optimize < 2:
        return inspect.getdoc(thing) or ""
    return _of_module(thing.__module__).get(thing.__name__, "")


@lru_cache
def _of_module(name: str) -> dict[str, str]:
    try:
        tree = ast.parse(Path(sys.modules[name].__file__ or "").read_bytes())
    except (OSError, SyntaxError):
        return {}
    found = (node for node in tree.body if isinstance(node, ast.FunctionDef | ast.ClassDef))
    return {node.name: ast.get_docstring(node) or "" for node in found}
