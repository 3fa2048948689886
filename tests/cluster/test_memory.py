"""How much memory a run takes is bounded: its tables, a batch's histories, and all histories under way."""

from __future__ import annotations

import threading
import time
from pathlib import Path

import h5py
import numpy as np
import pytest
from numpy.typing import NDArray

from tbi_cli.case import RunError, load_case
from tbi_cli.runner import Options, plan_of, run
from tbi_cli.solve import Solver
from tbi_cli.store.records import BatchResult
from tbi_cli.workers import Workers, solve_batches

HISTORIES = "output.histories={channels: [car_body_y, left_midspan, wheel_2_left_force], every: 0.01}"
GRID = "sweep={velocity: {from: 60, to: 83, step: 1}, bridge.modes: [2, 3]}"


def test_tables_take_half_of_the_free_memory_at_most(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What is needed is told by a file of the same grid: its tables of doubles."""
    case = load_case("paper", overrides=[GRID, "solver.duration=0.2"])
    path = run(case, Options(output=tmp_path / "r.h5")).path
    sizes: list[int] = []
    with h5py.File(path) as file:
        file.visititems(
            lambda _, item: (
                sizes.append(item.nbytes) if getattr(item, "ndim", 0) == 2 and item.dtype == "f8" else None
            )
        )
    needed = sum(sizes)
    assert len(sizes) > 100
    # A few numbers a scenario come on top: status, message, steps and seconds, 4 of some 500.
    monkeypatch.setattr("tbi_cli.runner.available_memory", lambda: int(2 * needed * 0.999))
    with pytest.raises(
        RunError, match="sweep: expected a grid whose tables fit into half of the free memory"
    ):
        run(case, Options(output=tmp_path / "large.h5"))
    assert not (tmp_path / "large.h5").exists() and not (tmp_path / "large.h5.parts").exists()
    monkeypatch.setattr("tbi_cli.runner.available_memory", lambda: int(2 * needed * 1.02))
    run(case, Options(output=tmp_path / "large.h5"))


def test_a_batch_holds_no_more_histories_than_it_should(monkeypatch: pytest.MonkeyPatch) -> None:
    """The bytes of the histories as they are solved, against those that the plan counts with."""
    most = 9_000
    monkeypatch.setattr("tbi_cli.plan._HISTORY_BYTES", most)
    solver = Solver(load_case("paper", overrides=[GRID, "solver.duration=0.4", HISTORIES]))
    plan = plan_of(solver, np.ones(len(solver.scenarios), dtype=bool))
    assert sorted(int(i) for batch in plan.batches for i in batch) == list(range(len(solver.scenarios)))
    held = []
    for batch in plan.batches:
        result = solver.solve(batch.tolist())
        assert result is not None
        held.append(sum(h.time.nbytes + h.values.nbytes for h in result.histories.values()))
        assert held[-1] == plan.sizes[batch].sum()
    assert 0.7 * most < max(held) <= most


class Counted:
    """A solver that notes how many bytes are under way: asked for, and not taken yet."""

    def __init__(self, solver: Solver, sizes: NDArray[np.int64]) -> None:
        self._solver, self._sizes = solver, sizes
        self._lock = threading.Lock()
        self.now = self.most = 0

    def solve(self, batch: NDArray[np.int64]) -> BatchResult | None:
        with self._lock:
            self.now += int(self._sizes[batch].sum())
            self.most = max(self.most, self.now)
        time.sleep(0.02)  # so that others would begin, if they might
        return self._solver.solve(batch.tolist())

    def taken(self, result: BatchResult) -> None:
        with self._lock:
            self.now -= int(self._sizes[result.indices].sum())


@pytest.mark.parametrize("room", [1, 3, 6])
def test_histories_under_way_take_a_quarter_of_the_free_memory_at_most(
    monkeypatch: pytest.MonkeyPatch, room: int
) -> None:
    """Eight threads, and room for so many batches: no more at a time, and no fewer."""
    solver = Solver(
        load_case("paper", overrides=["sweep={velocity: {from: 60, to: 75, step: 1}}", HISTORIES])
    )
    batches = [np.array([i]) for i in range(16)]
    sizes = np.full(16, 1000)
    monkeypatch.setattr("tbi_cli.workers.available_memory", lambda: 4000 * room + 3999)
    counted = Counted(solver, sizes)
    found = []
    for result in solve_batches(counted, batches, sizes, Workers(jobs=8), threading.Event()):  # type: ignore[arg-type]
        counted.taken(result)
        found += result.indices.tolist()
    assert sorted(found) == list(range(16))
    assert counted.most == 1000 * room
