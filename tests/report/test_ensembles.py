"""Ensembles, rails and lift-off in the report: the arrays behind the figures are those of the file."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from pathlib import Path

import h5py
import numpy as np
import pytest

from tbi_cli.case import load_case
from tbi_cli.report.contact_figures import contact_figures
from tbi_cli.report.ensembles import Statistics, ensemble_figures, ensemble_table
from tbi_cli.report.interactive import interactive
from tbi_cli.report.plot import Array, Panel, Plot
from tbi_cli.report.study import Study, open_studies
from tbi_cli.report.track_figures import track_figures
from tbi_cli.report.wishes import Wishes
from tbi_cli.runner import Options, run
from tests.cli.commands import tbi

CASE = (
    "contact={model: hertz, damping: 50e3}",
    "track={irregularity: {random: {spectrum: fra-6, coherence: independent}}}",
    "solver={sampling: 0.002, substeps: auto, duration: 0.8}",
    "output.histories={channels: [car_body_y, wheel_1_right_force, wheel_2_right_force]}",
)
SEEDS, VELOCITIES = 7, (60.0, 90.0)


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Seven seeds at two speeds, the wheels of which lift off at the faster one."""
    path = tmp_path_factory.mktemp("ensemble") / "rough.h5"
    sweep = f"sweep={{seed: {{from: 1, to: {SEEDS}, step: 1}}, velocity: {list(VELOCITIES)}}}"
    run(load_case("paper", overrides=[*CASE, sweep]), Options(output=path))
    return path


@pytest.fixture
def study(file: Path) -> Iterator[Study]:
    (opened,) = open_studies([file])
    yield opened
    opened.results.close()


def panels(plot: Plot) -> list[Panel]:
    return [panel for panel in plot.panels if isinstance(panel, Panel)]


def table(file: Path, name: str) -> Array:
    with h5py.File(file, locking=False) as results:
        values: Array = results[name][()]
        return values


def named(study: Study, name: str) -> Plot:
    plots = {plot.name: plot for plot in ensemble_figures(study, Wishes(), {})}
    return plots[f"rough-ensemble-{name}"]


def test_bands_over_velocity_are_those_of_the_tables(study: Study, file: Path) -> None:
    for name, channel in (("displacement", "peak/car_body_y"), ("wheel-forces", "max/wheel_1_right_force")):
        values = table(file, channel)
        panel = panels(named(study, name))[0]
        mean, median = panel.curves
        assert panel.x.label == "train velocity v"
        assert mean.x.tolist() == list(VELOCITIES)
        assert mean.y == pytest.approx(values.mean(axis=0), rel=1e-14)
        assert median.y == pytest.approx(np.median(values, axis=0), rel=1e-14)
        wide, narrow = panel.bands
        assert wide.low == pytest.approx(np.percentile(values, 5, axis=0), rel=1e-14)
        assert wide.high == pytest.approx(np.percentile(values, 95, axis=0), rel=1e-14)
        sigma = values.std(axis=0, ddof=1)
        assert narrow.high - narrow.low == pytest.approx(2 * sigma, rel=1e-10)


def test_an_ensemble_over_velocity_has_the_marks_of_any_sweep(study: Study) -> None:
    (vertical, _) = panels(named(study, "acceleration"))
    assert [limit.value for limit in vertical.limits] == [0.37, 0.49]
    # Table 2 of the paper: 72.3 m/s for the right beam, 74.9 m/s for the left; 60 to 90 m/s are drawn.
    assert [(mark.label, [round(v, 1) for v, _ in mark.values]) for mark in vertical.marks] == [
        ("v_cr2", [72.3, 74.9])
    ]
    assert "critical velocities" in named(study, "acceleration").caption
    assert [limit for panel in panels(named(study, "wheel-forces")) for limit in panel.limits] == []


def test_the_least_force_of_a_wheel_is_there_too(study: Study, file: Path) -> None:
    panel = panels(named(study, "wheel-forces"))[1]
    assert panel.curves[0].y == pytest.approx(table(file, "min/wheel_1_right_force").mean(axis=0))
    unloading = panels(named(study, "contact"))[0]
    assert unloading.curves[0].y == pytest.approx(table(file, "max/wheel_1_right_unloading").mean(axis=0))
    assert unloading.curves[0].y[1] == pytest.approx(1.0)


def test_bands_over_time_are_those_of_the_histories(study: Study, file: Path) -> None:
    """At the base case's speed: of 300 km/h the nearer one, 90 m/s, with the odd flat indices."""
    panel = panels(named(study, "time-car_body_y"))[0]
    with h5py.File(file, locking=False) as results:
        found = [results[f"histories/{2 * seed + 1}"] for seed in range(SEEDS)]
        values = np.array([history["car_body_y"][()] for history in found])
        time = found[0]["time"][()]
    assert np.array_equal(panel.curves[0].x, time)
    assert panel.curves[0].y == pytest.approx(values.mean(axis=0), abs=1e-17)
    assert panel.bands[0].low == pytest.approx(np.percentile(values, 5, axis=0), abs=1e-17)


