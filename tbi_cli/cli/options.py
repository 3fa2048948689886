"""Options that several commands share, described once."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

CaseFile = Annotated[
    str,
    typer.Argument(metavar="CASE.yaml", help="A case file, or the name of a built-in case (see `tbi list`)."),
]
OptionalCaseFile = Annotated[
    str | None,
    typer.Argument(metavar="CASE.yaml", help="A case file or a built-in name.  [default: the paper's case]"),
]
ResultsFile = Annotated[Path, typer.Argument(readable=False, metavar="RESULTS.h5", help="A results file.")]
Output = Annotated[
    Path | None,
    typer.Option("-o", "--output", readable=False, help="Results file.  [default: output.file of the case]"),
]
Jobs = Annotated[
    int | None,
    typer.Option(
        "-j", "--jobs", min=1, help="Batches solved at a time.  [default: the CPUs this job may use]"
    ),
]
Backend = Annotated[
    str,
    typer.Option(
        "--backend",
        metavar="threads|processes|dask",
        help="Where batches are solved; the numbers are the same.  Processes pay where every scenario has a "
        "train or bridge of its own.",
    ),
]
Scheduler = Annotated[
    str | None,
    typer.Option("--scheduler", metavar="ADDRESS", help="Of the Dask cluster, e.g. tcp://10.0.0.1:8786."),
]
Shard = Annotated[
    str | None,
    typer.Option(
        "--shard", metavar="I/N", help="Solve only the I-th of N parts that cost the same; see `tbi merge`."
    ),
]
Requeue = Annotated[
    bool,
    typer.Option(
        "--requeue",
        help="In a Slurm job: when SIGUSR1 says that time is nearly up, have Slurm run the job once more.",
    ),
]
Set = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="KEY=VALUE",
        help="Change a key of the case, e.g. --set bridge.length='40 m'.  Repeatable.",
    ),
]
Resume = Annotated[
    bool, typer.Option("--resume", help="Solve only what an earlier run left undone or failed.")
]
Overwrite = Annotated[bool, typer.Option("--overwrite", help="Replace an existing results file.")]
Strict = Annotated[bool, typer.Option("--strict", help="Refuse values that are odd but not impossible.")]
Quiet = Annotated[bool, typer.Option("-q", "--quiet", help="Print errors only.")]
Verbose = Annotated[
    bool, typer.Option("-v", "--verbose", help="Print every channel, and how the run was cut up.")
]
