"""The search of speeds in one step, on curves of which the answer is known."""

from __future__ import annotations

import numpy as np
import pytest

from tbi_cli.case.refinement import Refinement
from tbi_cli.step_search import StepSearch


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
    """1/(1 + (v - v0)^2/w^2) on a slope, v0 anywhere in the step, known at first a width to either side."""
    random = np.random.default_rng(seed)
    tolerance = 0.01
    speeds = 40.0 + 4.0 / 2048 * np.arange(3 * 2048 + 1)
    top, width = random.uniform(44.3, 47.7), random.uniform(0.05, 0.4)
    line = 1 / (1 + ((speeds - top) / width) ** 2) + 0.02 * random.uniform(-1, 1) * (speeds - top)
    beside = [round((top + k * width * random.uniform(0.7, 1.3) - 40.0) / 4.0 * 2048) for k in (-1, 1)]
    search = StepSearch(1, speeds, Refinement(2048, tolerance, None), np.array(beside))
    while search.more({place: np.full((1, 1), line[place]) for place in search.places}):
        pass
    assert max(line[place] for place in search.places) >= (1 - tolerance) * line[2048:4097].max()
    assert len(search.places) < 150
