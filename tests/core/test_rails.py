"""Crossings on irregular rails: the window, what must not change a number, limits and statistics."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import quad

from tbi_cli.case import Case, load_case
from tbi_cli.integrator.arrays import LANES
from tbi_cli.runner import Options, run
from tbi_cli.shards import Shard
from tbi_cli.solve import Solver
from tbi_cli.store import open_results
from tbi_cli.track import SPECTRA
from tbi_cli.verify.references.parameters import crossing_from_case
from tbi_cli.verify.references.rail_shapes import rails_of
from tbi_cli.workers import Workers
from tests.core.crossings import case_from, histories, paper, tables
from tests.core.random_cases import crossing, read
from tests.track.unsymmetric import unsymmetric

Array = NDArray[np.float64]
ALL = "output.histories=all"
PARTS = ("level", "curvature")
RANDOM = "track.irregularity.random={spectrum: german-high, coherence: independent}"
SPRUNG_MASS = """
train: {model: sprung-mass, mass: 5750, stiffness: 1595 kN/m, damping: 60 kN*s/m}
bridge:
  length: 25
  modes: 2
  right: {youngs_modulus: 2.87e9, second_moment: 2.9, mass_per_length: 2303, damping: 0}
velocity: 25
"""


def _bits(solver: Solver, indices: list[int]) -> dict[int, bytes]:
    result = solver.solve(indices)
    assert result is not None
    return {
        index: b"".join(table[i].tobytes() for table in result.tables.values())
        for i, index in enumerate(indices)
    }


def test_the_window_begins_on_the_approach() -> None:
    """t = 0 stays the first axle's entry; what passes after it is sampled as long as on level rails."""
    case = paper("track.approach=60", RANDOM, "velocity=75", ALL)
    h = histories(case)
    assert h["time"][0] == -60 / 75
    assert h["time"][-1] == pytest.approx(5 * 70 / 75, abs=1e-3)
    assert np.diff(h["time"]) == pytest.approx(1e-3, rel=1e-9)
    entered = np.abs(h["right_midspan"]) > 0
    assert h["time"][entered][0] == pytest.approx(0.0, abs=2e-3)
    peak = tables(case)["time_of_peak"]["car_body_y"][0]
    assert np.abs(h["car_body_y"]).argmax() == np.searchsorted(h["time"], peak - 1e-9)
    assert all(np.all(values[0] == 0) for name, values in h.items() if name.endswith(("_y", "_midspan")))


@pytest.mark.parametrize(("seed", "model"), [(31, "paper"), (32, "hertz")])
def test_level_irregular_rails_are_level_rails(seed: int, model: str) -> None:
    """A ramp of next to nothing: the same crossing but for the window, from t = 0 on.

    The same steps from t = 0: 50 m/s and 25 m are 500 samples.  Rounding of places enters in another way.
    """
    solver = {"sampling": 1e-3, "substeps": 6, "duration": 1.0}
    case = crossing(seed, velocity=50.0, contact={"model": model}, solver=solver)
    level = histories(read(case))
    ramp = {"at": -20.0, "length": 10.0, "height": 1e-15, "rails": "left"}
    other = histories(read(case | {"track": {"approach": 25.0, "irregularity": {"ramp": ramp}}}))
    for name, values in level.items():
        after = other[name][500:]
        size = max(float(np.max(np.abs(values))), 1e-12)
        assert np.max(np.abs(after - values)) < 1e-6 * size, name


