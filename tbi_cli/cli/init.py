"""`tbi init`."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Annotated

import typer


def init(
    folder: Annotated[
        Path, typer.Argument(readable=False, metavar="DIR", help="Where to write case.yaml.")
    ] = Path(),
    train: Annotated[str, typer.Option("--train", help="A built-in train.")] = "paper",
    bridge: Annotated[
        str | None,
        typer.Option("--bridge", help="A built-in bridge; else simply-supported, or whole-deck for forces."),
    ] = None,
) -> None:
    """Write a commented starter case that runs as it is."""
    from tbi_cli.case import starter_case
    from tbi_cli.errors import UserError

    text = starter_case(train, bridge)
    path = folder / "case.yaml"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with path.open("x", encoding="utf-8") as file:
            file.write(text)
    except FileExistsError:
        raise UserError(f"{path}: exists already; name another folder") from None
    except OSError as error:
        raise UserError.from_os(path, error) from None
    named = shlex.quote(str(path))
    print(f"{path} is ready: tbi validate {named}, tbi run {named}")
