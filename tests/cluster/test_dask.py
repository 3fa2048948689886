"""A Dask cluster of a scheduler and two workers, each a process of its own on the loopback interface."""

from __future__ import annotations

import shlex
import subprocess
import time
from collections.abc import Iterator, Mapping
from pathlib import Path

import pytest

from tests.cluster.dask_here import DaskHere
from tests.cluster.runs import ENDLESS, SCENARIOS, SLOW, content, inside, parts, start

pytest.importorskip("distributed", reason="Dask is not installed (tbi-cli[dask])")
SECONDS = 60.0


@pytest.fixture
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[DaskHere]:
    """A running cluster."""
    running = DaskHere(tmp_path_factory.mktemp("dask"))
    yield running
    running.stop()


def wait_for_parts(results: Path, process: subprocess.Popen[str], count: int) -> None:
    """Waits for that many finished batches of a run that goes on."""
    end = time.monotonic() + SECONDS
    while len(parts(results)) < count:
        assert process.poll() is None
        assert time.monotonic() < end
        time.sleep(0.01)


def test_a_worker_is_killed_half_way(
    folder: Path, cluster: DaskHere, whole_slow: Mapping[str, bytes]
) -> None:
    """The run completes, with the same bits; then a stop, and a lost scheduler, and nothing is lost."""
    dask = ("--backend", "dask", "--scheduler", cluster.address)
    process = start("run", "case.yaml", "-o", "killed.h5", *dask, *SLOW, folder=folder)
    wait_for_parts(folder / "killed.h5", process, 4)
    cluster.workers[0].kill()
    out, err = process.communicate(timeout=SECONDS)
    assert process.returncode == 0, err
    assert f"{SCENARIOS} scenarios solved" in out
    assert content(folder / "killed.h5") == whole_slow

    process = start("run", "case.yaml", "-o", "stopped.h5", *dask, *ENDLESS, folder=folder)
    wait_for_parts(folder / "stopped.h5", process, 1)
    process.terminate()
    out, err = process.communicate(timeout=SECONDS)
    assert process.returncode == 75, err
    assert out.startswith("stopped: ")

    process = start("run", "case.yaml", "-o", "stopped.h5", "--resume", *dask, *ENDLESS, folder=folder)
    wait_for_parts(folder / "stopped.h5", process, len(parts(folder / "stopped.h5")) + 1)
    cluster.scheduler.kill()
    out, err = process.communicate(timeout=SECONDS)
    assert process.returncode == 1, err
    lost = f"the Dask scheduler at {cluster.address} was lost; what was finished is safe; continue with: tbi "
    lost += shlex.join(["run", "case.yaml", "-o", "stopped.h5", *dask, *ENDLESS, "--resume"])
    assert err.splitlines()[-1] == lost
    assert "Traceback" not in err


@pytest.mark.parametrize("address", ["nowhere", "carrier-pigeon://x:1", "tcp://x", ""])
def test_not_an_address(folder: Path, address: str) -> None:
    ended = inside("run", "case.yaml", "--backend", "dask", "--scheduler", address, folder=folder)
    expected = f"--scheduler: expected an address such as tcp://10.0.0.1:8786, got {address!r}\n"
    assert (ended.code, ended.out, ended.err) == (2, "", expected)
    assert [path.name for path in folder.iterdir()] == ["case.yaml"]
