"""`tbi status`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tbi_cli.cli import options


def status(
    paths: Annotated[
        list[str],
        typer.Argument(
            metavar="CASE.yaml|RESULTS.h5|SHARDS",
            help="A case that is being run, its results file, or shards of it.",
        ),
    ],
    output: options.Output = None,
    set_: options.Set = None,
    verbose: Annotated[bool, typer.Option("-v", "--verbose", help="List every shard.")] = False,
) -> None:
    """Tell how much of a run is done, and how long is left."""
    from tbi_cli.case import load_case
    from tbi_cli.cluster.status import run_status
    from tbi_cli.cluster.status_text import status_lines

    case, files = None, [Path(path) for path in paths]
    if len(paths) == 1 and (
        files[0].suffix in (".yaml", ".yml") or not (files[0].suffix or files[0].exists())
    ):
        case = load_case(paths[0], overrides=set_ or ())
        files = [output or Path(case.output.file)]
    for line in status_lines(run_status(files, case), verbose=verbose):
        print(line)
