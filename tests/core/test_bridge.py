"""The beams: Eqs. (14)-(16), damping, static deflections, amplification factors."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tbi_cli.case import Case
from tbi_cli.scenarios import make_model
from tbi_cli.solve import Solver
from tbi_cli.system.bridge import beam_modes, critical_velocities, modal_damping, natural_frequencies
from tests.core.crossings import paper
from tests.core.random_cases import crossing, read


def frequencies(case: Case, side: str) -> np.ndarray:
    return natural_frequencies(case.bridge, getattr(case.bridge, side)) / (2 * np.pi)


def test_table_2() -> None:
    """Frequencies and critical velocities of both beams; 299.745 is a misprint for 299.725 (model.md)."""
    case = paper()
    assert frequencies(case, "right")[3] == pytest.approx(14.464, abs=5e-4)
    assert frequencies(case, "left")[3] == pytest.approx(14.986, abs=5e-4)
    right, left = (
        critical_velocities(case.bridge, b, 20.0)[3] for b in (case.bridge.right, case.bridge.left)
    )
    assert right == pytest.approx(289.277, abs=5e-3)
    assert left == pytest.approx(299.725, abs=5e-3)


@pytest.mark.parametrize(
    ("length", "velocities"),
    [
        (30, [52.03, 208.14, 468.32, 832.57]),
        (40, [29.27, 117.08, 263.43, 468.32]),
        (50, [18.73, 74.93, 168.59, 299.72]),
        (60, [13.01, 52.03, 117.08, 208.14]),
    ],
)
def test_table_5(length: float, velocities: list[float]) -> None:
    """Critical velocities of the left beam by span, to the digits printed."""
    case = paper(f"bridge.length={length}")
    assert case.bridge.left is not None
    assert critical_velocities(case.bridge, case.bridge.left, 20.0) == pytest.approx(velocities, abs=6e-3)


def test_three_ways_of_giving_damping() -> None:
    """c, the ratio of the first mode, one ratio for all modes: what each makes of c/mu."""
    mu = 20e3
    omega = 2 * np.pi * frequencies(paper(), "right")
    c, first, every = (
        modal_damping(case.bridge, case.bridge.right)
        for case in (
            paper(f"bridge.right.damping={d}") for d in ("1e4", "{first_mode_ratio: 2 %}", "{ratio: 2 %}")
        )
    )
    assert c == pytest.approx(np.full(4, 1e4 / mu))
    assert first == pytest.approx(np.full(4, 2 * 0.02 * omega[0]))
    assert every == pytest.approx(2 * 0.02 * omega)


def test_ratios_of_the_paper_s_dampings() -> None:
    """0.47, 2.36, 4.72 % follow for the left beam from 1, 5, 10 kN s/m2 (section 3.6)."""
    ratios = []
    for c in (1e3, 5e3, 10e3):
        bridge = paper(f"bridge.left.damping={c}").bridge
        assert bridge.left is not None
        gamma, omega = modal_damping(bridge, bridge.left)[0], natural_frequencies(bridge, bridge.left)[0]
        ratios.append(100 * gamma / (2 * omega))
    assert ratios == pytest.approx([0.47, 2.36, 4.72], abs=6e-3)


def test_crawling_deflection_of_one_force_is_the_static_one() -> None:
    """One force at mid-span: sum over odd modes of 2FL^3/(pi^4 EI i^4), short of FL^3/48EI by its tail."""
    beam = beam_modes(paper("bridge.modes=20").bridge, paper().bridge.right)
    crawling = beam.crawling_deflection(np.array([1e5]), np.array([0.0]))
    # The tail sum_{i=21,23,..} 1/i^4 is below the integral from 20 in steps of 2, 1/(6 20^3) = 2.1e-5.
    static = beam.static_deflection(1e5)
    assert 0 < 1 - crawling / static < 2.1e-5 * 96 / np.pi**4


def test_crawling_deflection_of_a_train_longer_than_the_span() -> None:
    """Unequal axles of which the heaviest come last, long after the first has left the bridge.

    Against the closed influence line of the span, P a (3 L^2 - 4 a^2)/48EI with a to the nearer support, on a
    grid of 1 mm.  The series of 20 modes is short of it by 2.1e-5 of one force at mid-span (above); the grid
    misses the kink of the line, where its slope is zero on the average, by less than 1e-6.
    """
    random = np.random.default_rng(5)
    beam = beam_modes(paper("bridge.modes=20", "bridge.length=18.3").bridge, paper().bridge.right)
    offsets = np.cumsum(np.append(0.0, random.uniform(1.8, 9.0, 15)))
    loads = np.append(random.uniform(4e4, 9e4, 12), random.uniform(16e4, 22e4, 4))
    length, stiffness = 18.3, 207e9 * 0.2
    assert offsets[-1] > 3 * length
    beam = replace(beam, length=length, omega=(np.arange(1, 21) * np.pi / length) ** 2 * np.sqrt(2.07e6))
    x = np.arange(0.0, length + offsets[-1], 1e-3)[:, None] - offsets
    near = np.clip(np.minimum(x, length - x), 0.0, None)
    line = near * (3 * length**2 - 4 * near**2) / (48 * stiffness)
    expected = float(np.max(line @ loads))
    assert np.max((line @ loads)[x[:, 0] <= length]) < 0.6 * expected
    assert beam.crawling_deflection(loads, offsets) == pytest.approx(expected, rel=1e-4)


@pytest.mark.parametrize("seed", [41, 42])
def test_slow_trains_have_an_amplification_of_one(seed: int) -> None:
    """At 0.2 m/s, where dynamic parts are of the order of v over 2 f1 L = 80 to 160 m/s: 0.25 %, twice."""
    solver = {"sampling": 0.01, "substeps": "auto", "duration": 1.0}
    case = crossing(seed, raster=1e-3, velocity=0.2, solver=solver, output={"histories": "none"})
    result = Solver(read(case)).solve([0])
    assert result is not None
    assert result.daf["right_static"][0] == pytest.approx(1, abs=5e-3)
    assert result.daf["left_static"][0] == pytest.approx(1, abs=5e-3)


def test_the_paper_s_amplification_counts_the_whole_train() -> None:
    """R_s = F L^3/48EI with F the numerator of Eq. (13a) under static_load paper (section 3.6)."""
    case = paper()
    model, result = make_model(case), Solver(case).solve([0])
    assert result is not None
    names = [channel.name for channel in Solver(case).tables]
    weight = (40000 + 2 * 2280 + 8 * 1901.8) * 9.81
    static = weight * 50**3 / (48 * 207e9 * 0.2)
    peak = result.tables["peak"][0][names.index("right_midspan")]
    assert result.daf["right"][0] == pytest.approx(peak / static, rel=1e-12)
    assert result.daf["right_static"][0] == pytest.approx(peak / model.crawling[0], rel=1e-12)
