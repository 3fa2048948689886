"""Sending a run to Slurm: an array job of shards, a job that joins them, and one that draws the report."""

from __future__ import annotations

import contextlib
import json
import math
import os
import re
import shlex
import shutil
import sys
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tbi_cli.advice import ANOTHER_FILE
from tbi_cli.case import Case, load_case
from tbi_cli.case.emit import emit_yaml
from tbi_cli.cluster import slurm
from tbi_cli.cluster.job import Allowance, ArrayRun, submission_folder
from tbi_cli.cluster.joining import statuses
from tbi_cli.cluster.scripts import scripts
from tbi_cli.errors import UserError
from tbi_cli.shards import MOST_SHARDS
from tbi_cli.store import FAILED, StoreError, check_output
from tbi_cli.store.durable import sync_folder, write_text
from tbi_cli.store.errors import is_missing
from tbi_cli.store.lock import refuse_if_held
from tbi_cli.store.opening import is_there
from tbi_cli.store.parts import parts_folder
from tbi_cli.store.plain import read_plain

_NOTE = "submission.json"
_MOST_BYTES = 1 << 16  # of the note
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
    check_output(run.results, overwrite=True)
    _check(run, case, resume=resume, overwrite=overwrite)
    compile_kernels(say, kernels_of(solver_of(case)))
    made = scripts(run, report=report)
    try:
        _write(run, {run.case: case_text(case, run.results.name)}, made, afresh=overwrite)
    except OSError as error:
        for folder in (*_subfolders(run), run.folder):
            with contextlib.suppress(OSError):  # what holds anything stays
                folder.rmdir()
        raise SubmitError.from_os(
            os.fsdecode(error.filename2 or error.filename or run.folder), error
        ) from error
    left = tuple(number for number in range(1, run.shards + 1) if not _is_finished(run.shard_file(number)))
    if not left and _is_finished(run.results):
        return Sent({}, left)
    jobs = _send(run, made, left)
    try:
        write_text(run.folder / _NOTE, json.dumps({"shards": run.shards, "jobs": jobs}, indent=1))
    except OSError as error:
        _take_back(jobs)
        raise SubmitError.from_os(run.folder / _NOTE, error, "the jobs were taken back") from error
    return Sent(jobs, left)


def _subfolders(run: ArrayRun) -> tuple[Path, Path]:
    return run.folder / "log", run.folder / "shards"


def _write(run: ArrayRun, texts: dict[Path, str], made: dict[str, str], *, afresh: bool) -> None:
    """Writes the case and the scripts of a run, without shards of an earlier one if it begins afresh."""
    for folder in (run.folder, *_subfolders(run)):
        folder.mkdir(exist_ok=True)
        sync_folder(folder.parent)
    if afresh:
        _remove_shards(run)
    for path, text in {**texts, **{run.script(name): text for name, text in made.items()}}.items():
        write_text(path, text)


def _take_back(jobs: dict[str, str]) -> None:
    for job in jobs.values():
        with contextlib.suppress(slurm.SlurmError):  # the first error is the one to tell
            slurm.cancel(job)


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
        _take_back(jobs)
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

    def quoted(name: str) -> str:
        return shlex.quote(str(run.script(name)))

    sent = [f"sbatch --array={array} {quoted('shard')}"]
    sent += [f"sbatch --dependency=afterany:SHARDS {quoted('merge')}"]
    sent += [f"sbatch --dependency=afterok:MERGE {quoted('report')}"] if report else []
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
    if results.name in ("", ".."):
        raise SubmitError(f"{results}: is a folder; name a file in it")
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
    """What was sent from a submission's folder; None if nothing was.  Raises UserError for any other file."""
    path = folder / _NOTE
    try:
        note = json.loads(read_plain(path, _MOST_BYTES))
        shards, jobs = note["shards"], {str(name): str(job) for name, job in note["jobs"].items()}
    except OSError as error:
        if is_missing(error):
            return None
        raise SubmitError.from_os(path, error) from None
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        raise SubmitError(f"{path}: is not what tbi writes there") from None
    if type(shards) is not int or not 1 <= shards <= MOST_SHARDS:
        raise SubmitError(f"{path}: expected 1 to {MOST_SHARDS} shards, got {shards!r:.20}")
    if not all(re.fullmatch("[0-9]{1,18}", job) for job in jobs.values()):
        raise SubmitError(f"{path}: is not what tbi writes there")
    return {"shards": shards, "jobs": jobs}


def _check(run: ArrayRun, case: Case, *, resume: bool, overwrite: bool) -> None:
    """Raises SubmitError if an earlier submission, or a results file, is in the way."""
    if resume and overwrite:
        raise SubmitError("--resume and --overwrite exclude each other")
    note = read_note(run.folder)
    if note is None:
        if is_there(run.results) and not overwrite:
            raise SubmitError(f"{run.results}: exists already; {ANOTHER_FILE}, --overwrite replaces it")
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
            f"--shards: {run.folder} has {note['shards']} shards, not {run.shards}; "
            f"leave it out, or {ANOTHER_FILE}"
        )
    if resume and load_case(run.case).sha256 != case.sha256:
        raise SubmitError(f"{run.case}: is another case; {ANOTHER_FILE}")


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
    try:
        if not is_there(shard) or is_there(parts_folder(shard)):
            return False
        return not (statuses(shard) == FAILED).any()
    except StoreError:
        return False
