"""What must not change a number: lanes, batches, jobs, other scenarios, the order of the grid."""

from __future__ import annotations

import platform
from dataclasses import replace
from pathlib import Path

import h5py
import numba
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tbi_cli.batch import build_batch
from tbi_cli.integrator import native
from tbi_cli.integrator.arrays import LANES, Vector
from tbi_cli.integrator.integrate import integrate
from tbi_cli.integrator.kernel_cache import call
from tbi_cli.integrator.kernels import KERNELS
from tbi_cli.integrator.machine_code import compiled, module
from tbi_cli.runner import Options, run
from tbi_cli.solve import Solver
from tbi_cli.workers import Workers
from tests.core.compilations import of_the_oldest_processor
from tests.core.crossings import paper, tables
from tests.core.random_cases import crossing, read

VELOCITIES = "[31, 50, 72.5, 90, 111, 138, 150, 177, 193, 200]"
GRID = f"sweep={{velocity: {VELOCITIES}, train.car_body.mass: [20 t, 40 t, 77 t]}}"
UNEQUAL = crossing(51, raster=1e-3, output={"histories": "none"})


def _bits(solver: Solver, indices: list[int]) -> dict[int, bytes]:
    result = solver.solve(indices)
    assert result is not None
    return {
        index: b"".join(table[i].tobytes() for table in result.tables.values())
        for i, index in enumerate(indices)
    }


@settings(max_examples=10, deadline=None)
@given(data=st.data())
def test_a_scenario_has_the_same_bits_in_any_company(data: st.DataObject) -> None:
    """Alone, or with any others in any order, across more than one block of lanes."""
    solver = Solver(read(UNEQUAL, GRID, "solver.duration=1"))
    chosen = data.draw(st.lists(st.integers(0, 29), min_size=1, max_size=2 * LANES + 3, unique=True))
    together = _bits(solver, chosen)
    for index in chosen[:3]:
        assert _bits(Solver(read(UNEQUAL, GRID, "solver.duration=1")), [index]) == {index: together[index]}


def test_a_case_has_the_same_bits_as_a_point_of_a_grid() -> None:
    """The grid point (50 m/s, 77 t) and the case that says so."""
    index = 1 * 3 + 2
    grid = _bits(Solver(read(UNEQUAL, GRID)), [index])[index]
    alone = _bits(Solver(read(UNEQUAL, "velocity=50", "train.car_body.mass=77 t")), [0])[0]
    assert grid == alone


@pytest.mark.parametrize("modes", [1, 2, 7, 20])
def test_any_number_of_modes(modes: int) -> None:
    """1 to 20 modes, alone and beside others that have another number."""
    steps = "solver={substeps: auto, duration: 1}"
    swept = Solver(read(UNEQUAL, "sweep={modes: [1, 2, 7, 20]}", steps))
    alone = Solver(read(UNEQUAL, f"bridge.modes={modes}", steps))
    index = [1, 2, 7, 20].index(modes)
    assert _bits(swept, [index])[index] == _bits(alone, [0])[0]


def _tables(path: Path) -> dict[str, bytes]:
    found: dict[str, bytes] = {}
    with h5py.File(path) as file:
        file.visititems(
            lambda name, item: (
                found.update({name: item[()].tobytes()})
                if isinstance(item, h5py.Dataset) and item.dtype.kind in "fi"
                else None
            )
        )
    return found


def test_the_same_bits_with_any_number_of_jobs(tmp_path: Path) -> None:
    """Whole results files, histories included."""
    histories = "output.histories={channels: [car_body_y, wheel_1_right_force], every: 0.01}"
    case = paper(GRID, "solver.duration=1", histories)
    files = [
        run(case, Options(output=tmp_path / f"{jobs}.h5", workers=Workers(jobs=jobs))).path
        for jobs in (1, 2, 5)
    ]
    first, *others = (_tables(path) for path in files)
    assert first
    for other in others:
        assert other == first


def test_kernel_calls_of_a_grid() -> None:
    """One call per block of lanes and end of a scenario in it, none per step."""
    solver = Solver(paper("sweep={velocity: {from: 50, to: 65, step: 1}}"))
    crossers = [solver.scenarios.crosser(i) for i in range(16)]
    batch = build_batch(crossers, range(10), ())
    result = integrate(batch.topology, batch.crossing, batch.last, batch.substeps)
    assert 2 <= result.kernel_calls <= 16
    assert batch.last.sum() > 70_000


