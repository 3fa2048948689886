"""What a Slurm job of tbi is: where its files are, what it may use, and how it is called."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path

from tbi_cli.errors import UserError
from tbi_cli.shards import Shard

# Slurm reads paths in job scripts with quotes and backslashes of its own meaning.
_AWKWARD = re.compile(r"[\"'\\]")


def _is_text(words: str) -> bool:
    """Whether a shell script can hold it: no null characters, and no bytes that are not UTF-8."""
    return re.search("[\0\ud800-\udfff]", words) is None


@dataclass(frozen=True)
class Allowance:
    """What Slurm gives each job, in Slurm's own words; empty where the cluster's defaults hold.

    `extra` are options for further #SBATCH lines, `setup` commands that load an environment, `at_once` is how
    many shards may run at the same time, `warning` how many seconds before its end a job is told of it.
    """

    partition: str = ""
    account: str = ""
    time: str = ""
    memory: str = ""
    cpus: int = 1
    at_once: int | None = None
    warning: int = 60
    extra: tuple[str, ...] = ()
    setup: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        words = {"partition": self.partition, "account": self.account, "time": self.time, "mem": self.memory}
        for name, value in words.items():
            if re.search(r"\s", value):
                raise UserError(f"--{name}: expected one word, got {value!r}")
        for name, lines in (*((name, (value,)) for name, value in words.items()), ("setup", self.setup)):
            if not all(_is_text(line) for line in lines):
                raise UserError(f"--{name}: expected text, got {lines[0]!r}")
        for line in self.extra:
            if not re.fullmatch(r"--?[A-Za-z][^\n\r]*", line) or not _is_text(line):
                raise UserError(f"--sbatch: expected an option of sbatch, e.g. --qos=long; got {line!r}")


@dataclass(frozen=True)
class ArrayRun:
    """A run cut into shards, one for each task of an array job.  Paths are absolute.

    Everything but the results file themselves lies in `folder`: the resolved case, scripts, logs, shards.
    """

    results: Path
    shards: int
    python: str
    allowance: Allowance = field(default_factory=Allowance)

    def __post_init__(self) -> None:
        if _AWKWARD.search(str(self.results)) or not str(self.results).isprintable():
            raise UserError(
                f"{str(self.results)!r}: quotes, backslashes and what cannot be printed confuse Slurm"
            )

    @property
    def folder(self) -> Path:
        """The folder of the run's own files, beside the results file."""
        return submission_folder(self.results)

    @property
    def case(self) -> Path:
        """The case as it was sent."""
        return self.folder / "case.yaml"

    def script(self, name: str) -> Path:
        """The script of the jobs shard, merge and report."""
        return self.folder / f"{name}.sh"

    def shard_file(self, number: int) -> Path:
        """The results of one shard."""
        return Shard(number, self.shards).path(self.folder / "shards" / self.results.name)


def submission_folder(results: Path) -> Path:
    """Where `tbi submit` keeps what belongs to a results file: results-slurm for results.h5."""
    return results.with_name(f"{results.stem}-slurm")
