"""The job scripts: pinned by a golden file, and understood by a shell."""

from __future__ import annotations

import os
import re
import subprocess
from dataclasses import replace
from pathlib import Path

import pytest

from tbi_cli.cluster.job import Allowance, ArrayRun
from tbi_cli.cluster.scripts import merge_script, shard_script
from tbi_cli.cluster.submission import array_of, dry_run
from tbi_cli.errors import UserError
from tests.cli.commands import everything_below
from tests.cluster.runs import inside

GOLDEN = Path(__file__).with_name("golden_scripts.txt")
RUN = ArrayRun(
    results=Path("/scratch/user/paper/masses.h5"),
    shards=24,
    python="/opt/python/bin/python",
    allowance=Allowance(
        partition="cpu",
        account="bridges",
        time="04:00:00",
        memory="8G",
        cpus=4,
        at_once=10,
        extra=("--qos=long", "--mail-type=END"),
        setup=("module purge", "module load gcc/13"),
    ),
)


def test_the_scripts_are_the_golden_ones() -> None:
    """Written anew with TBI_WRITE_GOLDEN=1; look at the difference before you commit it."""
    text = dry_run(RUN, report=True)
    if os.environ.get("TBI_WRITE_GOLDEN"):
        GOLDEN.write_text(text)
    assert text == GOLDEN.read_text()


def test_a_dry_run_prints_the_scripts_and_does_nothing(folder: Path) -> None:
    before = everything_below(folder)
    ended = inside("submit", "case.yaml", "--shards", "5", "--time", "10:00", "--dry-run", folder=folder)
    assert ended.code == 0
    assert everything_below(folder) == before
    assert ended.out.count("#!/bin/bash") == 2
    assert f"# ---- {folder / 'results-slurm' / 'shard.sh'}\n" in ended.out
    assert "#SBATCH --time=10:00\n" in ended.out
    assert '--shard "$SLURM_ARRAY_TASK_ID/5" --resume --requeue\n' in ended.out


def test_the_signal_reaches_python() -> None:
    """In every script the last command is tbi, in the shell's place."""
    for script in re.split(r"(?m)^# ---- .*\n", dry_run(RUN, report=True))[1:4]:
        commands = [line for line in script.splitlines() if line and not line.startswith("#")]
        assert commands[-1].startswith("exec /opt/python/bin/python -m tbi_cli ")
    assert "#SBATCH --signal=B:USR1@60\n" in shard_script(RUN)


@pytest.mark.parametrize(
    "name", ["plain", "with blanks", "50%", "$HOME", "a&b;c", "ümlaut", "-dash", "star*"]
)
def test_awkward_paths(tmp_path: Path, name: str) -> None:
    """The shell goes into the folder of the shards and finds them, whatever their path."""
    folder = tmp_path / name
    run = replace(RUN, results=folder / f"{name}.h5", python="echo", allowance=Allowance(), shards=2)
    (run.folder / "shards").mkdir(parents=True)
    for number in (1, 2):
        run.shard_file(number).touch()
    said = subprocess.run(
        ["bash", "-c", merge_script(run)], capture_output=True, text=True, check=True, cwd="/"
    ).stdout
    names = [f"./{run.shard_file(number).name}" for number in (1, 2)]
    assert said == f"-m tbi_cli merge {' '.join(names)} -o {run.results} --overwrite\n"
    assert f'#SBATCH --output="{str(run.folder).replace("%", "%%")}/log/merge.log"\n' in merge_script(run)


@pytest.mark.parametrize("name", ['double"quote', "single'quote", "back\\slash", "new\nline"])
def test_paths_that_slurm_cannot_read(name: str) -> None:
    with pytest.raises(UserError, match="confuse Slurm"):
        replace(RUN, results=Path("/scratch") / name / "results.h5")


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"partition": "two words"}, "--partition: expected one word, got 'two words'"),
        ({"memory": "8G\n#SBATCH --x"}, "--mem: expected one word, got '8G\\n#SBATCH --x'"),
        ({"extra": ("qos=long",)}, "--sbatch: expected an option of sbatch, e.g. --qos=long; got 'qos=long'"),
        (
            {"extra": ("--a\n--b",)},
            "--sbatch: expected an option of sbatch, e.g. --qos=long; got '--a\\n--b'",
        ),
    ],
)
def test_options_that_are_none(changes: dict[str, str], message: str) -> None:
    with pytest.raises(UserError) as caught:
        replace(RUN.allowance, **changes)  # type: ignore[arg-type]
    assert str(caught.value) == message


@pytest.mark.parametrize(
    ("indices", "at_once", "text"),
    [([1, 2, 3, 4], None, "1-4"), ([1, 3, 4, 7], 2, "1,3-4,7%2"), ([5], None, "5"), ([2, 3], 1, "2-3%1")],
)
def test_array_indices(indices: list[int], at_once: int | None, text: str) -> None:
    assert array_of(indices, at_once) == text


def test_no_more_shards_than_scenarios_or_than_slurm_allows(folder: Path) -> None:
    few = ("--set", "sweep={velocity: [40, 50, 60]}", "--dry-run")
    ended = inside("submit", "case.yaml", "--shards", "7", *few, folder=folder)
    assert ended.err == "3 shards instead of 7: there are no more scenarios\n"
    assert '"$SLURM_ARRAY_TASK_ID/3"' in ended.out
    ended = inside("submit", "case.yaml", *few, folder=folder)
    assert ended.err == ""
    assert '"$SLURM_ARRAY_TASK_ID/3"' in ended.out


def test_without_slurm_nothing_is_left_behind(folder: Path) -> None:
    (folder / "bin").mkdir()
    ended = inside("submit", "case.yaml", folder=folder, PATH=str(folder / "bin"))
    assert ended.code == 2
    assert ended.err == "sbatch: not found; is this a machine from which jobs are sent to Slurm?\n"
    assert not list(folder.glob("results*"))
