"""The commands and their options, from the program itself."""

from __future__ import annotations

import inspect
from pathlib import Path
from typing import Annotated, Any, Literal, get_args, get_origin, get_type_hints

from typer.models import ArgumentInfo

from scripts.reference.markdown import code, table
from tbi_cli.cli import app

_NAMES = {int: "N", float: "NUMBER", str: "TEXT", Path: "PATH"}
_HEAD = """# Commands

`tbi COMMAND --help` says the same on the terminal. `python -m tbi_cli` is the same program.

## Exit codes

| code | meaning |
| --- | --- |
| 0 | done |
| 1 | a scenario failed, or a verification fell short; or memory, threads or open files ran short |
| 2 | the input is wrong; the message on standard error says where, what was expected and what was found. Or a file, or standard output, cannot be written (a full disk, a closed stream) |
| 75 | stopped by SIGTERM or SIGUSR1: what was finished is kept, `--resume` goes on |
| 130 | interrupted (Ctrl-C): what was finished is kept, `--resume` goes on |
| 141 | what reads standard output has stopped reading, as `head` does; there is no message |

Except for 2 where the input is wrong, what was finished is kept. What cannot be written to standard error is lost,
and the work goes on. Where the encoding of a stream lacks a sign, one like it is written: u for the micro sign.

## Environment

| variable | is |
| --- | --- |
| `TBI_CACHE_DIR` | the folder for compiled kernels; see [Clusters](../CLUSTER.md#compiled-kernels) |
| `XDG_CACHE_HOME`, `XDG_CONFIG_HOME` | the user's folders, where they are absolute paths; else they are ignored |
| `TMPDIR` | the folder for temporary files |
| `SLURM_CPUS_PER_TASK` | how many batches are solved at a time without `--jobs`, where it is a number from 1 to 9999 |
| `SLURM_JOB_ID` and others of Slurm's | go into the results file, and tell whose lock a run has left behind |
| `COLUMNS` | how wide help is printed |

Settings of libraries are not taken from the environment, because they would change or end a run: those of numba, tqdm,
Pillow (`NUMBA_*`, `TQDM_*`, `PILLOW_*`), `MPLBACKEND`, `SOURCE_DATE_EPOCH` (the pictures hold no dates), NumPy's choice
of instructions, HDF5's of drivers, and how joblib starts workers.

## Shell completion

`tbi --install-completion` adds completion of commands and options to the shell that it is called from (bash,
zsh, fish or PowerShell); start a new shell afterwards. `tbi --show-completion` prints the script instead, for
a shell whose start-up files are kept elsewhere: `tbi --show-completion > FILE`, with FILE where the shell
reads its completions from.
"""  # noqa: E501 - rows of tables


def page() -> str:
    """The page of all commands."""
    return _HEAD + "".join(_command(str(info.name), info.callback) for info in app.registered_commands)


def _command(name: str, function: Any) -> str:
    hints = get_type_hints(function, include_extras=True)
    parameters = [
        (word, _without_none(hints[word]), parameter.default)
        for word, parameter in inspect.signature(function).parameters.items()
    ]
    arguments, rows = [], []
    for word, hint, default in parameters:
        kind, info = hint.__origin__, hint.__metadata__[0]
        text = _text(info.help, default)
        if isinstance(info, ArgumentInfo):
            named = (info.metavar or word.upper()) + ("..." if get_origin(kind) is list else "")
            arguments.append(named if default is inspect.Parameter.empty else f"[{named}]")
            rows.append([code(arguments[-1]), text])
        else:
            # In Annotated the first spelling is taken for a default, until typer makes the command.
            spelled = ", ".join(
                [*([info.default] if isinstance(info.default, str) else []), *info.param_decls]
            )
            rows.append(
                [code(spelled if kind is bool else f"{spelled} {info.metavar or _value(kind)}"), text]
            )
    usage = " ".join(["tbi", name, "[OPTIONS]", *arguments])
    return (
        f"\n## tbi {name}\n\n{inspect.getdoc(function)}\n\n```text\n{usage}\n```\n\n{table(['', ''], rows)}"
    )


def _without_none(hint: Any) -> Any:
    """The annotation of an optional parameter as if it were not optional."""
    kind = hint.__origin__
    some = [one for one in get_args(kind) if one is not type(None)]
    if type(None) in get_args(kind) and len(some) == 1:
        return Annotated[some[0], hint.__metadata__[0]]
    return hint


def _value(kind: Any) -> str:
    """How the value of an option is called that has no name of its own."""
    return "|".join(get_args(kind)) if get_origin(kind) is Literal else _NAMES[kind]


def _text(text: str | None, default: Any) -> str:
    """The help text with the default, where the text does not say it itself."""
    shown = isinstance(default, str | int | float | Path) and not isinstance(default, bool)
    return f"{text}  [default: {default}]" if shown and "[default" not in str(text) else str(text)
