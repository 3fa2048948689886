"""The deck over speed, resonances, envelopes and stations: the arrays behind them are those of the file."""

from __future__ import annotations

import base64
import math
from collections.abc import Iterator
from pathlib import Path

import h5py
import numpy as np
import pytest

from tbi_cli.case import load_case
from tbi_cli.report import marks
from tbi_cli.report.bridge_figures import bridge_figures
from tbi_cli.report.draw import draw
from tbi_cli.report.envelopes import envelope_figures
from tbi_cli.report.interactive import interactive
from tbi_cli.report.missing import gaps
from tbi_cli.report.paper_figures import held_at
from tbi_cli.report.plot import Array, Panel, Plot
from tbi_cli.report.resonance import peaks, resonance_table
from tbi_cli.report.study import Study, open_studies
from tbi_cli.report.style import in_style
from tbi_cli.runner import Options, run
from tbi_cli.shards import Shard

SPANS, MOMENTS, TRAINS = (15.0, 30.0), (0.563, 2.25), (1, 10)
SPEEDS = tuple(float(v) for v in range(60, 112, 2))
QUANTITIES = ("deflection", "acceleration_low_pass", "moment", "shear")


def solved(folder: Path, case: str, *overrides: str, shard: Shard | None = None) -> Path:
    path = folder / f"{case.rpartition('/')[2]}.h5"
    run(load_case(case, overrides=list(overrides)), Options(output=path, shard=shard))
    return path


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("bridges")


@pytest.fixture(scope="module")
def hslm(folder: Path) -> Path:
    """Two of the ten trains on two spans."""
    axes = f"train.number: {list(TRAINS)}, span: {list(SPANS)}, bridge.right.second_moment: {list(MOMENTS)}"
    zipped = "zip: [span, bridge.right.second_moment]"
    return solved(
        folder, "practice/hslm-a", f"sweep={{{axes}, {zipped}, velocity: {{from: 60, to: 110, step: 2}}}}"
    )


@pytest.fixture(scope="module")
def cars(folder: Path) -> Path:
    """Eight cars at two speeds on beams that differ."""
    return solved(
        folder, "practice/eight-cars", "sweep={velocity: [60, 90]}", "bridge.left.second_moment=2.2"
    )


def opened(path: Path) -> Iterator[Study]:
    (study,) = open_studies([path])
    yield study
    study.results.close()


@pytest.fixture
def trains(hslm: Path) -> Iterator[Study]:
    yield from opened(hslm)


@pytest.fixture
def consist(cars: Path) -> Iterator[Study]:
    yield from opened(cars)


def panels(plot: Plot) -> list[Panel]:
    return [panel for panel in plot.panels if isinstance(panel, Panel)]


def figures(study: Study) -> dict[str, Plot]:
    return {plot.name.removeprefix(f"{study.name}-"): plot for plot in bridge_figures(study, {})}


def table(path: Path, name: str) -> Array:
    with h5py.File(path, locking=False) as file:
        values: Array = file[name][()]
        return values


def resonant(train: int, span: int, mode: int, part: int) -> float:
    """v = f_j D/i by hand, for the concrete decks of the case; D of A1 and A10 is 18 and 27 m."""
    frequency = mode**2 * math.pi / (2 * SPANS[span] ** 2) * math.sqrt(35e9 * MOMENTS[span] / 15e3)
    return frequency * {1: 18.0, 10: 27.0}[train] / part


