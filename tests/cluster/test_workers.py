"""Threads, processes, and what happens when they are stopped or killed."""

from __future__ import annotations

import os
import pickle
import shlex
import signal
import subprocess
import time
from collections.abc import Callable, Mapping
from pathlib import Path

import pytest

from tbi_cli.case import Case, load_case
from tbi_cli.runner import Options, run
from tbi_cli.store import open_results
from tbi_cli.workers import Workers
from tests.cli.commands import tbi
from tests.cluster.runs import CASE, ENDLESS, HISTORIES, SCENARIOS, SLOW, content, inside, parts, start

SECONDS = 300.0


def wait_until(true: Callable[[], object]) -> None:
    """Waits until something is true; fails after five minutes."""
    end = time.monotonic() + SECONDS
    while not true():
        assert time.monotonic() < end
        time.sleep(0.01)


def children(process: int) -> list[int]:
    """The worker processes of a process."""
    found = []
    for entry in Path("/proc").glob("[0-9]*/stat"):
        try:
            name, _, rest = entry.read_text().rpartition(")")
            command = entry.with_name("cmdline").read_bytes()
        except OSError:
            continue
        if int(rest.split()[1]) == process and b"popen_loky" in command:
            found.append(int(name.split()[0]))
    return found


def alive(process: int) -> bool:
    """Whether a process runs, and is not merely waiting for its parent to take note of its end."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] not in "ZX"
    except OSError:
        return False


@pytest.mark.parametrize(
    "workers",
    [Workers(jobs=1), Workers(jobs=2), Workers(jobs=4), Workers("processes", 2)],
    ids=lambda workers: f"{workers.jobs} {workers.backend}",
)
def test_the_same_bits(case: Case, whole: Mapping[str, bytes], tmp_path: Path, workers: Workers) -> None:
    path = tmp_path / "results.h5"
    assert run(case, Options(output=path, workers=workers)).solved == SCENARIOS
    assert content(path) == whole


def test_a_case_travels_whole(tmp_path: Path) -> None:
    """To another process and back, with its sweep."""
    (tmp_path / "case.yaml").write_text(CASE)
    case = load_case(tmp_path / "case.yaml")
    again = pickle.loads(pickle.dumps(case))
    assert again == case
    assert again.sha256 == case.sha256
    assert [axis.values for axis in again.axes] == [axis.values for axis in case.axes]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--backend", "fibres"], "--backend: expected one of threads, processes, dask; got 'fibres'"),
        (["--scheduler", "tcp://127.0.0.1:1"], "--scheduler: only --backend dask has a scheduler"),
        (["--backend", "dask"], "--backend dask: needs --scheduler ADDRESS, e.g. tcp://10.0.0.1:8786"),
        (
            ["--backend", "dask", "--scheduler", "tcp://127.0.0.1:1", "-j", "2"],
            "--jobs: the workers of a Dask cluster decide how many batches are solved at a time",
        ),
    ],
)
def test_options_that_do_not_go_together(folder: Path, arguments: list[str], message: str) -> None:
    ended = inside("run", "case.yaml", *arguments, folder=folder)
    assert (ended.code, ended.out, ended.err) == (2, "", f"{message}\n")
    assert [path.name for path in folder.iterdir()] == ["case.yaml"]


@pytest.mark.parametrize(
    ("backend", "number"),
    [
        ("threads", signal.SIGTERM),
        ("threads", signal.SIGUSR1),
        ("threads", signal.SIGINT),
        ("processes", signal.SIGINT),
    ],
)
def test_stopped_by_a_signal(folder: Path, backend: str, number: signal.Signals) -> None:
    """What is finished is kept; 75 says resume me, 130 interrupted."""
    arguments = ("run", "case.yaml", "-j", "2", "--backend", backend, *ENDLESS)
    process = start(*arguments, folder=folder)
    wait_until(lambda: len(parts(folder / "results.h5")) > 1)
    workers = children(process.pid)
    process.send_signal(number)
    out, err = process.communicate(timeout=SECONDS)
    assert process.returncode == (130 if number == signal.SIGINT else 75), err
    assert "Traceback" not in err
    with open_results(folder / "results.h5") as results:
        done = int((results.status == 1).sum())
    assert 0 < done < SCENARIOS
    advice = f"continue with: tbi {shlex.join([*arguments, '--resume'])}"
    assert out == f"stopped: {done} scenarios are done, {SCENARIOS - done} are left; {advice}\n"
    assert len(workers) == (2 if backend == "processes" else 0)
    assert not any(map(alive, workers))


def test_stopped_and_resumed(folder: Path) -> None:
    """The same tables and histories, to the bit, as in one go."""
    small = ("--set", "sweep.velocity=[20, 40, 60]", "-q", *SLOW, *HISTORIES)
    assert inside("run", "case.yaml", "-o", "whole.h5", *small, folder=folder).code == 0
    for stops in range(2):
        process = start("run", "case.yaml", "-o", "results.h5", "--resume", "-j", "1", *small, folder=folder)
        wait_until(lambda: len(parts(folder / "results.h5")) > stops)  # noqa: B023
        process.send_signal(signal.SIGUSR1)
        assert process.wait(SECONDS) == 75
    assert inside("run", "case.yaml", "-o", "results.h5", "--resume", *small, folder=folder).code == 0
    assert content(folder / "results.h5") == content(folder / "whole.h5")


def test_a_killed_worker_is_replaced(folder: Path, whole_slow: Mapping[str, bytes]) -> None:
    """Its batch is done again, and the run completes."""
    process = start("run", "case.yaml", "-j", "2", "--backend", "processes", *SLOW, folder=folder)
    wait_until(lambda: parts(folder / "results.h5"))
    victim = children(process.pid)[0]
    os.kill(victim, signal.SIGKILL)
    out, err = process.communicate(timeout=SECONDS)
    assert process.returncode == 0, err
    assert f"{SCENARIOS} scenarios solved" in out
    assert content(folder / "results.h5") == whole_slow


def test_workers_end_with_a_killed_parent(folder: Path) -> None:
    process = start("run", "case.yaml", "-j", "2", "--backend", "processes", *ENDLESS, folder=folder)
    wait_until(lambda: parts(folder / "results.h5"))
    workers = children(process.pid)
    process.kill()
    process.communicate()
    assert len(workers) == 2
    wait_until(lambda: not any(map(alive, workers)))


def test_a_second_process_is_refused_while_the_first_is_alive(folder: Path) -> None:
    process = start("run", "case.yaml", "-j", "1", *ENDLESS, folder=folder)
    wait_until(lambda: parts(folder / "results.h5"))
    for arguments in ([], ["--resume"], ["--overwrite"]):
        ended = inside("run", "case.yaml", *arguments, *ENDLESS, folder=folder)
        assert ended.code == 2
        assert f"results.h5: is being written by process {process.pid} on " in ended.err
    process.kill()
    process.communicate()
    done = len(parts(folder / "results.h5"))
    ended = inside("run", "case.yaml", *ENDLESS, folder=folder)
    assert ended.code == 2
    assert "holds an unfinished run" in ended.err
    assert len(parts(folder / "results.h5")) == done


def test_a_changed_case_is_not_resumed(folder: Path) -> None:
    """And the message says what has changed."""
    assert inside("run", "case.yaml", "-q", "--shard", "1/40", "-o", "results.h5", folder=folder).code == 0
    before = (folder / "results.h5").read_bytes()
    changed = ("--set", "bridge.length=40", "--shard", "1/40", "-o", "results.h5", "--resume")
    ended = inside("run", "case.yaml", *changed, folder=folder)
    assert ended.code == 2
    assert "holds another case (bridge.length: 50.0, now 40.0); choose another file with -o" in ended.err
    assert (folder / "results.h5").read_bytes() == before


def test_locks_of_hdf5_may_be_off_or_on(folder: Path, whole: Mapping[str, bytes]) -> None:
    """Some network file systems have none: tbi does not need them, whatever HDF5 is told."""
    for setting in ("FALSE", "TRUE"):
        ended = tbi("run", "case.yaml", "-q", "--overwrite", folder=folder, HDF5_USE_FILE_LOCKING=setting)
        assert (ended.code, ended.err) == (0, "")
        assert content(folder / "results.h5") == whole


def test_jobs_are_what_this_process_may_use(folder: Path) -> None:
    script = "from tbi_cli.resources import available_cpus; print(available_cpus())"
    first = sorted(os.sched_getaffinity(0))[0]

    def cpus(**environment: str) -> str:
        clean = {key: value for key, value in os.environ.items() if not key.startswith("SLURM_")}
        command = ["taskset", "-c", str(first), os.sys.executable, "-c", script]  # type: ignore[attr-defined]
        return subprocess.run(
            command, env=clean | environment, capture_output=True, text=True, check=True
        ).stdout.strip()

    assert cpus() == "1"
    assert cpus(SLURM_CPUS_PER_TASK="7") == "7"