def test_wheelsets_follow_their_rails() -> None:
    """The paper's wheelset is the mean of beam and rail under its two wheels: on the approach, of the rails.

    Cubics of the waves, 64 in each: (2 pi/64)^4/384 = 2.4e-7 of their levels, and they bend as straight
    lines: (2 pi/64)^2/12 = 8e-4 of their curvatures.
    """
    case = crossing(33, raster=1e-3, velocity=50.0, solver={"duration": 0.6})
    irregularity = unsymmetric(33, -52.0, -3.0)
    case |= {"track": {"approach": 80.0, "irregularity": irregularity}}
    h, known = histories(read(case)), crossing_from_case(case)
    rails = rails_of(irregularity, 80.0, known.right.length)
    corners = np.array([*rails[0].corners, *rails[1].corners, -80.0])
    for axle, behind in enumerate(known.train.axle_distances, 1):
        x = 50.0 * h["time"] - behind
        kept = (x < 0) & (np.min(np.abs(x[:, None] - corners), axis=1) > 0.2)
        level, bend = (np.mean([getattr(rail, of)(x[kept]) for rail in rails], axis=0) for of in PARTS)
        assert h[f"wheelset_{axle}_y"][kept] == pytest.approx(level, abs=5e-7 * 3e-3)
        acceleration, expected = h[f"wheelset_{axle}_y_acceleration"][kept], 2500.0 * bend
        assert acceleration == pytest.approx(expected, abs=1e-3 * np.max(np.abs(expected)))


@pytest.mark.parametrize("contact", ["{model: paper, static_load: physical}", "{model: hertz}"])
def test_a_scenario_has_the_same_bits_in_any_company(contact: str) -> None:
    """Other seeds, speeds and lengths of track beside it, in more than one block of lanes."""
    grid = "sweep={seed: [1, 2, 3], velocity: [40, 75], track.approach: [30, 100]}"
    overrides = (f"contact={contact}", RANDOM, "solver={sampling: 0.001, substeps: 4, duration: 0.6}")
    base = crossing(34, raster=1e-3, output={"histories": "none"})
    everything = _bits(Solver(read(base, *overrides, grid)), list(range(12)))
    assert len(set(everything.values())) == 12
    assert len(everything) > LANES
    for index in (0, 5, 11):
        assert _bits(Solver(read(base, *overrides, grid)), [index])[index] == everything[index]
    alone = read(
        base, *overrides, RANDOM.replace("{spec", "{seed: 2, spec"), "velocity=75", "track.approach=30"
    )
    assert _bits(Solver(alone), [0])[0] == everything[1 * 4 + 1 * 2]


def test_the_same_bits_with_any_number_of_jobs_and_shards(tmp_path: Path) -> None:
    """A grid of seeds and speeds whole by one thread and by two, and in two shards."""
    case = paper(RANDOM, "sweep={seed: {from: 0, to: 9, step: 1}, velocity: [60, 80]}", "solver.duration=0.5")

    def bits(name: str, **options: Any) -> Array:
        path = run(case, Options(output=tmp_path / name, **options)).path
        results = open_results(path)
        found = np.array([results.table("peak", v.name) for v in results.channels])
        results.close()
        return found

    one = bits("1.h5", workers=Workers(jobs=1))
    assert np.isfinite(one).all()
    assert np.array_equal(one, bits("2.h5", workers=Workers(jobs=2)))
    shards = [bits(f"shard-{k}.h5", shard=Shard(k, 2)) for k in (1, 2)]
    assert np.array_equal(np.isnan(shards[0]), ~np.isnan(shards[1]))
    assert np.array_equal(one, np.where(np.isnan(shards[0]), shards[1], shards[0]))


def test_steps_resolve_the_shortest_waves(tmp_path: Path) -> None:
    """`auto`: 60 samples in a wave, and at most 0.3 of a radian of it in a step."""
    wave = "track={irregularity: {harmonic: {wavelength: 0.5 m, amplitude: 0.1 mm}}}"
    grid = Solver(case_from(SPRUNG_MASS, tmp_path, wave)).scenarios.crosser(0).grid
    assert grid.sampling <= 0.5 / 25 / 60 * (1 + 1e-12)
    coarse = Solver(case_from(SPRUNG_MASS, tmp_path, wave, "solver.sampling=0.01")).scenarios.crosser(0).grid
    assert coarse.h * 2 * np.pi * 25 / 0.5 <= 0.3 * (1 + 1e-9)