def test_nothing_is_allocated_in_the_step_loop() -> None:
    """A kernel that allocates cannot be compiled; those that there are call LLVM's intrinsics alone."""
    with pytest.raises(numba.TypingError, match="empty"):
        compiled("allocates", numba.njit(lambda a, n: np.zeros(n).sum()), (Vector,))
    for name in KERNELS:
        called = {function.name for function in module(name).functions if function.is_declaration}
        assert called
        assert all(callee.startswith("llvm.") for callee in called), called


def test_a_kernel_refuses_arrays_that_are_not_its_own() -> None:
    """It has their addresses alone: type, axes and order are checked before."""
    table, vector = np.zeros((4, 3)), np.zeros(3)
    for wrong in (vector, table.astype(np.float32), np.asfortranarray(table), table[:, ::2]):
        with pytest.raises(TypeError, match="contiguous array of 2 axes of float64"):
            call("one_interval", wrong, table, vector, vector, table)
    with pytest.raises(ValueError, match="shorter"):
        call("one_interval", table, table, vector, vector)


@pytest.mark.skipif(platform.machine() not in ("x86_64", "AMD64"), reason="names processors of that kind")
@pytest.mark.parametrize(
    ("name", "overrides"),
    [
        ("advance", ()),
        ("advance_forces", ("train=hslm-a1", "bridge=whole-deck", "contact.static_load=physical")),
    ],
)
def test_the_same_bits_without_wide_vectors(
    name: str, overrides: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Code for the oldest processor of this kind: vectors of two, and multiply-adds by a library."""
    case = paper(*overrides, "sweep={velocity: [50, 60, 83.3]}", "solver.duration=1")
    here = _bits(Solver(case), [0, 1, 2])
    code = of_the_oldest_processor(monkeypatch, [name])[name]
    assert b"fma" in code, "calls the library, as this processor has no such instruction"
    assert _bits(Solver(case), [0, 1, 2]) == here


@pytest.mark.skipif(platform.machine() not in ("x86_64", "AMD64"), reason="names a processor of that kind")
def test_eight_lanes_are_one_register_where_there_are_wide_ones(monkeypatch: pytest.MonkeyPatch) -> None:
    """Code for a processor with vector units of 512 bits, which LLVM makes on any machine of this kind.

    A compiler that split the lanes in two would name registers of 256 bits throughout; scalars, as places in
    memory are, take those of 128.
    """
    monkeypatch.setattr(native.llvm, "get_host_cpu_name", lambda: "x86-64-v4")
    monkeypatch.setattr(native.llvm, "get_host_cpu_features", native.llvm.FeatureMap)
    assembly = native.target_machine().emit_assembly(module("advance"))
    wide, half = assembly.count("%zmm"), assembly.count("%ymm")
    assert wide > 100 and half < 0.05 * wide


def test_failed_scenarios_fail_alone() -> None:
    """A state that overflows is recorded with its message; its neighbours have the bits that they have alone.

    The load of the middle one is so large that squares and forces leave the range of floating point.
    """
    case = paper("sweep={gravity: [1, 2, 3]}", "solver.duration=1")
    # The case reader would refuse the middle value; what comes after it must cope all the same.
    grid = case.swept((replace(case.axes[0], values=(9.81, 1e303, 4.0)),))
    result = Solver(grid).solve([0, 1, 2])
    assert result is not None
    assert result.status.tolist() == [1, 2, 1]
    assert "finite" in result.messages[1]
    assert np.isnan(result.tables["peak"][1]).all()
    for index, gravity in ((0, 9.81), (2, 4.0)):
        alone = _bits(Solver(paper(f"gravity={gravity}", "solver.duration=1")), [0])[0]
        assert b"".join(table[index].tobytes() for table in result.tables.values()) == alone


def test_a_motion_that_has_died_away_stays_finite() -> None:
    """Two hundred crossing times: the free motion sinks below the smallest normal number; nothing fails."""
    long, short = (tables(paper("velocity=200", f"solver.duration={n}")) for n in (200, 5))
    assert all(np.isfinite(values).all() for table in long.values() for values in table.values())
    assert long["peak"]["right_midspan"] == short["peak"]["right_midspan"]
