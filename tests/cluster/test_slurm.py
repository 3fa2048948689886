"""Real Slurm: a cluster of one node on the loopback interface, whose arrays have three tasks at most."""

from __future__ import annotations

import json
import re
import subprocess
import time
from collections.abc import Callable, Mapping
from pathlib import Path

import h5py
import pytest

from tbi_cli.shards import Shard
from tests.cli.commands import Ended
from tests.cluster.runs import CASE, ENDLESS, SCENARIOS, SLOW, content, inside, parts
from tests.cluster.slurm_here import SlurmHere
from tests.cluster.test_studies import STUDIES
from tests.store.power_cut import check_order, record

pytestmark = pytest.mark.slurm
SECONDS = 300.0

SUBMIT = """
import os, sys
from tbi_cli.__main__ import main
os.chdir(sys.argv[1])
sys.argv[1:] = ["submit", "case.yaml", "--shards", "3"]
main()
"""


def jobs(folder: Path) -> dict[str, str]:
    """The jobs that were sent, by what they do."""
    sent: dict[str, str] = json.loads((folder / "results-slurm" / "submission.json").read_text())["jobs"]
    return sent


def wait_until(true: Callable[[], object]) -> None:
    """Waits until something is true; fails after five minutes."""
    end = time.monotonic() + SECONDS
    while not true():
        assert time.monotonic() < end
        time.sleep(0.05)


def shard(folder: Path, number: int, of: int) -> Path:
    """The file of one shard."""
    return Shard(number, of).path(folder / "results-slurm" / "shards" / "results.h5")


def start_now(slurm: SlurmHere, task: str) -> None:
    """Slurm lets two minutes pass before it starts a job again: it refuses to in the second of its end."""
    time.sleep(2)
    slurm.ask("scontrol", "update", f"JobId={task}", "StartTime=now")


def submit(folder: Path, slurm: SlurmHere, *arguments: str) -> Ended:
    """Sends the case."""
    return inside("submit", "case.yaml", *arguments, folder=folder, **slurm.environment)


def test_an_array_of_shards(tmp_path: Path, slurm: SlurmHere, whole: Mapping[str, bytes]) -> None:
    """More shards wanted than an array may have; a folder with blanks and a percent sign in its name."""
    folder = tmp_path / "50 % of it"
    folder.mkdir()
    (folder / "case.yaml").write_text(CASE)
    ended = submit(
        folder, slurm, "--shards", "16", "--sbatch", "--comment=tbi", "--setup", "export TBI_TEST=1"
    )
    assert ended.code == 0, ended.err
    assert "3 shards instead of 16: Slurm's MaxArraySize allows no more\n" in ended.err
    sent = jobs(folder)
    assert f"job {sent['shard']}: 3 of 3 shards, logs in {folder / 'results-slurm' / 'log'}\n" in ended.out
    again = submit(folder, slurm, "--resume")
    assert again.code == 2
    slurm.wait_for(*sent.values(), seconds=SECONDS)

    assert content(folder / "results.h5") == whole
    assert f"{SCENARIOS} done, 0 failed" in (folder / "results-slurm" / "log" / "merge.log").read_text()
    for number in range(1, 4):
        with h5py.File(shard(folder, number, 3)) as file:
            assert file.attrs["slurm_job_id"] == sent["shard"]
            assert file.attrs["slurm_array_task_id"] == str(number)
            assert file.attrs["shard"] == f"{number}/3"
    with h5py.File(folder / "results.h5") as file:
        assert file.attrs["slurm_job_id"] == sent["merge"]
        assert "shard" not in file.attrs

    ended = submit(folder, slurm)
    assert ended.code == 2
    assert "was sent before; --resume sends what is not finished, --overwrite starts afresh" in ended.err
    ended = submit(folder, slurm, "--resume")
    assert (ended.code, ended.out) == (0, f"nothing is left to do: {folder / 'results.h5'}\n")
    ended = submit(folder, slurm, "--resume", "--set", "velocity=100")
    assert ended.code == 2
    assert "case.yaml: is another case; choose another file with -o" in ended.err

    shard(folder, 3, 3).unlink()
    (folder / "results.h5").unlink()
    ended = submit(folder, slurm, "--resume")
    assert ended.code == 0
    assert "1 of 3 shards" in ended.out
    slurm.wait_for(*jobs(folder).values(), seconds=SECONDS)
    assert content(folder / "results.h5") == whole


