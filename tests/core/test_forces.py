"""Trains of constant forces: their kernel against the general one, and both against the exact solution."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from tbi_cli.batch import Crosser, build_batch
from tbi_cli.case import Case
from tbi_cli.integrator.arrays import LANES
from tbi_cli.integrator.integrate import integrate
from tbi_cli.scenarios import make_model
from tbi_cli.solve import Solver
from tbi_cli.timegrid import TimeGrid, time_grid
from tbi_cli.verify.references.moving_force import critical_speed, deflection, resonant_speed
from tbi_cli.verify.references.parameters import Beam, beam_from_mapping
from tests.core.crossings import case_from, histories, tables

LENGTH, MODES = 20.0, 4
TEXT = """
train: {model: moving-load, forces: %s, positions: %s}
bridge:
  length: 20 m
  modes: 4
  stations: [3 m, 10 m, 20 m]
  right: {youngs_modulus: 30e9, second_moment: 0.3, mass_per_length: 10e3, damping: {ratio: 2 %%}}
velocity: %r
solver: {sampling: %r, duration: 1.2}
output: {histories: all}
"""


def beam(ratio: float = 0.02) -> Beam:
    given = {"youngs_modulus": 30e9, "second_moment": 0.3, "mass_per_length": 10e3}
    return beam_from_mapping({**given, "damping": {"ratio": ratio}}, LENGTH, MODES)


def forces_case(
    folder: Path,
    forces: list[float],
    positions: list[float],
    *overrides: str,
    velocity: float = 50.0,
    sampling: float = 1e-3,
) -> Case:
    return case_from(TEXT % (forces, positions, velocity, sampling), folder, *overrides)


def both_kernels(case: Case) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Histories of all channels by the kernel for forces and by the general one, (channels, samples)."""
    model = make_model(case)
    channels = range(len(model.channels))
    batch = build_batch([Crosser(model, case.velocity, time_grid(case, model.pace))], channels, channels)
    assert batch.topology.forces
    found = []
    for topology in (batch.topology, batch.topology._replace(forces=False, wheel_signals=True)):
        result = integrate(topology, batch.crossing, batch.last, batch.substeps, every=np.ones(1, np.int64))
        found.append(result.histories[0])
    return found[0], found[1]


@settings(max_examples=15, deadline=None)
@given(
    gaps=st.lists(st.integers(0, 3000).map(lambda cm: cm / 100), min_size=1, max_size=11),
    velocity=st.floats(5.0, 120.0),
    sampling=st.sampled_from([5e-4, 1e-3, 2.3e-3]),
    start=st.integers(0, 4000).map(lambda cm: cm / 100),
    span=st.floats(6.0, 40.0),
)
def test_the_kernel_for_forces_is_the_general_one(
    gaps: list[float],
    velocity: float,
    sampling: float,
    start: float,
    span: float,
    tmp_path_factory: pytest.TempPathFactory,
) -> None:
    """Every channel over time, whatever stands on the bridge, enters and leaves within one step: rounding."""
    positions = (start + np.concatenate([[0.0], np.cumsum(gaps)])).tolist()
    forces = [1e5 + 1e4 * k for k in range(len(positions))]
    folder = tmp_path_factory.mktemp("forces")
    bridge = (f"bridge.length={span}", "bridge.stations={fractions: [0.15, 0.5, 1]}", "solver.substeps=auto")
    case = forces_case(folder, forces, positions, *bridge, velocity=velocity, sampling=sampling)
    one, other = both_kernels(case)
    size = np.maximum(np.abs(other).max(axis=1), 1e-12)
    assert (np.abs(one - other).max(axis=1) < 1e-11 * size).all()


def test_a_force_that_enters_and_leaves_within_one_step(tmp_path: Path) -> None:
    """A span of 0.5 m at 100 m/s and steps of 10 ms: both kernels give it the same impulse."""
    case = forces_case(
        tmp_path, [1e5, 1e5], [0.0, 0.31], "bridge.length=0.5", "bridge.stations=[0.2]", velocity=100.0
    )
    model = make_model(case)
    crosser = Crosser(model, 100.0, TimeGrid(1e-2, 4000, 20))
    batch = build_batch([crosser], [0], [0])
    fine = integrate(batch.topology, batch.crossing, batch.last, batch.substeps)
    exact = build_batch([Crosser(model, 100.0, TimeGrid(1e-2, 1, 20), exact=True)], [0], [0])
    closed = integrate(exact.topology, exact.crossing, exact.last, 1)
    assert fine.maximum == pytest.approx(closed.maximum, rel=1e-6)
    assert fine.minimum == pytest.approx(closed.minimum, rel=1e-6)


