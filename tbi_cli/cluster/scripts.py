"""The job scripts.  They are meant to be read, and changed by hand if need be."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from pathlib import Path

from tbi_cli.cluster.job import ArrayRun


def scripts(run: ArrayRun, *, report: bool) -> dict[str, str]:
    """The text of each job script, by its name, in the order in which they are sent."""
    made = {"shard": shard_script(run), "merge": merge_script(run)}
    return made | ({"report": report_script(run)} if report else {})


def shard_script(run: ArrayRun) -> str:
    """The script of the array job: a task solves the shard of its index."""
    options = [
        f"--signal=B:USR1@{run.allowance.warning}",
        "--requeue",
        f"--cpus-per-task={run.allowance.cpus}",
    ]
    body = [
        "# Slurm signals this script when its time is nearly up; exec puts tbi in its place.  tbi writes",
        "# what is finished, has the task queued again, and goes on from there.",
        f"cd {_quoted(run.folder / 'shards')}",
        f'exec {_tbi(run)} run ../case.yaml --shard "$SLURM_ARRAY_TASK_ID/{run.shards}" --resume --requeue',
    ]
    return _script(run, "solves one shard", "shard-%a", options, body)


def merge_script(run: ArrayRun) -> str:
    """The script that joins the shards; it runs when all of them have ended, and refuses gaps."""
    shards = f"./{_quoted(run.results.stem)}.shard-*-of-{run.shards}{_quoted(run.results.suffix)}"
    body = [
        f"cd {_quoted(run.folder / 'shards')}",
        f"exec {_tbi(run)} merge {shards} -o {_quoted(run.results)} --overwrite",
    ]
    return _script(run, "joins the shards", "merge", [], body)


def report_script(run: ArrayRun) -> str:
    """The script that draws the figures."""
    body = [
        f"cd {_quoted(run.results.parent)}",
        f"exec {_tbi(run)} report ./{_quoted(run.results.name)}",
    ]
    return _script(run, "makes the report", "report", [], body)


def _script(run: ArrayRun, does: str, log: str, options: Sequence[str], body: Sequence[str]) -> str:
    a = run.allowance
    asked = {"partition": a.partition, "account": a.account, "time": a.time, "mem": a.memory}
    head = [
        "#!/bin/bash",
        f"# Of {run.results.name}: {does}.  Written by tbi submit.",
        f"#SBATCH --job-name=tbi-{_word(run.results.stem)}",
        f'#SBATCH --output="{_log(run.folder / "log")}/{log}.log"',
        "#SBATCH --open-mode=append",
        "#SBATCH --ntasks=1",
        *(f"#SBATCH {option}" for option in options),
        *(f"#SBATCH --{name}={value}" for name, value in asked.items() if value),
        *(f"#SBATCH {option}" for option in a.extra),
    ]
    return "\n".join([*head, "", *a.setup, *body]) + "\n"


def _tbi(run: ArrayRun) -> str:
    return f"{_quoted(run.python)} -m tbi_cli"


def _quoted(path: Path | str) -> str:
    return shlex.quote(str(path))


def _log(folder: Path) -> str:
    """A path for --output, where Slurm takes a percent sign for the beginning of a pattern."""
    return str(folder).replace("%", "%%")


def _word(text: str) -> str:
    """A name without blanks for a job."""
    return "".join(c if c.isalnum() or c in "-_." else "-" for c in text)