def test_an_array_of_studies(tmp_path: Path, slurm: SlurmHere) -> None:
    """Several grids, one of them refined, in every task; what is sent is on the disk, in the right order."""
    (tmp_path / "case.yaml").write_text(STUDIES)
    assert inside("run", "case.yaml", "-o", "whole.h5", "-q", folder=tmp_path).code == 0
    log = tmp_path.with_name(f"{tmp_path.name}.log")
    calls = record(SUBMIT, tmp_path, log, slurm.environment)
    own = [call for call in calls if call.paths[-1].startswith((".", "results-slurm"))]
    taken = check_order(own, re.compile(r"\.unfinished$"))
    assert [Path(name).name for name in taken] == ["case.yaml", "shard.sh", "merge.sh", "submission.json"]
    slurm.wait_for(*jobs(tmp_path).values(), seconds=SECONDS)
    assert content(tmp_path / "results.h5") == content(tmp_path / "whole.h5")
    ended = submit(tmp_path, slurm, "--resume")
    assert (ended.code, ended.out) == (0, f"nothing is left to do: {tmp_path / 'results.h5'}\n")


def test_signalled_requeued_and_resumed(
    folder: Path, slurm: SlurmHere, whole_slow: Mapping[str, bytes]
) -> None:
    """SIGUSR1, as before the end of the time: the task goes back into the queue and on from where it was."""
    ended = submit(folder, slurm, "--shards", "2", *SLOW)
    assert ended.code == 0, ended.err
    sent = jobs(folder)
    task = f"{sent['shard']}_1"
    wait_until(lambda: parts(shard(folder, 1, 2)))
    status = inside("status", "case.yaml", *SLOW, folder=folder)
    assert "shard 1/2: running by process " in status.out
    slurm.ask("scancel", "--signal=USR1", "--batch", task)
    log = folder / "results-slurm" / "log" / "shard-1.log"
    wait_until(lambda: "is queued again, to go on where it stopped" in log.read_text())
    wait_until(lambda: "PENDING" in slurm.ask("squeue", "--noheader", "--format=%T", f"--jobs={task}"))
    kept = len(parts(shard(folder, 1, 2)))
    assert kept
    start_now(slurm, task)
    slurm.wait_for(*sent.values(), seconds=SECONDS)
    assert content(folder / "results.h5") == whole_slow
    assert "of them before)" in log.read_text()


def test_cancelled_tasks_are_told_by_the_merge_job(folder: Path, slurm: SlurmHere) -> None:
    """They leave gaps, which are refused; a cancelled task keeps its batches and does not come back."""
    ended = submit(folder, slurm, "--shards", "2", *ENDLESS)
    assert ended.code == 0, ended.err
    sent = jobs(folder)
    wait_until(lambda: parts(shard(folder, 1, 2)) and parts(shard(folder, 2, 2)))
    slurm.ask("scancel", sent["shard"])
    slurm.wait_for(*sent.values(), seconds=SECONDS)
    assert (folder / "results-slurm" / "log" / "merge.log").read_text().startswith("missing: ")
    assert not (folder / "results.h5").exists()
    status = inside("status", "results.h5", folder=folder)
    assert "shards     2: 2 stopped\n" in status.out
    assert re.search(r"shard 2/2: stopped, [1-9]\d* of 132 done\n", status.out)
    assert "time left  about " in status.out


def test_slurm_refuses(folder: Path, slurm: SlurmHere) -> None:
    """Nothing is sent, and the message is Slurm's own."""
    before = slurm.ask("squeue", "--noheader")
    ended = submit(folder, slurm, "--partition", "nonesuch")
    assert ended.code == 2
    assert ended.err.startswith("sbatch: ")
    assert "invalid partition specified: nonesuch" in ended.err
    assert slurm.ask("squeue", "--noheader") == before


def test_a_node_that_died(folder: Path, slurm: SlurmHere) -> None:
    """Its task, run by Slurm once more, takes over the lock that the first start left behind."""
    ended = submit(folder, slurm, "--shards", "1", *SLOW)
    assert ended.code == 0, ended.err
    sent = jobs(folder)
    results = shard(folder, 1, 1)
    wait_until(lambda: parts(results))
    slurm.ask("scontrol", "requeuehold", f"{sent['shard']}_1")
    wait_until(
        lambda: "PENDING" in slurm.ask("squeue", "--noheader", "--format=%T", f"--jobs={sent['shard']}_1")
    )
    lock = results.with_name(results.name + ".parts") / "lock"
    assert not lock.exists()
    job = subprocess.run(
        ["squeue", "--noheader", "--format=%A", f"--jobs={sent['shard']}_1"],
        env={"PATH": "/usr/bin:/bin", **slurm.environment},
        capture_output=True,
        text=True,
        check=True,
    ).stdout.strip()
    left = {"host": "node17", "boot": "", "namespace": "", "pid": 1, "start": "1", "job": f"tbi-test:{job}"}
    lock.write_text(json.dumps({**left, "restart": "0"}))
    slurm.ask("scontrol", "release", f"{sent['shard']}_1")
    start_now(slurm, f"{sent['shard']}_1")
    slurm.wait_for(*sent.values(), seconds=SECONDS)
    with h5py.File(folder / "results.h5") as file:
        assert (file["status"][...] == 1).all()
