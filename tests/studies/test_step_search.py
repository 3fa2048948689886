"""The search of speeds in one step, on curves of which the answer is known."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from tbi_cli.case import load_case
from tbi_cli.case.refinement import Refinement
from tbi_cli.refine import Refiner
from tbi_cli.shards import Shard
from tbi_cli.solve import Solver
from tbi_cli.step_search import StepSearch
from tests.studies.test_refinement import CASE


@pytest.mark.parametrize("seed", range(5))
def test_a_straight_line_needs_no_speeds_besides(seed: int) -> None:
    """However uneven the places of resonance are at which it is known, and the speeds themselves."""
    random = np.random.default_rng(seed)
    refinement = Refinement(128, 1e-3, None)
    speeds = 40.0 + np.cumsum(random.uniform(0.01, 0.2, 3 * refinement.per_step + 1))
    resonant = np.sort(random.choice(np.arange(1, len(speeds) - 1), 9, replace=False))
    slope, level = random.uniform(-1, 1, (2, 3)), random.uniform(100, 200, (2, 3))
    search = StepSearch(1, speeds, refinement, resonant)
    peaks = {place: level + slope * float(speeds[place]) for place in search.places}
    assert len(search.places) > 9
    assert search.more(peaks) == []
    assert search.unsettled == {}


@pytest.mark.parametrize("seed", range(24))
def test_the_top_of_a_resonance_is_met_to_the_tolerance(seed: int) -> None:
    """1/(1 + (v - v0)^2/w^2) on a slope, v0 anywhere in the step, known at first about a width beside it."""
    random = np.random.default_rng(seed)
    tolerance = 0.01
    speeds = 40.0 + 4.0 / 2048 * np.arange(3 * 2048 + 1)
    top, width = random.uniform(44.3, 47.7), np.exp(random.uniform(*np.log((0.01, 0.4))))
    line = 1 / (1 + ((speeds - top) / width) ** 2) + 0.02 * random.uniform(-1, 1) * (speeds - top)
    beside = [round((top + k * width * random.uniform(0.7, 1.3) - 40.0) / 4.0 * 2048) for k in (-1, 1)]
    if seed % 2:  # or two neighbours on one side of it, with nothing known on the other
        beside = [beside[seed // 2 % 2] + k for k in (0, 1)]
    search = StepSearch(1, speeds, Refinement(2048, tolerance, None), np.array(beside))
    while search.more({place: np.full((1, 1), line[place]) for place in search.places}):
        pass
    assert max(line[place] for place in search.places) >= (1 - tolerance) * line[2048:4097].max()
    assert len(search.places) < 150


def asked(solver: Solver, shard: Shard | None, line: NDArray[np.float64]) -> set[int]:
    """The scenarios that a run keeps, or a shard of it, where these are the peaks at all speeds."""
    refiner = Refiner(solver, shard)
    found: set[int] = set()
    wanted = refiner.first()
    while wanted.any():
        indices = np.flatnonzero(wanted)
        found |= set(np.flatnonzero(wanted & refiner.own).tolist())
        refiner.learn_peaks(indices, np.tile(line[indices, None], len(refiner.columns)))
        wanted = refiner.more()
    return found


def test_shards_ask_for_what_the_whole_asks_for(tmp_path: Path) -> None:
    """Peaks beside the ends of steps: what one step asks for may lie in the next, or in the one before."""
    (tmp_path / "case.yaml").write_text(CASE.replace("tolerance: 1 %", "tolerance: 0.5 %"))
    solver = Solver(load_case(tmp_path / "case.yaml"))
    speeds = np.array(solver.scenarios.axes[0].values)
    random = np.random.default_rng(2)
    for of in (3, 5, 8, 20, 20, 20):
        line = 0.01 * np.cos(speeds / 9)
        for end in np.arange(44.0, 120.0, 4.0):
            top, width = end + random.uniform(-0.4, 0.4), random.uniform(0.02, 0.3)
            line = line + random.uniform(0.2, 1) / (1 + ((speeds - top) / width) ** 2)
        whole = asked(solver, None, line)
        parts = [asked(solver, Shard(number, of), line) for number in range(1, of + 1)]
        assert sum(map(len, parts)) == len(set().union(*parts))
        assert set().union(*parts) == whole