def test_a_consist_of_forces_is_their_list(tmp_path: Path) -> None:
    """Two groups of axles on one train, and the same axles in one list: the same bits in every table."""
    listed = forces_case(tmp_path, [1e5, 9e4, 1e5, 9e4], [0.0, 3.0, 12.0, 15.0])
    axles = "{model: axle-forces, forces: [100 kN, 90 kN], positions: [0, 3]}"
    grouped = forces_case(
        tmp_path, [1.0], [0.0], f"train={{consist: [{{vehicle: {axles}, count: 2, spacing: 12}}]}}"
    )
    one, other = tables(listed), tables(grouped)
    for table, channels in one.items():
        for name, values in channels.items():
            assert values.tobytes() == other[table][name].tobytes(), (table, name)


def exactly(
    folder: Path, *overrides: str, velocity: float, sampling: float
) -> dict[str, NDArray[np.float64]]:
    # They begin anywhere: 3.3 and 24.7 m behind the first.
    forces, positions = [1e5, 8e4, 1.2e5], [4.25, 7.55, 28.95]
    case = forces_case(
        folder, forces, positions, "solver.method=exact", *overrides, velocity=velocity, sampling=sampling
    )
    return histories(case)


@pytest.mark.parametrize("ratio", [0.0, 0.01, 0.99, 3.0])
@pytest.mark.parametrize("sampling", [3e-4, 7e-3, 0.19, 5.0])
def test_exact_is_exact(ratio: float, sampling: float, tmp_path: Path) -> None:
    """Fryba's closed form to rounding, samples much closer than any period to longer than the crossing."""
    overrides = (f"bridge.right.damping={{ratio: {ratio}}}", "solver.duration=4")
    run = exactly(tmp_path, *overrides, velocity=23.7, sampling=sampling)
    closed = deflection(beam(ratio), [1e5, 8e4, 1.2e5], [0.0, 3.3, 24.7], 23.7, run["time"])
    size = np.abs(deflection(beam(ratio), [1e5], [0.0], 23.7, np.linspace(0.0, 1.0, 400))).max()
    # Rounding of phases: eps omega_4 t of the modes, 1e-16 * 1200 rad/s * 8 s.
    assert np.abs(run["right_midspan"] - closed).max() < 2e-12 * size


@pytest.mark.parametrize(
    "speed", [critical_speed(beam()), critical_speed(beam()) / 2, resonant_speed(beam(), 24.7, 2)]
)
def test_exact_at_resonance(speed: float, tmp_path: Path) -> None:
    """Undamped, a force as long on the bridge as half a period of its mode: no small divisor anywhere."""
    run = exactly(tmp_path, "bridge.right.damping={ratio: 0}", velocity=speed, sampling=1.7e-3)
    closed = deflection(beam(0.0), [1e5, 8e4, 1.2e5], [0.0, 3.3, 24.7], speed, run["time"])
    assert np.abs(run["right_midspan"] - closed).max() < 1e-12 * np.abs(closed).max()


def test_exact_does_not_depend_on_the_samples(tmp_path: Path) -> None:
    """Every channel at common times, whether seven samples or none lie between them."""
    fine = exactly(tmp_path, velocity=61.3, sampling=1.3e-3)
    coarse = exactly(tmp_path, velocity=61.3, sampling=8 * 1.3e-3)
    for name, values in coarse.items():
        twin = fine[name][::8][: len(values)]
        assert np.abs(values - twin).max() <= 1e-12 * np.abs(fine[name]).max(), name


def test_runge_kutta_tends_to_exact_with_fourth_order(tmp_path: Path) -> None:
    """Accelerations and moments too; entries and exits on samples."""
    overrides = ("train.positions=[0, 3.5, 25]", "solver.duration=1.1")
    exact = exactly(tmp_path, *overrides, velocity=50.0, sampling=5e-3)
    names = ("right_midspan", "right_midspan_acceleration", "right_station_1_moment", "right_station_2_shear")
    substeps, errors = (16, 32, 64), {name: [] for name in names}
    for n in substeps:
        run = exactly(
            tmp_path, "solver.method=rk4", f"solver.substeps={n}", *overrides, velocity=50.0, sampling=5e-3
        )
        for name in names:
            errors[name].append(np.abs(run[name] - exact[name]).max())
    for name, found in errors.items():
        slope = -np.polyfit(np.log(substeps), np.log(found), 1)[0]
        assert 3.8 < slope < 4.3, name


def test_exact_in_any_company(tmp_path: Path) -> None:
    """The bits of a scenario by itself, in lanes of unlike speeds and spans."""
    sweep = "sweep={velocity: {from: 20, to: 74, step: 3}, span: [15, 20, 30.5]}"
    stations = "bridge.stations={fractions: [0.2, 1]}"
    hslm = ("train={model: hslm-a, number: 4}", "solver.method=exact")
    case = forces_case(tmp_path, [1.0], [0.0], *hslm, stations, sweep)
    solver = Solver(case)
    together = solver.solve(range(len(solver.scenarios)))
    assert together is not None and len(solver.scenarios) > 6 * LANES
    for index in (0, 7, 20, 56):
        alone = Solver(case).solve([index])
        assert alone is not None
        for table, values in together.tables.items():
            assert values[index].tobytes() == alone.tables[table][0].tobytes()
