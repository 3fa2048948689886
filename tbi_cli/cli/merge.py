"""`tbi merge`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tbi_cli.cli import options


def merge(
    shards: Annotated[
        list[Path],
        typer.Argument(readable=False, metavar="SHARDS", help="The results files of all shards of one run."),
    ],
    output: Annotated[
        Path, typer.Option("-o", "--output", readable=False, help="The results file to write.")
    ],
    partial: Annotated[
        bool, typer.Option("--partial", help="Accept missing shards; their scenarios stay to be done.")
    ] = False,
    overwrite: options.Overwrite = False,
    quiet: options.Quiet = False,
) -> None:
    """Join the shards of a run into one results file."""
    from tbi_cli.cluster.joining import join_shards

    for line in join_shards(shards, output, partial=partial, overwrite=overwrite):
        if not quiet:
            print(line)
