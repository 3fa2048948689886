"""`tbi reproduce`."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path
from typing import Annotated

import typer

from tbi_cli.cli import options

FAILED = 1


def reproduce(
    results: Annotated[
        list[Path] | None,
        typer.Argument(
            readable=False, metavar="RESULTS.h5", help="Results files.  [default: run what is needed]"
        ),
    ] = None,
    output: Annotated[
        Path,
        typer.Option(
            "-o", "--output", readable=False, help="Folder for the results files and the comparison."
        ),
    ] = Path("reproduction"),
    jobs: options.Jobs = None,
    overwrite: options.Overwrite = False,
    quiet: options.Quiet = False,
) -> None:
    """Run the paper's studies; print its numbers beside ours.

    What an earlier run finished in the folder is kept.  `tbi report FOLDER/*.h5` then draws every figure.
    """
    from tbi_cli.report.claims import to_text
    from tbi_cli.reproduce import compare, write

    found = results or _run(output, jobs, overwrite, quiet)
    entries = compare(found)
    files = write(entries, output)
    if not quiet:
        print(to_text(entries))
        print(f"comparison: {files.text}, {files.csv}, {files.json}")
        if not results:
            print(f"figures and tables: tbi report {shlex.quote(str(output))}/*.h5")


def _run(folder: Path, jobs: int | None, overwrite: bool, quiet: bool) -> list[Path]:
    from tbi_cli.advice import go_on
    from tbi_cli.cli.progress import Terminal
    from tbi_cli.cli.stopping import stop_on_signals
    from tbi_cli.reproduce import run_paper
    from tbi_cli.runner import Silence, this_command
    from tbi_cli.workers import Workers

    with stop_on_signals() as stop:
        progress = Silence() if quiet else Terminal()
        summaries = run_paper(
            folder, workers=Workers(jobs=jobs), overwrite=overwrite, progress=progress, stop=stop
        )
    if summaries[-1].left:
        print(f"stopped: what is finished is kept; {go_on(this_command())}", file=sys.stderr)
        raise typer.Exit(stop.exit_code)
    failures = [message for summary in summaries for message in summary.messages]
    for message in failures:
        print(f"failed: {message}", file=sys.stderr)
    if failures:
        raise typer.Exit(FAILED)
    return [summary.path for summary in summaries]
