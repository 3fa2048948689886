"""SIGKILL at random moments."""

from __future__ import annotations

import contextlib
import random
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

import h5py
import numpy as np
from soaking.common import HISTORIES, Soak

from tbi_cli.store import DONE, open_parts, open_results
from tests.cluster.runs import content, parts


def kills(soak: Soak) -> None:
    """SIGKILL at random moments of a sweep with histories, resumed each time."""
    wanted = 3 if soak.short else 100
    moments = random.Random(1)
    fine = ("--set", "solver.sampling=0.001" if soak.short else "solver.sampling=0.00005", *HISTORIES, "-q")
    steps = ("--set", "solver.substeps=1")
    results, log = soak.folder / "killed.h5", soak.folder / "killed.log"
    begin = time.monotonic()
    soak.tbi("run", "case.yaml", "-o", "whole.h5", *fine, *steps)
    longest = time.monotonic() - begin
    whole = content(soak.folder / "whole.h5")
    print(f"kills: {wanted} SIGKILLs of a sweep that takes {longest:.0f} s, {len(whole)} datasets to compare")

    killed = completed = twice = most = looks = 0
    torn: list[str] = []
    while killed < wanted or completed == 0:
        results.unlink(missing_ok=True)
        shutil.rmtree(results.with_name("killed.h5.parts"), ignore_errors=True)
        if completed % 2:  # an older file, which the new run replaces at its end
            soak.tbi("run", "case.yaml", "-o", "killed.h5", "--shard", "1/20", "-q")
        first = True
        while True:
            jobs = moments.choice((1, 2, 4))
            how = ("--overwrite" if first and completed % 2 else "--resume", "-j", str(jobs))
            log.unlink(missing_ok=True)
            noting = [sys.executable, str(Path(sys.argv[0]).resolve()), "--child", str(log)]
            process = subprocess.Popen(
                [*noting, "run", "case.yaml", "-o", "killed.h5", *how, *fine, *steps],
                cwd=soak.folder,
                stderr=subprocess.PIPE,
            )
            with watching(results, torn) as count:
                alive = killed >= wanted
                try:
                    _, err = process.communicate(
                        timeout=None if alive else moments.uniform(0, 1.2 * patience(longest))
                    )
                except subprocess.TimeoutExpired:
                    process.kill()
                    _, err = process.communicate()
            looks += count[0]
            first = first and not parts(results)
            if process.returncode == 0:
                break
            if process.returncode != -signal.SIGKILL:
                soak.holds(f"the run ended with {process.returncode}: {err.decode()}", False)
                return
            killed += 1
            lost = batches_lost(results, log)
            twice, most = twice + lost, max(most, lost - jobs)
        completed += 1
        if content(results) != whole:
            soak.holds("the same bits after resuming", False)
    soak.holds(f"{killed} kills, {completed} runs completed: tables and histories bit for bit the same", True)
    soak.holds(f"{looks} looks at the files meanwhile, {len(torn)} of them torn {torn[:3]}", not torn)
    soak.holds(f"{twice} batches done twice in all, at most one per job at each kill", most <= 0)


def patience(longest: float) -> float:
    """How long a run may go on before it is killed: long enough to get somewhere, not to its end."""
    return max(2.5, longest / 4)


def child(log: str, arguments: Sequence[str]) -> int:
    """A tbi process that notes each batch when it is begun."""
    from tbi_cli.__main__ import main
    from tbi_cli.solve import Solver

    solve = Solver.solve

    def noted(self: Solver, indices: np.ndarray) -> object:
        with Path(log).open("a") as file:
            file.write(" ".join(map(str, indices)) + "\n")
        return solve(self, indices)

    Solver.solve = noted  # type: ignore[assignment,method-assign]
    sys.argv[1:] = arguments
    main()
    return 0


def batches_lost(results: Path, log: Path) -> int:
    """Batches that a killed process had begun and that are not on disk."""
    begun = [line.split() for line in log.read_text().splitlines()] if log.exists() else []
    if not begun:
        return 0
    done = status_of(results)
    return sum(1 for batch in begun if done is None or not all(done[int(index)] for index in batch if index))


def status_of(results: Path) -> np.ndarray | None:
    """Which scenarios are on disk, newest run first; None if nothing is."""
    opened = open_parts(results) or (open_results(results) if results.exists() else None)
    if opened is None:
        return None
    with opened:
        return opened.status.ravel() == DONE


@contextlib.contextmanager
def watching(results: Path, torn: list[str]) -> Iterator[list[int]]:
    """Reads whatever has its final name, again and again, while a run goes on."""
    stop, count = threading.Event(), [0]

    def look() -> None:
        while not stop.is_set():
            for path in [results, *parts(results)]:
                try:
                    with h5py.File(path, "r") as file:
                        file.visititems(lambda _, item: item[...] if isinstance(item, h5py.Dataset) else None)
                    count[0] += 1
                except FileNotFoundError:
                    continue
                except (OSError, KeyError, RuntimeError) as error:
                    if path.exists():
                        torn.append(f"{path.name}: {error}")
            time.sleep(0.05)

    thread = threading.Thread(target=look)
    thread.start()
    try:
        yield count
    finally:
        stop.set()
        thread.join()
