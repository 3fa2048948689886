"""The Python interface, from signatures and docstrings."""

from __future__ import annotations

import inspect
import re
from typing import Any

import tbi_cli
from tbi_cli.case import CaseError
from tbi_cli.errors import UserError
from tbi_cli.runner import Progress
from tbi_cli.shards import Shard
from tbi_cli.store import Dim, History, StoreError, Variable
from tbi_cli.workers import Workers

_HEAD = """# Python

The same path as the command line: `load_case` reads and validates, `run` solves and writes, `open_results`
reads. Every number is SI.

```python
from tbi_cli import Options, load_case, open_results, run

case = load_case("paper", overrides=["bridge.length=40 m"])
summary = run(case, Options(output="results.h5", overwrite=True))
with open_results(summary.path) as results:
    print(results.table("peak", "right_midspan"))
```

What a user can get wrong is a `tbi_cli.errors.UserError`, whose text is the message that the command line
prints. In a script that uses `Workers("processes")`, call `run` below `if __name__ == "__main__":`, as always
with Python's worker processes. [How to work in a notebook](../how-to/notebook.md) shows more.
"""
_ALSO: dict[str, Any] = {
    "tbi_cli.workers.Workers": Workers,
    "tbi_cli.shards.Shard": Shard,
    "tbi_cli.runner.Progress": Progress,
    "tbi_cli.store.Dim": Dim,
    "tbi_cli.store.Variable": Variable,
    "tbi_cli.store.History": History,
    "tbi_cli.errors.UserError": UserError,
    "tbi_cli.case.CaseError": CaseError,
    "tbi_cli.store.StoreError": StoreError,
}
_LEFT_OUT = {"Case": ("swept", "model_post_init"), "StoreError": ("from_os",)}


def page() -> str:
    """The page of everything that `tbi_cli` offers, and of what that takes and gives."""
    functions = ["load_case", "run", "open_results"]
    offered = [*functions, *sorted(set(tbi_cli.__all__) - set(functions))]
    things = {f"tbi_cli.{name}": getattr(tbi_cli, name) for name in offered} | _ALSO
    return _HEAD + "".join(_section(name, thing) for name, thing in things.items())


def _section(name: str, thing: Any) -> str:
    short = name.rpartition(".")[2]
    text = f"\n## {name}\n\n"
    if not inspect.isclass(thing):
        return f"{text}```text\n{short}{_signature(thing)}\n```\n\n{inspect.getdoc(thing)}\n"
    if hasattr(thing, "__dataclass_fields__"):
        text += f"```text\n{short}{_signature(thing, to_make_one=True)}\n```\n\n"
    text += f"{inspect.getdoc(thing)}\n"
    for key, member in vars(thing).items():
        public = not key.startswith("_") and key not in _LEFT_OUT.get(short, ())
        if not public or not (member.__class__ in _MEMBERS or inspect.isfunction(member)):
            continue
        shown = key if isinstance(member, property) else f"{key}{_signature(getattr(thing, key))}"
        doc = inspect.getdoc(getattr(thing, key) if not isinstance(member, property) else member) or ""
        text += f"\n- `{shown}`: {' '.join(doc.split())}"
    return text.rstrip() + "\n"


_MEMBERS = (property, classmethod, staticmethod)


def _signature(thing: Any, to_make_one: bool = False) -> str:
    """The parameters as they are called; of a class, those to make one of it."""
    signature = inspect.signature(thing)
    if to_make_one:
        signature = signature.replace(return_annotation=inspect.Signature.empty)
    parameters = [p for name, p in signature.parameters.items() if name not in ("self", "cls")]
    text = str(signature.replace(parameters=parameters)).replace("<factory>", "...")
    # Annotations are texts, and shown in quotes.
    return re.sub(r"(: |-> )'([^']*)'", r"\1\2", text)
