"""`tbi submit`."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from tbi_cli.cli import options


def submit(
    case: options.CaseFile,
    output: options.Output = None,
    shards: Annotated[
        int | None,
        typer.Option("--shards", min=1, help="Tasks of the array job.  [default: 16, or one per scenario]"),
    ] = None,
    at_once: Annotated[
        int | None, typer.Option("--at-once", min=1, help="Shards that may run at the same time.")
    ] = None,
    partition: Annotated[str, typer.Option("--partition", help="Slurm's --partition.")] = "",
    account: Annotated[str, typer.Option("--account", help="Slurm's --account.")] = "",
    time: Annotated[str, typer.Option("--time", help="Time limit of each job, e.g. 04:00:00.")] = "",
    memory: Annotated[str, typer.Option("--mem", help="Memory of each job, e.g. 4G.")] = "",
    cpus: Annotated[int, typer.Option("--cpus-per-task", min=1, help="CPUs of each shard.")] = 1,
    sbatch: Annotated[
        list[str] | None,
        typer.Option(
            "--sbatch", metavar="OPTION", help="A further #SBATCH line, e.g. --qos=long.  Repeatable."
        ),
    ] = None,
    setup: Annotated[
        list[str] | None,
        typer.Option(
            "--setup", metavar="COMMAND", help="Run first in every job, e.g. 'module load gcc'.  Repeatable."
        ),
    ] = None,
    report: Annotated[bool, typer.Option("--report", help="Make the report at the end.")] = False,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Print the scripts and do nothing.")] = False,
    set_: options.Set = None,
    resume: Annotated[bool, typer.Option("--resume", help="Send the shards that are not finished.")] = False,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Begin afresh.")] = False,
    strict: options.Strict = False,
    quiet: options.Quiet = False,
) -> None:
    """Send a run to Slurm: an array of shards, and what joins them."""
    from tbi_cli.cli.run import load
    from tbi_cli.cluster.job import Allowance
    from tbi_cli.cluster.submission import array_run, sent_lines
    from tbi_cli.cluster.submission import dry_run as rehearse
    from tbi_cli.cluster.submission import submit as send

    def say(text: str) -> None:
        print(text, file=sys.stderr, flush=True)

    loaded = load(case, set_, strict, None)
    allowance = Allowance(
        partition=partition,
        account=account,
        time=time,
        memory=memory,
        cpus=cpus,
        at_once=at_once,
        extra=tuple(line.removeprefix("#SBATCH").strip() for line in sbatch or ()),
        setup=tuple(setup or ()),
    )
    results = (output or Path(loaded.output.file)).absolute()
    run = array_run(results, shards, loaded, allowance, resume=resume, say=say)
    if dry_run:
        print(rehearse(run, report=report), end="")
        return
    sent = send(run, loaded, report=report, resume=resume, overwrite=overwrite, say=say)
    if not quiet:
        print("\n".join(sent_lines(run, sent)))
