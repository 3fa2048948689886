"""`tbi info`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tbi_cli.cli import options

if TYPE_CHECKING:
    from collections.abc import Iterator

    from tbi_cli.store import Results

_PROVENANCE = (
    *("title", "command", "created", "host", "tbi_version", "numpy_version", "numba_version", "h5py_version"),
    *("case_sha256", "git_revision", "shard", "slurm_job_id", "slurm_array_task_id"),
)


def info(
    results: options.ResultsFile,
    diff: Annotated[
        Path | None,
        typer.Option("--diff", readable=False, metavar="OTHER.h5", help="Say what differs from OTHER."),
    ] = None,
    verbose: options.Verbose = False,
) -> None:
    """Show what a results file holds, or how two of them differ.

    Axes, channels, how much is done, where it comes from, and the extremes.
    """
    from tbi_cli.store import open_results, studies_of

    studies = studies_of(results)
    if diff is None:
        for study in studies or ("",):
            with open_results(results, study=study) as opened:
                if study:
                    print(f"study          {study}")
                _show(opened, verbose)
            if study != (studies or ("",))[-1]:
                print()
        return
    lines = list(_differences(results, diff, studies))
    print("\n".join(lines or ["the same case, axes, channels and tables"]))


def _differences(one: Path, other: Path, studies: tuple[str, ...]) -> Iterator[str]:
    """What differs between two files, study by study."""
    from tbi_cli.differences import differences
    from tbi_cli.store import open_results, studies_of

    others = studies_of(other)
    for name in dict.fromkeys([*studies, *others]):
        if name not in studies or name not in others:
            yield f"study {name}: only in the {'first' if name in studies else 'second'}"
    if bool(studies) != bool(others):
        return
    for name in [name for name in studies if name in others] if studies else [""]:
        with open_results(one, study=name) as a, open_results(other, study=name) as b:
            yield from (f"study {name}: {line}" if name else line for line in differences(a, b))


def _show(opened: Results, verbose: bool) -> None:
    import numpy as np

    from tbi_cli.cli.summary import extremes
    from tbi_cli.printable import one_line
    from tbi_cli.store import DONE, FAILED

    status = opened.status
    for dim in opened.dims:
        unit = "" if dim.units == "1" else f" {dim.units}"
        count = len(dim.values)
        ends = f"{dim.values.min():g} to {dim.values.max():g}" if count > 1 else f"{dim.values[0]:g}"
        print(f"axis           {dim.name}: {count} value{'s' if count > 1 else ''}, {ends}{unit}")
    done, failed = int(np.sum(status == DONE)), int(np.sum(status == FAILED))
    print(f"scenarios      {status.size}: {done} done, {failed} failed, {status.size - done - failed} to do")
    if opened.unsettled is not None:
        print(f"converged      all but {len(opened.unsettled)} of those done")
    print(f"channels       {len(opened.channels)} in tables, {len(opened.history_channels)} in histories")
    for key in _PROVENANCE:
        if key in opened.attributes:
            print(f"{key:14} {one_line(str(opened.attributes[key]))}")
    print()
    for line in extremes(opened, every_channel=verbose):
        print(line)
