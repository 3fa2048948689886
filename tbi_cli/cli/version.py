"""What `tbi` itself takes, before any command."""

from __future__ import annotations

from typing import Annotated

import typer

import tbi_cli
from tbi_cli.cli.environment import check_surroundings


def _print_version(wanted: bool) -> None:
    if wanted:
        print(f"tbi {tbi_cli.__version__}")
        raise typer.Exit


def common(
    version: Annotated[
        bool,
        typer.Option("--version", help="Print the version and stop.", callback=_print_version, is_eager=True),
    ] = False,
) -> None:
    """What a train does to a bridge, and the bridge to the train, at every speed, mass and span."""
    check_surroundings()
