"""`tbi run` and `tbi sweep`."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Annotated

import typer

from tbi_cli.cli import options

if TYPE_CHECKING:
    from pathlib import Path

    from tbi_cli.case import Case, ExtraAxis
    from tbi_cli.runner import Options

FAILED = 1


def run(
    case: options.CaseFile,
    output: options.Output = None,
    jobs: options.Jobs = None,
    backend: options.Backend = "threads",
    scheduler: options.Scheduler = None,
    shard: options.Shard = None,
    requeue: options.Requeue = False,
    set_: options.Set = None,
    resume: options.Resume = False,
    overwrite: options.Overwrite = False,
    strict: options.Strict = False,
    quiet: options.Quiet = False,
    verbose: options.Verbose = False,
) -> None:
    """Solve every scenario of a case file; write the results file."""
    how = _options(output, jobs, backend, scheduler, shard, resume, overwrite)
    _run(load(case, set_, strict, None), how, requeue, quiet, verbose)


def sweep(
    axis: Annotated[
        str,
        typer.Argument(
            metavar="AXIS",
            help="velocity, car_body_mass, span, damping, modes, sampling, or a key of the case.",
        ),
    ],
    case: options.OptionalCaseFile = None,
    from_: Annotated[str | None, typer.Option("--from", help='First value, e.g. 2 or "10 km/h".')] = None,
    to: Annotated[str | None, typer.Option("--to", help="Last value.")] = None,
    step: Annotated[str | None, typer.Option("--step", help="Distance of the values.")] = None,
    values: Annotated[str | None, typer.Option("--values", help='A list, e.g. "30, 40, 50, 60".')] = None,
    output: options.Output = None,
    jobs: options.Jobs = None,
    backend: options.Backend = "threads",
    scheduler: options.Scheduler = None,
    shard: options.Shard = None,
    requeue: options.Requeue = False,
    set_: options.Set = None,
    resume: options.Resume = False,
    overwrite: options.Overwrite = False,
    strict: options.Strict = False,
    quiet: options.Quiet = False,
    verbose: options.Verbose = False,
) -> None:
    """Solve a case over one more axis, such as velocity.

    An axis that the case has already is replaced.  Without a range velocity takes the paper's: 2 to 200 m/s
    by 0.5.
    """
    from tbi_cli.case import ExtraAxis

    extra = ExtraAxis(axis, start=from_, stop=to, step=step, values=values)
    how = _options(output, jobs, backend, scheduler, shard, resume, overwrite)
    _run(load(case, set_, strict, extra), how, requeue, quiet, verbose)


def load(source: str | None, overrides: list[str] | None, strict: bool, extra: ExtraAxis | None) -> Case:
    """The case that a command names; what is odd about it goes to standard error."""
    from tbi_cli.case import load_case

    case = load_case(source, overrides=overrides or (), extra_axis=extra, strict=strict)
    for warning in case.warnings:
        print(warning, file=sys.stderr)
    return case


def _options(
    output: Path | None,
    jobs: int | None,
    backend: str,
    scheduler: str | None,
    shard: str | None,
    resume: bool,
    overwrite: bool,
) -> Options:
    from tbi_cli.runner import Options, this_command
    from tbi_cli.shards import Shard
    from tbi_cli.workers import Workers

    return Options(
        output=output,
        workers=Workers(backend, jobs, scheduler),
        shard=Shard.parse(shard) if shard is not None else None,
        resume=resume,
        overwrite=overwrite,
        command=this_command(),
    )


def _run(case: Case, how: Options, requeue: bool, quiet: bool, verbose: bool) -> None:
    from tbi_cli.cli.progress import Terminal
    from tbi_cli.cli.stopping import stop_on_signals
    from tbi_cli.cli.summary import print_summary, unsettled
    from tbi_cli.cluster.slurm import requeue_this_job
    from tbi_cli.runner import Silence
    from tbi_cli.runner import run as solve

    with stop_on_signals() as stop:
        summary = solve(case, how, progress=Silence() if quiet else Terminal(), stop=stop)
        if requeue and summary.left and stop.time_is_nearly_up:
            print(requeue_this_job(progress_made=summary.solved > 0), file=sys.stderr)
    for message in summary.messages:
        print(f"failed: {message}", file=sys.stderr)
    if not quiet:
        print_summary(summary, how.command, every_channel=verbose)
    if summary.unsettled:
        print(unsettled(summary.unsettled), file=sys.stderr)
    if summary.left:
        raise typer.Exit(stop.exit_code)
    if summary.failed:
        raise typer.Exit(FAILED)