def test_a_curve_for_each_train_and_a_panel_for_each_span(trains: Study, hslm: Path) -> None:
    found = figures(trains)
    assert list(found) == [
        "deck-acceleration", "deck-deflection", "resonance-acceleration", "resonance-deflection"
    ]  # fmt: skip
    for quantity, channel in (
        ("deflection", "right_midspan"),
        ("acceleration", "right_midspan_acceleration_low_pass"),
    ):
        values = table(hslm, f"peak/{channel}")
        plot = found[f"deck-{quantity}"]
        assert plot.legend == ("train HSLM-A", "")
        assert [p.title.replace("\N{NO-BREAK SPACE}", " ") for p in panels(plot)] == [
            "span L = 15 m",
            "span L = 30 m",
        ]
        for span, panel in enumerate(panels(plot)):
            assert [curve.label for curve in panel.curves] == ["A1", "A10"]
            for train, curve in enumerate(panel.curves):
                assert curve.x.tolist() == list(SPEEDS)
                np.testing.assert_array_equal(curve.y, values[train, span])


def test_limits_of_the_deck_stand_at_its_acceleration_alone(trains: Study) -> None:
    found = figures(trains)
    for panel in panels(found["deck-acceleration"]):
        assert [limit.value for limit in panel.limits] == [3.5, 5.0]
    assert not any(panel.limits for panel in panels(found["deck-deflection"]))
    assert "EN 1990" in found["deck-acceleration"].caption
    assert "ISO 2631" not in found["deck-acceleration"].caption
    lively = interactive(found["deck-acceleration"])
    assert lively is not None
    lines = [shape["y0"] for shape in lively["layout"]["shapes"] if shape["yref"] == "y"]
    assert lines == [3.5, 5.0]


def test_resonance_is_marked_where_theory_has_it(trains: Study) -> None:
    """On the first span, panel by panel; modes of even number do not move mid-span."""
    for panel, train in zip(panels(figures(trains)["resonance-deflection"]), TRAINS, strict=True):
        assert panel.title == f"HSLM-A{train}"
        found = {mark.label.removeprefix(marks.RESONANCE): mark.values for mark in panel.marks}
        wanted = {f"{mode},{part}": resonant(train, 0, mode, part) for mode in (1, 3) for part in range(1, 7)}
        wanted = {key: speed for key, speed in wanted.items() if 60 <= speed <= 110}
        assert {key: speed for key, ((speed, _),) in found.items()} == pytest.approx(wanted, rel=1e-12)


def test_circles_are_at_local_maxima_of_their_curve(trains: Study) -> None:
    count = 0
    for name in ("resonance-deflection", "resonance-acceleration"):
        for panel in panels(figures(trains)[name]):
            (curve,) = panel.curves
            for points in panel.points:
                at = np.searchsorted(curve.x, points.x)
                np.testing.assert_array_equal(curve.y[at], points.y)
                assert np.all(curve.y[at] > curve.y[at - 1]) and np.all(curve.y[at] > curve.y[at + 1])
                count += len(at)
    assert count >= 4


def test_peaks_are_what_stands_out() -> None:
    x = np.linspace(0, 10, 201)
    humps = np.exp(-((x - 3) ** 2)) + 0.5 * np.exp(-((x - 7) ** 2)) + 0.002 * np.cos(40 * x)
    humps[100] = np.nan
    assert x[peaks(humps)] == pytest.approx([3, 7], abs=0.11)
    assert len(peaks(np.full(5, np.nan))) == 0


def test_the_table_sets_what_is_found_beside_what_is_expected(trains: Study, hslm: Path) -> None:
    found = resonance_table(trains, {})
    assert found is not None
    assert found.columns[:6] == ("train_number", "span [m]", "beam", "mode j", "part i", "expected [m/s]")
    rows = {(row[0], row[1], row[3], row[4]): row for row in found.rows}
    for train, number in enumerate(TRAINS):
        for span, length in enumerate(SPANS):
            wanted = {
                (number, length, mode, part)
                for mode in (1, 3)
                for part in range(1, 7)
                if 60 <= resonant(number, span, mode, part) <= 110
            }
            assert {key for key in rows if key[:2] == (number, length)} == wanted
            values = table(hslm, "peak/right_midspan")[train, span]
            largest = SPEEDS[int(np.argmax(values))]
            for key in wanted:
                row = rows[key]
                assert row[5] == pytest.approx(resonant(number, span, int(key[2]), int(key[3])), rel=1e-12)
                if abs(largest - float(row[5] or 0)) < 1 and largest < 110:
                    assert row[6] == largest
                    assert row[7] == pytest.approx(largest - float(row[5] or 0), rel=1e-9)
    # The tenth train at 30 m: 1,1 lies at 108 m/s, a speed of the sweep.
    assert rows[10, 30.0, 1, 1][6] == 108.0