def test_fourth_order_on_smooth_rails(tmp_path: Path) -> None:
    """Fitted slope of the error of a sprung mass over a dip before the bridge, its ends on every step."""
    dip = "track={approach: 30, irregularity: {dip: {at: -25, length: 20, depth: 4 mm}}}"
    case = (SPRUNG_MASS, tmp_path, dip, "solver={sampling: 0.05, duration: 0.5}", ALL)
    finest = histories(case_from(*case, "solver.substeps=320"))
    errors, counts = [], (5, 10, 20, 40)
    for n in counts:
        h = histories(case_from(*case, f"solver.substeps={n}"))
        before = h["time"] <= 1e-9
        errors.append(np.max(np.abs(h["sprung_mass_y"] - finest["sprung_mass_y"])[before]))
    assert -np.polyfit(np.log(counts), np.log(errors), 1)[0] > 3.8


def test_the_response_to_random_rails_has_the_variance_that_theory_gives(tmp_path: Path) -> None:
    """A sprung mass on random rails: its acceleration's variance is the integral of W^4 |H|^2 S.

    Twelve seeds of 2.25 km each at 25 m/s, 90 s; the mass answers within a band of about 5 rad/s, so that a
    seed holds some 90 x 5/pi = 140 independent values: the mean square of all is good to sqrt(2/1700) = 3.5
    %, four times of which is let pass.
    """
    track = "track={approach: 3000, irregularity: {random: {spectrum: german-low}}}"
    sweep = "sweep={seed: {from: 1, to: 12, step: 1}}"
    kept = "output.histories={channels: [sprung_mass_y_acceleration]}"
    solver = "solver={sampling: 0.005, substeps: 2, duration: 1}"
    case: Case = case_from(SPRUNG_MASS, tmp_path, track, sweep, kept, solver)
    result = Solver(case).solve(list(range(12)))
    assert result is not None
    squares = []
    for history in result.histories.values():
        steady = (history.time > -3000 / 25 * 0.75) & (history.time < 0)
        squares.append(np.mean(history.values[0][steady] ** 2))
    k, c, m, v = 1595e3, 60e3, 5750.0, 25.0

    def density(wavenumber: float) -> float:
        w = v * wavenumber
        answer = abs((k + 1j * c * w) / (k - m * w * w + 1j * c * w)) * w * w
        return float(answer**2 * SPECTRA["german-low"].vertical(np.array(wavenumber)))

    theory = quad(density, 2 * np.pi / 150, 2 * np.pi / 3, limit=200)[0]
    assert np.mean(squares) == pytest.approx(theory, rel=4 * 0.035)


def test_measured_rails_from_a_file_are_those_of_the_formula(tmp_path: Path) -> None:
    """A harmonic rail, and the same as points every 0.25 m, 32 in a wave: a spline is good to 1e-5 of it."""
    x = np.arange(-100.0, 125.1, 0.25)
    level = 1e-3 * np.sin(2 * np.pi * x / 8)
    (tmp_path / "rails.csv").write_text(
        "x, right [mm]\n"
        + "".join(f"{a},{1e3 * b!r}\n" for a, b in zip(x.tolist(), level.tolist(), strict=True))
    )
    solver = "solver={sampling: 0.002, substeps: 4, duration: 1}"
    formula = "track.irregularity.harmonic={wavelength: 8, amplitude: 1 mm}"
    one = tables(case_from(SPRUNG_MASS, tmp_path, solver, formula))["peak"]
    measured = f"track.irregularity.profile={{csv: {tmp_path / 'rails.csv'}}}"
    other = tables(case_from(SPRUNG_MASS, tmp_path, solver, measured))["peak"]
    for name in ("sprung_mass_y", "right_midspan"):
        assert other[name][0] == pytest.approx(one[name][0], rel=2e-5), name


def test_rails_of_a_built_in_case() -> None:
    """The shipped case of irregular rails runs, and differs from level rails."""
    case = load_case("irregular/dip", overrides=["sweep.track.irregularity.dip.depth=[0, 10 mm]"])
    level, rough = tables(case)["peak"]["front_bogie_y_acceleration"]
    assert rough > 1.5 * level
