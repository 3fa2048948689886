"""Sending a run to Slurm: an array job of shards, a job that joins them, and one that draws the report."""

from __future__ import annotations

import json
import math
import shlex
import shutil
import sys
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tbi_cli.case import Case, load_case
from tbi_cli.case.emit import emit_yaml
from tbi_cli.cluster import slurm
from tbi_cli.cluster.job import Allowance, ArrayRun, submission_folder
from tbi_cli.cluster.joining import statuses
from tbi_cli.cluster.scripts import scripts
from tbi_cli.errors import UserError
from tbi_cli.store import FAILED, StoreError
from tbi_cli.store.durable import write_text
from tbi_cli.store.lock import refuse_if_held
from tbi_cli.store.parts import parts_folder

_NOTE = "submission.json"
_USUAL_SHARDS = 16


class SubmitError(UserError):
    """A run that cannot be sent as asked; the text is the complete message."""


@dataclass(frozen=True)
class Sent:
    """The jobs that were sent, by what they do, and the shards that the array job solves."""

    jobs: dict[str, str]
    shards: tuple[int, ...]


def submit(
    run: ArrayRun, case: Case, *, report: bool, resume: bool, overwrite: bool, say: Callable[[str], None]
) -> Sent:
    """Writes the job scripts and sends them; compiles the kernels before, so that no array of jobs does.

    With `resume` only the shards that are not finished are sent; `overwrite` begins afresh.  Raises
    SubmitError, SlurmError or StoreError, with nothing sent.
    """
    from tbi_cli.integrator.kernel_cache import compile_kernels
    from tbi_cli.studies import kernels_of, solver_of

    slurm.check_here()
    _check(run, case, resume=resume, overwrite=overwrite)
    compile_kernels(say, kernels_of(solver_of(case)))
    for folder in (run.folder, run.folder / "log", run.folder / "shards"):
        folder.mkdir(exist_ok=True)
    if overwrite:
        _remove_shards(run)
    write_text(run.case, case_text(case, run.results.name))
    made = scripts(run, report=report)
    for name, text in made.items():
        write_text(run.script(name), text)
    left = tuple(number for number in range(1, run.shards + 1) if not _is_finished(run.shard_file(number)))
    if not left and _is_finished(run.results):
        return Sent({}, left)
    jobs = _send(run, made, left)
    note = {"shards": run.shards, "jobs": jobs}
    write_text(run.folder / _NOTE, json.dumps(note, indent=1))
    return Sent(jobs, left)


def _send(run: ArrayRun, made: Iterable[str], left: Sequence[int]) -> dict[str, str]:
    jobs: dict[str, str] = {}
    try:
        for name in made:
            if name == "shard":
                if left:
                    jobs[name] = slurm.send(run.script(name), array=array_of(left, run.allowance.at_once))
            elif name == "merge":
                jobs[name] = slurm.send(run.script(name), after=f"afterany:{jobs['shard']}" if left else "")
            else:
                jobs[name] = slurm.send(run.script(name), after=f"afterok:{jobs['merge']}")
    except slurm.SlurmError:
        for job in jobs.values():
            slurm.cancel(job)
        raise
    return jobs


def sent_lines(run: ArrayRun, sent: Sent) -> list[str]:
    """What was sent, for people."""
    does = {
        "shard": f"{len(sent.shards)} of {run.shards} shards, logs in {run.folder / 'log'}",
        "merge": f"joins them into {run.results}",
        "report": "makes the report",
    }
    if not sent.jobs:
        return [f"nothing is left to do: {run.results}"]
    return [
        *(f"job {job}: {does[name]}" for name, job in sent.jobs.items()),
        f"see how far it is with: tbi status {shlex.quote(str(run.results))}",
    ]


def dry_run(run: ArrayRun, *, report: bool) -> str:
    """The scripts, and how they would be sent."""
    made = scripts(run, report=report)
    text = "".join(f"# ---- {run.script(name)}\n{script}\n" for name, script in made.items())
    array = array_of(range(1, run.shards + 1), run.allowance.at_once)
    sent = [f"sbatch --array={array} {run.script('shard')}"]
    sent += [f"sbatch --dependency=afterany:SHARDS {run.script('merge')}"]
    sent += [f"sbatch --dependency=afterok:MERGE {run.script('report')}"] if report else []
    return text + "# ---- to be sent with\n" + "".join(f"# {line}\n" for line in sent)


