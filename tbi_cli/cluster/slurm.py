"""What is asked of Slurm, by its own commands."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path

from tbi_cli.errors import UserError

_USUAL_LARGEST_INDEX = 1000
_SECONDS_TO_ANSWER = 60
_SHOWN = 1000  # characters of what a command says in a message


class SlurmError(UserError):
    """Slurm is not there, or refuses; the text is the complete message."""


def largest_array_index() -> int:
    """The largest index of an array job: one less than MaxArraySize, or than its usual value."""
    try:
        told = _ask(["scontrol", "show", "config"])
    except SlurmError:
        told = ""
    found = re.search(r"^MaxArraySize\s*=\s*([0-9]{1,9})\b", told, re.MULTILINE)
    return max(int(found[1]) - 1 if found else _USUAL_LARGEST_INDEX, 1)


def check_here() -> None:
    """Raises SlurmError where no jobs can be sent to Slurm."""
    if shutil.which("sbatch") is None:
        raise SlurmError("sbatch: not found; is this a machine from which jobs are sent to Slurm?")


def send(script: Path, *, array: str = "", after: str = "") -> str:
    """Sends a job script and returns the job's id.

    `array` lists the indices of an array job; `after` is a dependency such as afterany:17.
    """
    command = ["sbatch", "--parsable"]
    command += [f"--array={array}"] if array else []
    command += [f"--dependency={after}", "--kill-on-invalid-dep=yes"] if after else []
    answer = _ask([*command, str(script)])
    job = answer.strip().split(";")[0]
    if re.fullmatch("[0-9]{1,18}", job) is None:
        raise SlurmError(f"sbatch: expected the number of a job, got {_in_short(answer) or 'nothing'}")
    return job


def cancel(job: str) -> None:
    """Takes a job back."""
    _ask(["scancel", job])


def queued(jobs: Sequence[str]) -> list[str]:
    """Those of the jobs that wait or run."""
    if not jobs:
        return []
    known = _ask(["squeue", "--noheader", "--me", "--format=%A %F"]).split()
    return [job for job in jobs if job in known]


def requeue_this_job(*, progress_made: bool) -> str:
    """Has Slurm run the job of this process once more; returns a line about it.

    A job that has got nowhere is not run again: it would not get anywhere the next time either.
    """
    job = os.environ.get("SLURM_JOB_ID")
    if not job:
        return "not run again: this is not a Slurm job"
    if not progress_made:
        return f"job {job} is not run again: no batch was finished within its time; give it more (--time)"
    try:
        _ask(["scontrol", "requeue", job])
    except SlurmError as error:
        return f"job {job} could not be queued again: {error}"
    return f"job {job} is queued again, to go on where it stopped"


def _ask(command: Sequence[str]) -> str:
    """What a command of Slurm prints.  Raises SlurmError."""
    try:
        answer = subprocess.run(command, capture_output=True, timeout=_SECONDS_TO_ANSWER, check=False)
    except FileNotFoundError:
        raise SlurmError(f"{command[0]}: not found") from None
    except (OSError, subprocess.TimeoutExpired) as error:
        raise SlurmError(f"{command[0]}: {error}") from None
    out, err = (stream.decode("utf-8", "surrogateescape") for stream in (answer.stdout, answer.stderr))
    if answer.returncode:
        said = _in_short(err or out)
        raise SlurmError(f"{command[0]}: {said or f'ended with code {answer.returncode}'}")
    return out


def _in_short(answer: str) -> str:
    """An answer on one line, which may be of any length."""
    line = " ".join(answer.split())
    return line if len(line) <= _SHOWN else f"{line[:_SHOWN]}..."