def test_a_peak_belongs_to_one_expected_speed(trains: Study) -> None:
    found = resonance_table(trains, {})
    assert found is not None
    for column in (6, 8):
        known = [(row[0], row[1], row[column]) for row in found.rows if row[column] is not None]
        assert known and len(known) == len(set(known))


def test_one_train_has_its_resonances_in_the_figure_of_the_deck(consist: Study, cars: Path) -> None:
    deck = figures(consist)["deck"]
    for panel, channel in zip(panels(deck), ("midspan", "midspan_acceleration_low_pass"), strict=True):
        assert [curve.label for curve in panel.curves] == ["right beam", "left beam"]
        for curve, side in zip(panel.curves, ("right", "left"), strict=True):
            np.testing.assert_array_equal(curve.y, table(cars, f"peak/{side}_{channel}"))
        # Six cars of 24.775 m: mode 1, half its frequency, of both beams.
        (mark,) = [mark for mark in panel.marks if mark.label.endswith("1,2")]
        speeds = [
            math.pi / (2 * 30**2) * math.sqrt(34e9 * inertia / 8e3) * 24.775 / 2 for inertia in (2.5, 2.2)
        ]
        assert mark.values == (
            (pytest.approx(speeds[0], rel=1e-12), "right"),
            (pytest.approx(speeds[1], rel=1e-12), "left"),
        )


def test_envelopes_are_the_extremes_of_all_speeds(consist: Study, cars: Path) -> None:
    (plot,) = envelope_figures(consist, {})
    for panel, quantity in zip(panels(plot), QUANTITIES, strict=True):
        curves = iter(panel.curves)
        for side in ("right", "left"):
            for name, over in (("max", np.max), ("min", np.min)):
                curve = next(curves)
                assert curve.x == pytest.approx(np.linspace(0, 30, 9))
                wanted = [over(table(cars, f"{name}/{side}_station_{k}_{quantity}")) for k in range(1, 10)]
                np.testing.assert_array_equal(curve.y, wanted)
    assert "60 to 90 m/s" in plot.caption


def test_envelopes_at_the_speed_that_is_selected(consist: Study, cars: Path) -> None:
    (plot,) = envelope_figures(consist, {"velocity": 1})
    moment = panels(plot)[2].curves[0]
    wanted = [table(cars, f"max/right_station_{k}_moment")[1] for k in range(1, 10)]
    np.testing.assert_array_equal(moment.y, wanted)
    assert "90" in plot.caption and "60 to 90" not in plot.caption


def test_equal_beams_share_their_curves(tmp_path: Path) -> None:
    path = solved(tmp_path, "practice/eight-cars", "sweep={velocity: [50]}")
    for study in opened(path):
        (plot,) = envelope_figures(study, {})
        for panel in panels(plot):
            assert [curve.label for curve in panel.curves] == ["largest, both beams", "smallest, both beams"]


def test_stations_in_time_are_the_histories(folder: Path) -> None:
    path = solved(folder, "practice/axle-forces")
    for study in opened(path):
        moment, shear = panels(figures(study)["time-stations"])
        assert (moment.title, shear.title) == (
            "bending moment at 10\N{NO-BREAK SPACE}m",
            "shear force at 0\N{NO-BREAK SPACE}m",
        )
        for panel, channel in ((moment, "right_station_3_moment"), (shear, "right_station_1_shear")):
            np.testing.assert_array_equal(panel.curves[0].y, table(path, f"histories/0/{channel}"))
            np.testing.assert_array_equal(panel.curves[0].x, table(path, "histories/0/time"))