def array_run(
    results: Path,
    wanted: int | None,
    case: Case,
    allowance: Allowance,
    *,
    resume: bool,
    say: Callable[[str], None],
) -> ArrayRun:
    """The run in as many shards as wanted, but no more than scenarios, or than Slurm allows in an array.

    A run that is resumed keeps its number of shards.
    """
    note = read_note(submission_folder(results)) if resume else None
    grids = case.studies.values() if case.studies else [case]
    scenarios = sum(math.prod(len(axis) for axis in grid.axes) for grid in grids)
    most = slurm.largest_array_index()
    if wanted is None:
        wanted = note["shards"] if note else min(_USUAL_SHARDS, scenarios, most)
    shards = min(wanted, scenarios, most)
    if shards < wanted:
        why = "Slurm's MaxArraySize allows no more" if most < scenarios else "there are no more scenarios"
        say(f"{shards} shards instead of {wanted}: {why}")
    return ArrayRun(results, shards, sys.executable, allowance)


def array_of(indices: Sequence[int], at_once: int | None) -> str:
    """Indices as sbatch takes them: 1-4,7,9-10%2."""
    runs: list[list[int]] = []
    for index in indices:
        if runs and index == runs[-1][1] + 1:
            runs[-1][1] = index
        else:
            runs.append([index, index])
    text = ",".join(f"{first}-{last}" if last > first else f"{first}" for first, last in runs)
    return text if at_once is None else f"{text}%{at_once}"


def case_text(case: Case, results: str) -> str:
    """The resolved case, whose results go into a file of that name in the folder where it is run."""
    resolved = case.resolved()
    resolved["output"] = {**resolved["output"], "file": results}
    return emit_yaml(resolved)


def read_note(folder: Path) -> dict[str, Any] | None:
    """What was sent from a submission's folder; None if nothing was."""
    try:
        note = json.loads((folder / _NOTE).read_text(encoding="utf-8"))
        return {"shards": int(note["shards"]), "jobs": dict(note["jobs"])}
    except FileNotFoundError:
        return None
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise SubmitError(f"{folder / _NOTE}: cannot be read ({error})") from None


def _check(run: ArrayRun, case: Case, *, resume: bool, overwrite: bool) -> None:
    """Raises SubmitError if an earlier submission, or a results file, is in the way."""
    if resume and overwrite:
        raise SubmitError("--resume and --overwrite exclude each other")
    note = read_note(run.folder)
    if note is None:
        if run.results.exists() and not overwrite:
            raise SubmitError(f"{run.results}: exists already; --overwrite replaces it")
        return
    if not (resume or overwrite):
        raise SubmitError(
            f"{run.folder}: was sent before; --resume sends what is not finished, --overwrite starts afresh"
        )
    waiting = slurm.queued(list(note["jobs"].values()))
    if waiting:
        raise SubmitError(f"{run.folder}: job {waiting[0]} is still queued or running")
    if resume and note["shards"] != run.shards:
        raise SubmitError(
            f"--shards: {run.folder} has {note['shards']} shards, not {run.shards}; --overwrite starts afresh"
        )
    if resume and load_case(run.case).sha256 != case.sha256:
        raise SubmitError(f"{run.case}: is another case; --overwrite starts afresh")


def _remove_shards(run: ArrayRun) -> None:
    """Removes the shards of an earlier submission, unless one of them is being written."""
    folder = run.folder / "shards"
    for path in folder.iterdir():
        if path.is_dir():
            refuse_if_held(path, path)
    for path in folder.iterdir():
        if path.is_dir():
            shutil.rmtree(path)
        else:
            path.unlink()


def _is_finished(shard: Path) -> bool:
    """Whether a shard's results file is there, complete, and no failed scenario is to be tried again."""
    if not shard.exists() or parts_folder(shard).exists():
        return False
    try:
        return not (statuses(shard) == FAILED).any()
    except StoreError:
        return False