def test_without_another_axis_the_spread_is_drawn(study: Study, file: Path) -> None:
    (plot,) = [
        p for p in ensemble_figures(study, Wishes(), {"velocity": 0}) if p.name.endswith("displacement")
    ]
    curve = panels(plot)[0].curves[0]
    assert curve.x == pytest.approx(np.sort(table(file, "peak/car_body_y")[:, 0]))
    assert curve.y == pytest.approx((np.arange(SEEDS) + 0.5) / SEEDS)


def test_the_table_of_the_ensemble(study: Study, file: Path) -> None:
    found = ensemble_table(study)
    assert found is not None
    rows = {(row[0], row[2]): row for row in found.rows}
    values = table(file, "peak/right_midspan")
    for k, velocity in enumerate(VELOCITIES):
        row = rows["right_midspan", velocity]
        assert row[1] == "m"
        assert row[3] == SEEDS
        expected = [values[:, k].mean(), values[:, k].std(ddof=1), *np.percentile(values[:, k], [5, 50, 95])]
        assert row[4:9] == pytest.approx(expected, rel=1e-12)
        assert row[9:] == (values[:, k].min(), values[:, k].max())


def test_realisations_that_failed_are_left_out() -> None:
    values = np.array([[1.0, np.nan], [3.0, np.nan], [np.nan, np.nan]])
    found = Statistics.of(values)
    assert found.mean[0] == 2.0
    assert found.deviation[0] == pytest.approx(np.sqrt(2.0))
    assert found.percentiles[1, 0] == 2.0
    assert np.isnan(found.mean[1]) and np.isnan(found.percentiles[:, 1]).all()


def test_lift_off_is_marked_where_the_force_becomes_nothing(study: Study, file: Path) -> None:
    (plot,) = [p for p in contact_figures(study, {"seed": 2, "velocity": 1}) if "wheel-forces" in p.name]
    (panel,) = panels(plot)
    assert [curve.label for curve in panel.curves] == ["axle 1", "axle 2"]
    with h5py.File(file, locking=False) as results:
        history = results[f"histories/{2 * 2 + 1}"]
        time = history["time"][()]
        for points, name in zip(panel.points, ("wheel_1_right_force", "wheel_2_right_force"), strict=True):
            force = history[name][()]
            first = [
                t for t, now, before in zip(time[1:], force[1:], force[:-1], strict=True) if now == 0 < before
            ]
            assert points.x.tolist() == first
            assert first
    assert "Triangles" in plot.caption


def test_the_rails_and_their_spectrum(study: Study) -> None:
    """The mean periodogram of seven seeds beside the density asked for: good to 1/sqrt(7) in each bin."""
    (plot,) = track_figures(study, {})
    rails, spectrum = panels(plot)
    assert [curve.label for curve in rails.curves] == ["right rail", "left rail"]
    assert rails.curves[0].y[[0, -1]] == pytest.approx([0, 0], abs=1e-20)
    assert rails.marks[0].values == ((0.0, ""), (50.0, ""))
    own, asked = spectrum.curves
    ratio = own.y / np.exp(np.interp(np.log(own.x), np.log(asked.x), np.log(asked.y)))
    short = own.x < 30
    assert ratio[short].mean() == pytest.approx(1.0, abs=4 / np.sqrt(7 * short.sum() / 3))
    assert spectrum.x.logarithmic and spectrum.y.logarithmic


def test_bands_in_the_page(study: Study) -> None:
    """Each band is two traces, the upper one filled down to the lower."""
    made = interactive(named(study, "displacement"))
    assert made is not None
    fills = [trace for trace in made["data"] if trace.get("fill") == "tonexty"]
    assert len(fills) == 2 * len(named(study, "displacement").panels)
    assert made["data"][0]["showlegend"] is False


def test_the_report_from_the_command_line(file: Path, tmp_path: Path) -> None:
    ended = tbi("report", str(file), "-o", "out", "--formats", "png", "-q", folder=tmp_path)
    assert ended.code == 0, ended.err
    names = {path.name for path in (tmp_path / "out").glob("*.png")}
    assert {"rough-track.png", "rough-wheel-forces.png", "rough-ensemble-displacement.png"} <= names
    with (tmp_path / "out" / "ensemble-rough.csv").open(newline="") as rows:
        head, first, *_ = csv.reader(rows)
    assert head[:4] == ["channel", "unit", "velocity [m/s]", "realisations"]
    assert first[3] == str(SEEDS)


def test_a_family_of_seeds_on_request(file: Path, tmp_path: Path) -> None:
    """Curves for single seeds, as for any other axis."""
    options = ("--channels", "car_body_y", "--family", "seed", "--formats", "png", "-q")
    ended = tbi("report", str(file), "-o", "out", *options, folder=tmp_path)
    assert ended.code == 0, ended.err
    assert (tmp_path / "out" / "rough-car_body_y.png").exists()