def test_a_refined_sweep_that_is_not_finished_has_no_gaps(folder: Path) -> None:
    """Half of the steps of a refined axis: the file has the speeds that were solved, and so have curves."""
    half = Shard(1, 2)
    path = solved(folder, "practice/resonance", "sweep.velocity.from=88", shard=half)
    for study in opened(path):
        values = table(path, "peak/right_midspan")
        known = np.isfinite(values)
        assert 3 < known.sum() == known.size
        curve = panels(figures(study)["deck"])[0].curves[0]
        np.testing.assert_array_equal(curve.x, table(path, "velocity")[known])
        np.testing.assert_array_equal(curve.y, values[known])
        assert f"not finished, {known.sum()} scenarios are solved" in gaps([study])[0]


def test_a_train_of_which_nothing_is_solved_yet_is_drawn_as_nothing(tmp_path: Path) -> None:
    """An unfinished file made from a finished one: the second train's scenarios are still to do."""
    sweep = "sweep={train.number: [4, 7], velocity: {from: 90, to: 102, step: 4, refine: resonance}}"
    path = solved(
        tmp_path, "practice/resonance", "train={model: hslm-a, number: 4}", sweep, shard=Shard(1, 2)
    )
    with h5py.File(path, "r+", locking=False) as file:
        file["status"][1] = 0
        for name in ("peak", "max", "min", "rms", "time_of_peak", "daf"):
            for channel in file[name].values():
                if channel.ndim == 2:
                    channel[1] = np.nan
    for study in opened(path):
        first, second = panels(figures(study)["deck"])[0].curves
        assert np.isfinite(first.y).all() and len(first.y)
        assert np.isnan(second.y).all()
        with in_style():
            draw(figures(study)["deck"])
        assert interactive(figures(study)["deck"]) is not None


def test_a_zipped_axis_is_called_by_its_first_member(trains: Study) -> None:
    axis = trains.axes[1]
    assert held_at(axis, 1).replace("\N{NO-BREAK SPACE}", " ") == "span L = 30 m"


def test_ten_curves_are_told_apart_without_colour(trains: Study) -> None:
    from tbi_cli.report import style

    assert len({style.dashes(place) for place in range(10)}) == 10
    assert len({(style.colour(place), style.dashes(place)) for place in range(40)}) == 40


@pytest.mark.parametrize("name", ["deck-acceleration", "resonance-deflection"])
def test_pictures_and_plots_hold_the_same_numbers(trains: Study, name: str) -> None:
    plot = figures(trains)[name]
    with in_style():
        drawn = draw(plot)
    lively = interactive(plot)
    assert lively is not None
    traces = iter(lively["data"])
    for axes, panel in zip(drawn.axes, panels(plot), strict=False):
        lines = [line for line in axes.get_lines() if not str(line.get_label()).startswith("_")]
        dots = [line for line in axes.get_lines() if line.get_label() == f"_{marks.PEAK}"]
        shown = [*zip(panel.curves, lines, strict=True), *zip(panel.points, dots, strict=True)]
        factor = 1e-3 if panel.y.units == "m" else 1.0
        for data, line in shown:
            np.testing.assert_array_equal(line.get_ydata(), data.y / factor)
            packed = np.frombuffer(base64.b64decode(next(traces)["y"]["bdata"]), dtype="<f8")
            np.testing.assert_array_equal(packed, data.y / factor)


def test_the_papers_studies_have_none_of_these(folder: Path) -> None:
    path = solved(folder, "paper", "sweep={velocity: [60, 90]}", "solver.duration=1")
    for study in opened(path):
        assert figures(study) == {}
        assert not list(envelope_figures(study, {}))
        assert resonance_table(study, {}) is None
