"""Along the beams: deflection, bending moment and shear force at stations, and low-passed accelerations."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.signal import butter, sosfilt

from tbi_cli.solve import Solver
from tbi_cli.verify.references.moving_force import modal_coordinates
from tbi_cli.verify.references.parameters import Beam, beam_from_mapping
from tbi_cli.verify.references.stations import modal_shares, moment_and_shear
from tests.core.crossings import Histories, case_from, histories, paper, tables

TEXT = """
train: {model: moving-load, forces: [100 kN], positions: [0]}
bridge:
  length: 20 m
  modes: 4
  stations: [0, 5, 10, 20]
  right: {youngs_modulus: 30e9, second_moment: 0.3, mass_per_length: 10e3, damping: {ratio: 2 %}}
velocity: 50
solver: {method: exact, sampling: 1e-3, duration: 1.5}
output: {histories: all}
"""
FORCE, LENGTH, MU = 1e5, 20.0, 10e3


def beam(n: int) -> Beam:
    given = {"youngs_modulus": 30e9, "second_moment": 0.3, "mass_per_length": MU, "damping": {"ratio": 0.02}}
    return beam_from_mapping(given, LENGTH, n)


def along(h: Histories, quantity: str, count: int, side: str = "right") -> NDArray[np.float64]:
    """A quantity at all stations, (stations, samples)."""
    return np.array([h[f"{side}_station_{s + 1}_{quantity}"] for s in range(count)])


def test_deflections_are_sums_over_the_modes() -> None:
    """Of both beams under the full train: sqrt(2/L) sin(i pi x/L) q_i; in the middle those of mid-span."""
    places = [7.5, 25.0, 41.3]
    h = histories(paper(f"bridge.stations={places}", "output.histories=all", "solver.duration=1"))
    for side in ("right", "left"):
        modes = np.array([h[f"{side}_mode_{i}"] for i in (1, 2, 3, 4)])
        shapes = np.sqrt(2 / 50) * np.sin(np.outer(places, np.arange(1, 5)) * np.pi / 50)
        found, expected = along(h, "deflection", 3, side), shapes @ modes
        assert np.abs(found - expected).max() < 1e-13 * np.abs(expected).max()
        for suffix, twin in (
            ("deflection", ""),
            ("velocity", "_velocity"),
            ("acceleration", "_acceleration"),
        ):
            at_middle, midspan = h[f"{side}_station_2_{suffix}"], h[f"{side}_midspan{twin}"]
            assert np.abs(at_middle - midspan).max() < 1e-13 * np.abs(midspan).max()


def test_acceleration_is_the_second_derivative(tmp_path: Path) -> None:
    """Between entry and exit, by central differences: their error is (omega_4 dt)^2/12 of the fourth mode."""
    h = histories(case_from(TEXT, tmp_path, "solver.sampling=1e-5"))
    on = slice(1000, 39000)
    for s in (2, 3):
        y, a = h[f"right_station_{s}_deflection"][on], h[f"right_station_{s}_acceleration"][on]
        differences = (y[2:] - 2 * y[1:-1] + y[:-2]) / 1e-5**2
        assert np.abs(differences - a[1:-1]).max() < 2e-4 * np.abs(a).max()


def test_equilibrium_of_the_whole_beam(tmp_path: Path) -> None:
    """What the supports push is the forces on the beam, plus mu w'' + c w' integrated along it.

    Four stations give the four modes, and these the integrals: of sin(i pi x/L), 2 L/(i pi) for odd i.
    """
    places = [2.0, 6.0, 11.0, 17.0]
    text = TEXT.replace("stations: [0, 5, 10, 20]", f"stations: [0, 20, {', '.join(map(str, places))}]")
    h = histories(case_from(text, tmp_path, "train.forces=[100 kN, 60 kN]", "train.positions=[0, 7.3]"))
    order = np.arange(1, 5)
    to_modes = np.linalg.inv(np.sin(np.outer(places, order) * np.pi / LENGTH))
    rates = to_modes @ along(h, "velocity", 6)[2:]
    accelerations = to_modes @ along(h, "acceleration", 6)[2:]
    damping = 2 * 0.02 * beam(4).omega
    integrals = np.where(order % 2 == 1, 2 * LENGTH / (order * np.pi), 0.0)
    inertia = MU * integrals @ (accelerations + damping[:, None] * rates)
    t = h["time"]
    on = [(t - lag >= 0) & (50 * (t - lag) <= LENGTH) for lag in (0.0, 7.3 / 50)]
    forces = 1e5 * on[0] + 6e4 * on[1]
    pushed = h["right_station_1_shear"] - h["right_station_2_shear"]
    assert np.abs(pushed - forces - inertia).max() < 1e-10 * 1e5


def test_shear_is_the_slope_of_the_moment(tmp_path: Path) -> None:
    """dM/dx = V all along, at every sample, but where the force stands: Simpson over 0.5 m."""
    count = 81
    stations = f"bridge.stations={{fractions: {[k / (count - 1) for k in range(count)]}}}"
    h = histories(case_from(TEXT, tmp_path, stations, "solver.sampling=0.01"))
    M, V = along(h, "moment", count), along(h, "shear", count)
    x = np.linspace(0.0, LENGTH, count)
    step = x[2] - x[0]
    change, mean = M[2::2] - M[:-2:2], (V[:-2:2] + 4 * V[1:-1:2] + V[2::2]) / 6 * step
    xi = 50 * h["time"]
    under = (xi >= x[:-2:2, None] - 1e-9) & (xi <= x[2::2, None] + 1e-9)
    assert under.any(axis=0).sum() > 30
    # Simpson: (4 pi h/L)^4/2880 of the fourth mode's moment.
    assert np.abs(change - mean)[~under].max() < 1e-6 * np.abs(M).max()
    assert np.abs(M[[0, -1]]).max() < 1e-12 * np.abs(M).max()


def test_the_shear_force_jumps_by_the_force(tmp_path: Path) -> None:
    """By +F as it passes a station, where samples are 5 mm of way apart; right above it has jumped."""
    h = histories(case_from(TEXT, tmp_path, "solver.sampling=1e-4"))
    V = h["right_station_2_shear"]
    at = int(np.argmin(np.abs(50 * h["time"] - 5.0)))
    assert 50 * h["time"][at] == pytest.approx(5.0)
    # All else changes by 2 v dt/L = 5e-4 of the force, and little more with the beam's motion.
    assert V[at + 1] - V[at - 1] == pytest.approx(FORCE, rel=0.01)
    assert V[at] == pytest.approx(V[at + 1], abs=0.01 * FORCE)


def test_moment_and_shear_converge_fast(tmp_path: Path) -> None:
    """Towards 300 modes with n^-2 and n^-1: what the modes left out bear at rest, i^-2 and i^-1, is in it.

    What is not is their free vibration, 1/i of that.
    """
    counts = (2, 4, 8, 16)
    errors: dict[str, list[float]] = {"moment": [], "shear": []}
    exact: tuple[NDArray[np.float64], NDArray[np.float64]] | None = None
    for n in counts:
        h = histories(case_from(TEXT, tmp_path, f"bridge.modes={n}", "bridge.stations=[6.3]"))
        xi = 50 * h["time"][None, :]
        if exact is None:
            q = modal_coordinates(beam(300), FORCE, 50.0, h["time"])[0]
            exact = moment_and_shear(beam(300), 6.3, q, np.full_like(xi, FORCE), xi)
        for (name, found), theirs in zip(errors.items(), exact, strict=True):
            found.append(float(np.abs(h[f"right_station_1_{name}"] - theirs).max() / np.abs(theirs).max()))
    for name, order in (("moment", 1.8), ("shear", 0.8)):
        slope = -np.polyfit(np.log(counts), np.log(errors[name]), 1)[0]
        assert slope > order, name
    assert errors["moment"][-1] < 1e-3 and errors["shear"][-1] < 1e-2


def test_stations_of_a_swept_span(tmp_path: Path) -> None:
    """Fractions move with the span: each point of the grid is the case that says so, to the bit."""
    stations, names = "bridge.stations={fractions: [0.25, 1]}", ("moment", "shear", "deflection")
    grid = tables(case_from(TEXT, tmp_path, stations, "sweep={span: [12, 20]}"))
    for k, span in enumerate((12, 20)):
        places = f"bridge.stations=[{span / 4}, {span}]"
        alone = tables(case_from(TEXT, tmp_path, places, f"bridge.length={span}"))
        for name in names:
            channel = f"right_station_1_{name}"
            assert grid["peak"][channel][k] == alone["peak"][channel][0]


def low_passed(y: NDArray[np.float64], cut_off: float, interval: float) -> NDArray[np.float64]:
    return np.asarray(sosfilt(butter(4, cut_off, fs=1 / interval, output="sos"), y))


def test_low_pass_of_both_beams() -> None:
    """Each beam by its own frequencies, mid-span and stations, from the unfiltered history by scipy's filter.

    A short span, so that f3 = 9 f1 and not 30 Hz decides, another for each beam.
    """
    case = paper(
        "bridge.length=15",
        "bridge.stations=[4]",
        "bridge.low_pass=en-1990",
        "output.histories=all",
        "solver={sampling: 5e-4, duration: 1.2}",
    )
    h = histories(case)
    cuts = {
        side: 1.5 * max(30.0, 9 * np.pi / (2 * 15**2) * np.sqrt(EI / mu))
        for side, EI, mu in (("right", 207e9 * 0.2, 20e3), ("left", 200e9 * 0.2, 18e3))
    }
    assert min(cuts.values()) > 45 and cuts["left"] > 1.03 * cuts["right"]
    for side, cut_off in cuts.items():
        for place in ("midspan", "station_1"):
            y = h[f"{side}_{place}_acceleration"]
            expected = low_passed(y, cut_off, 5e-4)
            found = h[f"{side}_{place}_acceleration_low_pass"]
            assert np.abs(found - expected).max() < 1e-12 * np.abs(y).max()


@pytest.mark.parametrize(("length", "first"), [(11.0, 7.3), (23.0, 2.1)], ids=["f3", "30 Hz"])
def test_what_en_1990_counts_passes(length: float, first: float) -> None:
    """At mid-span and at L/6, where the third mode is largest: 98 % of every mode up to the limit.

    Measured while the beam swings freely, behind the forces.
    1 - 1/sqrt(1 + 1.5^-8) = 1.9 % of what is at the limit is lost.  Fits of undamped free vibration are exact
    but for rounding and what is left of the filter's own ringing.
    """
    inertia = 9e3 / 32e9 * (2 * length**2 * first / np.pi) ** 2
    beam_text = f"{{youngs_modulus: 32e9, second_moment: {inertia}, mass_per_length: 9e3, damping: 0}}"
    case = paper(
        "train={model: axle-forces, forces: [170 kN, 90 kN, 210 kN], positions: [0, 2.3, 9.7]}",
        f"bridge={{length: {length}, modes: 6, right: {beam_text}}}",
        "bridge.low_pass=en-1990",
        "bridge.stations={fractions: [0.16666666666666667]}",
        "contact={model: paper}",
        "velocity=61",
        "solver={method: exact, sampling: 2e-4, duration: 2}",
        "output.histories=all",
    )
    h = histories(case)
    beam = beam_from_mapping(case.resolved()["bridge"]["right"], length, 6)
    limit = max(30.0, 9 * first)
    free = h["time"] > 1.2 * (length + 9.7) / 61
    for place, modes in (("midspan", [1, 3, 5]), ("station_1", [1, 2, 3, 4, 5])):
        y = h[f"right_{place}_acceleration"]
        seen = np.isin(np.arange(1, 7), modes)
        shares = modal_shares(
            h[f"right_{place}_acceleration_low_pass"][free], y[free], beam, seen, h["time"][free]
        )
        hertz = np.array(modes) ** 2 * first
        warped = np.tan(np.pi * hertz * 2e-4) / np.tan(np.pi * 1.5 * limit * 2e-4)
        assert shares == pytest.approx(1 / np.sqrt(1 + warped**8), rel=1e-6), place
        assert (shares[hertz <= limit] > 0.98).all(), place


@pytest.mark.parametrize("cut_off", [8.0, 30.0, 120.0])
def test_tables_of_the_low_passed_acceleration(cut_off: float, tmp_path: Path) -> None:
    """The filter runs over every sample, whichever of them a history keeps."""
    thin = "output.histories={channels: [right_midspan_acceleration_low_pass], every: 0.01}"
    overrides = (f"bridge.low_pass={cut_off}", "solver.sampling=1e-3")
    full = histories(case_from(TEXT, tmp_path, *overrides))
    kept = case_from(TEXT, tmp_path, *overrides, thin)
    found, history = tables(kept), histories(kept)
    name = "right_midspan_acceleration_low_pass"
    expected = low_passed(full["right_midspan_acceleration"], cut_off, 1e-3)
    assert found["max"][name][0] == pytest.approx(expected.max(), rel=1e-12)
    assert found["min"][name][0] == pytest.approx(expected.min(), rel=1e-12)
    assert found["rms"][name][0] == pytest.approx(np.sqrt(np.mean(expected**2)), rel=1e-12)
    assert found["time_of_peak"][name][0] == pytest.approx(np.argmax(np.abs(expected)) * 1e-3)
    assert np.array_equal(history[name], full[name][::10][: len(history[name])])


def test_no_low_pass_unless_asked_for(tmp_path: Path) -> None:
    names = [channel.name for channel in Solver(case_from(TEXT, tmp_path)).channels]
    assert not [name for name in names if "low_pass" in name]
