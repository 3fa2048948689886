"""`tbi export`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import typer

from tbi_cli.cli import options


def export(
    results: options.ResultsFile,
    output: Annotated[
        Path | None,
        typer.Option(
            "-o", "--output", readable=False, help="Folder to write into.  [default: RESULTS-tables]"
        ),
    ] = None,
    form: Annotated[Literal["csv", "parquet"], typer.Option("--format", help="csv or parquet.")] = "csv",
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace files that are there.")] = False,
) -> None:
    """Write the tables of a results file as CSV or Parquet.

    A file per table, a row per scenario, units in the heading.
    """
    from tbi_cli.export import export_tables
    from tbi_cli.store import open_results, studies_of

    folder = output or results.parent / f"{results.stem}-tables"
    studies = studies_of(results)
    for study in studies or ("",):
        with open_results(results, study=study) as opened:
            for path in export_tables(opened, folder / study, form, overwrite=overwrite):
                print(path)
