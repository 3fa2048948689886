"""One process at a time."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tbi_cli.store import ResultsStore, StoreError, check_output
from tests.store.example import batch, layout

HOLD = """
import sys, time
from tests.store.example import batch, layout
from tbi_cli.store import ResultsStore
store = ResultsStore(sys.argv[1], layout())
store.write(batch(layout(), range(4)))
print("held", flush=True)
time.sleep(600)
"""


@pytest.fixture
def holder(tmp_path: Path) -> subprocess.Popen[str]:
    """Another process that writes results.h5 and has finished four cases."""
    process = subprocess.Popen(
        [sys.executable, "-c", HOLD, str(tmp_path / "results.h5")], stdout=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "held\n"
    yield process  # type: ignore[misc]
    process.kill()
    process.wait()


@pytest.mark.parametrize("options", [{}, {"resume": True}, {"overwrite": True}])
def test_refused_while_the_other_is_alive(
    tmp_path: Path, holder: subprocess.Popen[str], options: dict[str, bool]
) -> None:
    path = tmp_path / "results.h5"
    before = sorted(p.name for p in tmp_path.rglob("*"))
    for act in (ResultsStore, lambda p, _, **o: check_output(p, **o)):
        with pytest.raises(StoreError) as caught:
            act(path, layout(), **options)
        assert str(caught.value).startswith(f"{path}: is being written by process {holder.pid} on ")
    assert sorted(p.name for p in tmp_path.rglob("*")) == before


@pytest.mark.parametrize("reaped", [True, False])
def test_a_dead_ones_lock_is_recognised(tmp_path: Path, holder: subprocess.Popen[str], reaped: bool) -> None:
    """Whether or not its parent has waited for it."""
    holder.send_signal(signal.SIGKILL)
    if reaped:
        holder.wait()
    else:
        os.waitid(os.P_PID, holder.pid, os.WEXITED | os.WNOWAIT)
    with ResultsStore(tmp_path / "results.h5", layout(), resume=True) as store:
        assert store.done().sum() == 4


def lock(tmp_path: Path, **changes: object) -> Path:
    """A lock as this very process would hold it, but for some changes, and nothing else."""
    path = tmp_path / "results.h5"
    with ResultsStore(path, layout()):
        text = (tmp_path / "results.h5.parts" / "lock").read_text()
    folder = tmp_path / "results.h5.parts"
    folder.mkdir()
    (folder / "lock").write_text(json.dumps({**json.loads(text), **changes}))
    return path


def test_the_same_process_twice(tmp_path: Path) -> None:
    with ResultsStore(tmp_path / "results.h5", layout()) as store:
        with pytest.raises(StoreError, match=f"is being written by process {os.getpid()}"):
            ResultsStore(tmp_path / "results.h5", layout())
        store.write(batch(layout(), range(4)))


@pytest.mark.parametrize(
    "changes",
    [{"pid": 2**22 + 1}, {"start": "1"}, {"boot": "an earlier one"}],
    ids=["no such process", "its number was given to another", "the machine was restarted"],
)
def test_dead(tmp_path: Path, changes: dict[str, object]) -> None:
    with ResultsStore(lock(tmp_path, **changes), layout()) as store:
        store.write(batch(layout(), range(4)))


@pytest.mark.parametrize(
    "changes",
    [
        {"host": "node17"},
        {"host": "node17", "pid": 2**22 + 1},
        {"host": "node17", "boot": "of that machine", "pid": 2**22 + 1, "start": "1"},
        {"namespace": "pid:[1]"},
        {"namespace": "pid:[1]", "pid": 2**22 + 1},
    ],
    ids=["host", "no such process here", "another boot too", "namespace", "no such process in this one"],
)
def test_another_machines_lock_is_honoured_with_its_age(tmp_path: Path, changes: dict[str, object]) -> None:
    """That no process here has the number says nothing of one elsewhere."""
    path = lock(tmp_path, **changes)
    file = tmp_path / "results.h5.parts" / "lock"
    os.utime(file, (time.time() - 7300, time.time() - 7300))
    with pytest.raises(StoreError) as caught:
        ResultsStore(path, layout())
    assert f"last heard of 2 hours ago; if that run is dead, delete {file}" in str(caught.value)
    file.unlink()
    ResultsStore(path, layout()).close()


@pytest.mark.parametrize(
    ("job", "restart", "gone"), [("17", "1", True), ("17", "0", False), ("18", "1", False)]
)
def test_an_earlier_start_of_the_same_slurm_job_is_gone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, job: str, restart: str, gone: bool
) -> None:
    """The node died, and Slurm queued the job again: nobody else would take that node's lock away."""
    path = lock(tmp_path, host="node17", job="cluster:17", restart="0")
    monkeypatch.setenv("SLURM_CLUSTER_NAME", "cluster")
    monkeypatch.setenv("SLURM_JOB_ID", job)
    monkeypatch.setenv("SLURM_RESTART_COUNT", restart)
    if gone:
        ResultsStore(path, layout()).close()
    else:
        with pytest.raises(StoreError, match=r"is being written by process \d+ on node17"):
            ResultsStore(path, layout())


@pytest.mark.parametrize("text", ["", "{", "[]", "null", '{"host": 1}', "\x00\xff", "[" * 100_000])
def test_a_lock_that_says_nothing_is_no_lock(tmp_path: Path, text: str) -> None:
    path = lock(tmp_path)
    (tmp_path / "results.h5.parts" / "lock").write_text(text)
    ResultsStore(path, layout()).close()


def test_a_lock_that_was_taken_over_is_noticed(tmp_path: Path) -> None:
    with ResultsStore(tmp_path / "results.h5", layout()) as store:
        (tmp_path / "results.h5.parts" / "lock").write_text("{}")
        with pytest.raises(StoreError, match="was removed or taken over"):
            store.write(batch(layout(), range(4)))
    # It is the other's to give up.
    assert (tmp_path / "results.h5.parts" / "lock").read_text() == "{}"


def test_of_many_that_start_at_once_one_gets_it(tmp_path: Path) -> None:
    """All find a dead one's lock."""
    path = lock(tmp_path, pid=2**22 + 1)
    script = """
import sys, time
from tests.store.example import layout
from tbi_cli.store import ResultsStore, StoreError
sys.stdin.read(1)
try:
    store = ResultsStore(sys.argv[1], layout())
    print("got it", flush=True)
    sys.stdin.read(1)
except StoreError:
    print("refused", flush=True)
"""
    command = [sys.executable, "-c", script, str(path)]
    pipe = subprocess.PIPE
    started = [subprocess.Popen(command, stdin=pipe, stdout=pipe, text=True) for _ in range(6)]
    try:
        for process in started:
            assert process.stdin is not None
            process.stdin.write("x")
            process.stdin.flush()
        answers = [process.stdout.readline() for process in started if process.stdout is not None]
    finally:
        for process in started:
            process.communicate()
    assert sorted(answers) == ["got it\n"] + ["refused\n"] * 5
