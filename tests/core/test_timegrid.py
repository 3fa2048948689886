"""Sampling, substeps, stability (model.md, Integration)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tbi_cli.batch import build_batch
from tbi_cli.integrator.integrate import integrate
from tbi_cli.plan import make_plan
from tbi_cli.scenarios import make_model
from tbi_cli.solve import Solver
from tbi_cli.timegrid import TimeGrid, TimeGridError, TooManyStepsError, UnstableStepError, time_grid
from tests.core.crossings import histories, paper, tables


def grid_of(*overrides: str) -> TimeGrid:
    case = paper(*overrides)
    return time_grid(case, make_model(case).pace)


def test_the_paper_s_window() -> None:
    """Five times 0.84 s at 1 ms: samples 0 .. 4200."""
    assert grid_of() == TimeGrid(sampling=1e-3, substeps=1, last=4200)


@pytest.mark.parametrize(
    ("overrides", "sampling"),
    [
        (("velocity=10",), 1e-3),
        (("velocity=100",), 0.7 / 4000),
        (
            ("velocity=10", "bridge.modes=20"),
            2 * np.pi / ((20 * np.pi / 50) ** 2 * np.sqrt(4e10 / 18e3)) / 60,
        ),
    ],
)
def test_auto_sampling_is_the_smallest_of_three(overrides: tuple[str, ...], sampling: float) -> None:
    """1 ms, 1/4000 of the time that the train is on the bridge, 1/60 of the shortest modal period."""
    assert grid_of("solver.sampling=auto", *overrides).sampling == pytest.approx(sampling, rel=1e-12)


@pytest.mark.parametrize("substeps", [1, 3, 8])
def test_a_step_at_the_limit_of_stability(substeps: int) -> None:
    """Just below the limit that the message names a crossing stays bounded; just above it is refused."""
    with pytest.raises(UnstableStepError) as refused:
        grid_of("solver.sampling=0.5", f"solver.substeps={substeps}")
    limit = float(str(refused.value).split("at most ")[1].split(" s")[0])
    with pytest.raises(UnstableStepError):
        grid_of(f"solver.sampling={1.02 * limit * substeps}", f"solver.substeps={substeps}")
    stable = f"solver.sampling={0.98 * limit * substeps}"
    peak = tables(paper(stable, f"solver.substeps={substeps}", "solver.duration=60"))["peak"]
    assert np.isfinite(peak["right_midspan"][0])
    assert peak["right_midspan"][0] < 0.2


def test_what_lies_above_the_limit_grows() -> None:
    """The refusal is not idle: at 1.1 times the limit the integrator itself overflows."""
    crosser = Solver(paper()).scenarios.crosser(0)
    with pytest.raises(UnstableStepError) as refused:
        grid_of("solver.sampling=0.5")
    limit = float(str(refused.value).split("at most ")[1].split(" s")[0])
    wild = replace(crosser, grid=TimeGrid(sampling=1.1 * limit, substeps=1, last=20_000))
    batch = build_batch([wild], range(5), ())
    result = integrate(batch.topology, batch.crossing, batch.last, 1)
    assert not np.isnan(result.failed_at[0])


@pytest.mark.parametrize(
    "overrides", [("velocity=83.333",), ("velocity=20",), ("bridge.length=30", "velocity=150")]
)
def test_auto_keeps_peaks_within_a_thousandth(overrides: tuple[str, ...]) -> None:
    """Auto sampling and substeps against four times as many samples, on every table channel: 0.1 %."""
    auto = ("solver.sampling=auto", "solver.substeps=auto", "solver.duration=2", *overrides)
    fine = (f"solver.sampling={grid_of(*auto).sampling / 4!r}", "solver.duration=2", *overrides)
    coarse, exact = tables(paper(*auto))["peak"], tables(paper(*fine))["peak"]
    for name, value in coarse.items():
        assert value[0] == pytest.approx(exact[name][0], rel=1e-3), name


def test_samples_enough_for_the_low_pass_filter() -> None:
    """Four in a period of the cut-off: `auto` is that fine, and a coarser sampling is refused."""
    assert grid_of("bridge.low_pass=500", "solver.sampling=auto", "velocity=10").sampling == 1 / 2000
    assert grid_of("bridge.low_pass=30", "solver.sampling=auto", "velocity=10").sampling == 1e-3
    assert grid_of("bridge.low_pass=25", "solver.sampling=0.01").sampling == 0.01
    with pytest.raises(TimeGridError) as refused:
        grid_of("bridge.low_pass=25.1", "solver.sampling=0.01")
    assert refused.value.key == "solver.sampling"
    assert str(refused.value) == (
        "expected at most 0.00996 s, 4 samples in a period of 25.1 Hz (bridge.low_pass), got 0.01 s"
    )


def test_a_crossing_of_very_few_steps() -> None:
    """Fewer than there are batches at least: one batch with one scenario in it."""
    solver = Solver(paper("solver.sampling=0.05", "solver.duration=1", "solver.substeps=3", "velocity=200"))
    plan = make_plan(solver.scenarios, np.ones(1, dtype=bool), 0, None)
    assert plan.steps.sum() == 21
    assert [batch.tolist() for batch in plan.batches] == [[0]]


def test_steps_without_end_are_refused() -> None:
    with pytest.raises(
        TooManyStepsError, match=r"^expected at most 1e\+12 steps in one scenario, got .*e\+14 samp"
    ):
        grid_of("velocity=1e-9")


@pytest.mark.parametrize("every", [0.013, 0.0007, 2.5e-5])
@pytest.mark.parametrize(
    "track", ["track=null", "track={irregularity: {ramp: {at: 0, length: 2, height: 0.01}}}"]
)
def test_histories_keep_the_interval_asked_for(every: float, track: str) -> None:
    """With `sampling: auto`, no interval of which divides it by itself; to rounding of the times."""
    common = ("contact={model: paper}", "velocity=47.3", "solver={sampling: auto, duration: 1.1}", track)
    kept = histories(paper(*common, f"output.histories={{channels: [right_midspan], every: {every}}}"))[
        "time"
    ]
    free = grid_of(*common)
    assert kept == pytest.approx(kept[0] + every * np.arange(len(kept)), abs=1e-12)
    assert kept[-1] + every > free.start + free.last * free.sampling


def test_an_interval_longer_than_the_window_is_said() -> None:
    """Of the shortest window of a grid: 1.1 times 70 m at 90 m/s; the history is its first sample."""
    case = paper(
        "solver={sampling: auto, duration: 1.1}",
        "output.histories={channels: [right_midspan], every: 1 s}",
        "sweep.velocity=[30, 90]",
    )
    (warning,) = case.warnings
    assert warning.endswith(
        "warning: output.histories.every: 1 s is longer than the 0.8556 s of a crossing at 90 m/s: "
        "its history holds nothing but its first sample"
    )
    assert len(histories(case, 1)["time"]) == 1
    assert len(histories(case, 0)["time"]) == 3


def test_intervals_that_cannot_be() -> None:
    """Longer than the window it samples rest alone; with very many radians `exact` never ends."""
    with pytest.raises(TimeGridError, match=r"expected at most 4\.2 s, the whole window, got 4\.3 s"):
        grid_of("solver={sampling: 4.3, duration: 5}")
    assert grid_of("solver={sampling: 4.2, duration: 5}").last == 1
    stiff = (
        "train=hslm-a1",
        "bridge=whole-deck",
        "bridge.right.second_moment=1e15",
        "contact={model: paper}",
    )
    with pytest.raises(TimeGridError, match="for the method exact, 100000 radians of the fastest"):
        grid_of(*stiff, "solver={method: exact, sampling: 0.002}")
