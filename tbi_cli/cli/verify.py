"""`tbi verify`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tbi_cli.cli import options

FELL_SHORT = 1


def verify(
    output: Annotated[
        Path,
        typer.Option("-o", "--output", readable=False, help="The page to write; an earlier one is replaced."),
    ] = Path("verification.html"),
    keep: Annotated[
        Path | None,
        typer.Option(
            "--keep",
            readable=False,
            help="Folder for the case files and results files.  [default: none kept]",
        ),
    ] = None,
    quiet: options.Quiet = False,
) -> None:
    """Compare tbi with closed forms and independent solutions.

    Prints a table of what is computed and what it should be, and writes a page of it.
    """
    from tbi_cli.verify.page import check_page_path, write_page
    from tbi_cli.verify.run import case_folder, run_verification
    from tbi_cli.verify.table import table, verdict

    check_page_path(output)
    groups = []
    with case_folder(keep) as folder:
        for group in run_verification(folder):
            groups.append(group)
            for line in table(group, failures_only=quiet):
                print(line, flush=True)
    write_page(output, groups)
    if not quiet:
        print(f"{verdict(groups)}; page: {output}")
    if not all(group.passed for group in groups):
        raise typer.Exit(FELL_SHORT)
