"""Killed at any instant: what was there stays readable, and a resumed run ends with the same bits."""

from __future__ import annotations

import multiprocessing
import os
import random
import signal
import time
from pathlib import Path

import h5py
import pytest

from tbi_cli.store import ResultsStore, open_results
from tests.store.example import batch, batches, content, layout, solve

OF = layout(shape=(4, 6), channels=5, histories=5)


def check_readable(path: Path) -> int:
    """Reads everything that is there in its final name; returns how many cases are done."""
    for file in path.parent.rglob("*.h5"):
        with h5py.File(file, "r") as h5:
            h5.visititems(lambda _, item: item[...] if isinstance(item, h5py.Dataset) else None)
    parts = path.with_name(path.name + ".parts")
    if not path.exists() and not (parts / "layout.json").exists():
        return 0
    with open_results(path) as results:
        for index in results.history_indices():
            results.history(index)
        return int((results.status == 1).sum())


@pytest.mark.parametrize("seed", range(4))
def test_kill_and_resume(tmp_path: Path, seed: int) -> None:
    """With ``seed`` batches of the same run in a results file already, which the resumed run completes."""
    whole, path = tmp_path / "whole.h5", tmp_path / "results.h5"
    solve(whole, OF)
    if seed:
        with ResultsStore(path, OF) as store:
            for indices in batches(OF)[:seed]:
                store.write(batch(OF, indices))
            store.finish()
    moments = random.Random(seed)
    fork = multiprocessing.get_context("fork")
    done = kills = 0
    while done < OF.size or not path.exists() or kills < 10:
        process = fork.Process(target=solve, args=(path, OF))
        process.start()
        time.sleep(moments.uniform(0, 0.01 + 0.004 * kills))  # all of it takes about 0.1 s
        process.kill()
        process.join()
        before, done, kills = done, check_readable(path), kills + 1
        assert done >= before
        assert kills < 1000
    assert content(path) == content(whole)
    solve(path, OF)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["results.h5", "whole.h5"]


def interruptible(path: Path) -> None:
    """A run that ends with code 130 when interrupted, as the program does."""
    try:
        solve(path, OF)
    except KeyboardInterrupt:
        os._exit(130)


def test_interrupted_anywhere(tmp_path: Path) -> None:
    """Ctrl-C waits until HDF5 has nothing half done in its hands; nothing unfinished is left behind."""
    whole = tmp_path / "whole.h5"
    solve(whole, OF)
    moments = random.Random(0)
    fork = multiprocessing.get_context("fork")
    for number in range(25):
        path = tmp_path / f"{number}" / "results.h5"
        path.parent.mkdir()
        process = fork.Process(target=interruptible, args=(path,))
        process.start()
        while not path.with_name("results.h5.parts").exists() and process.is_alive():
            time.sleep(0.001)
        time.sleep(moments.uniform(0, 0.15))
        os.kill(process.pid or 0, signal.SIGINT)
        process.join()
        assert process.exitcode in (0, 130)
        assert not list(path.parent.rglob("*.unfinished"))
        assert check_readable(path) == OF.size or process.exitcode == 130
    solve(path, OF)
    assert content(path) == content(whole)
