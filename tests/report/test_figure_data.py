"""The arrays behind every curve are the numbers of the file, read here with h5py and nothing of ours."""

from __future__ import annotations

import base64
from pathlib import Path

import h5py
import numpy as np
import pytest

from tbi_cli.report import words
from tbi_cli.report.catalogue import FigureSpec, catalogue
from tbi_cli.report.draw import draw
from tbi_cli.report.interactive import interactive
from tbi_cli.report.paper_figures import paper_figure
from tbi_cli.report.plot import Panel, Plot
from tbi_cli.report.study import Study, open_studies
from tbi_cli.report.style import in_style

# The base values of the axes that a figure does not show, where the campaign sweeps them.
ROW = {"velocity-masses": 1, "velocity-spans": 2, "velocity-damping": 2}


def figure(number: int, studies: list[Study]) -> Plot:
    found = paper_figure(next(s for s in catalogue() if s.number == number), studies, {})
    assert found is not None
    return found[0]


def panels(plot: Plot) -> list[Panel]:
    return [panel for panel in plot.panels if isinstance(panel, Panel)]


def expected(spec: FigureSpec, folder: Path) -> list[list[tuple[np.ndarray, np.ndarray]]]:
    """The curves (x, y) of every panel of a figure, from the file of its own study."""
    found = []
    for panel in spec.panels:
        curves = []
        for run in panel.runs:
            with h5py.File(folder / f"{run.case.removeprefix('paper/')}.h5", locking=False) as file:
                curves.append((file["histories/0/time"][:], file[f"histories/0/{run.channel}"][:]))
        if panel.channels:
            with h5py.File(folder / f"{spec.case.removeprefix('paper/')}.h5", locking=False) as file:
                for channel in panel.channels:
                    if panel.table == "history":
                        first = {6: 0, 7: 4}.get(
                            spec.number, 0
                        )  # 50 and 300 km/h, four sampling intervals each
                        count = {"modes": 8, "sampling": 4, "car_body_mass": 4}.get(spec.family or "", 1)
                        for index in range(first, first + count):
                            group = file[f"histories/{index}"]
                            curves.append((group["time"][:], group[channel][:]))
                    else:
                        rows = file[panel.table][channel][...]
                        for row in np.atleast_2d(rows):
                            curves.append((file["velocity"][:], row))
        found.append(curves)
    return found


@pytest.mark.parametrize("spec", catalogue(), ids=lambda spec: spec.name)
def test_curves_are_the_tables_of_the_file(spec: FigureSpec, campaign: Path, studies: list[Study]) -> None:
    # Of two studies with the same histories the first file is taken; for these figures that is another run of
    # the same crossing, equal to the last bit.
    plot = figure(spec.number, studies)
    wanted = expected(spec, campaign)
    assert len(plot.panels) == len(wanted)
    for panel, curves in zip(panels(plot), wanted, strict=True):
        assert len(panel.curves) == len(curves)
        for curve, (x, y) in zip(panel.curves, curves, strict=True):
            np.testing.assert_array_equal(curve.x, x)
            np.testing.assert_array_equal(curve.y, y)


@pytest.mark.parametrize("name", sorted(ROW))
def test_figs_15_to_17_from_any_velocity_sweep_at_its_base_case(campaign: Path, name: str) -> None:
    (study,) = open_studies([campaign / f"{name}.h5"])
    with h5py.File(campaign / f"{name}.h5", locking=False) as file:
        for number, channel in (
            (15, "rear_bogie_z"),
            (16, "car_body_pitch"),
            (17, "car_body_y_acceleration"),
        ):
            curves = {c.y.tobytes() for panel in panels(figure(number, [study])) for c in panel.curves}
            assert file["peak"][channel][ROW[name], :].tobytes() in curves
    study.results.close()


def test_labels_say_the_values_of_the_family(studies: list[Study]) -> None:
    masses = figure(19, studies)
    assert masses.legend == ("car body mass m_c", "t")
    assert [curve.label for curve in panels(masses)[0].curves] == ["20", "40", "60", "80"]
    # c / (2 mu omega_1), the paper's 0.47, 2.36 and 4.72 %, which belong to the left beam.
    damping = panels(figure(18, studies))[1]
    assert [curve.label for curve in damping.curves] == [
        "1 (ζ₁ = 0.47 %)",
        "5 (ζ₁ = 2.36 %)",
        "10 (ζ₁ = 4.72 %)",
    ]


def test_critical_velocities_are_those_of_the_papers_tables(studies: list[Study]) -> None:
    spans = panels(figure(25, studies))[1]
    found = {(mark.place, mark.label): [round(v, 1) for v, _ in mark.values] for mark in spans.marks}
    # Table 5, to its two decimals less one: its own are rounded from a rounded frequency.
    assert found[(0, "v_cr1")] == [52.0]
    assert [found[(1, f"v_cr{j}")] for j in (1, 2)] == [[29.3], [117.1]]
    assert [found[(2, f"v_cr{j}")] for j in (1, 2, 3)] == [[18.7], [74.9], [168.6]]
    assert [found[(3, f"v_cr{j}")] for j in (1, 2, 3)] == [[13.0], [52.0], [117.1]]
    both = panels(figure(15, studies))[0].marks
    assert [[side for _, side in mark.values] for mark in both] == [["right", "left"]] * 3


def test_the_exit_and_the_comfort_limits_are_marked(studies: list[Study]) -> None:
    for number in (8, 9, 10, 11, 12, 13, 14, 26):
        for panel in panels(figure(number, studies)):
            ((mark,),) = ([mark.values for mark in panel.marks],)
            assert mark == ((pytest.approx(0.84), ""),)  # 70 m at 300 km/h
    for number in (5, 6, 7, 10, 13, 17, 21, 24):
        limits = [
            panel.limits for panel in panels(figure(number, studies)) if "acceleration" in panel.y.label
        ]
        assert limits and all([limit.value for limit in found] == [0.37, 0.49] for found in limits)


@pytest.mark.parametrize("number", [4, 7, 11, 18, 22, 28])
def test_what_is_drawn_is_the_data_in_the_units_of_the_axis(number: int, studies: list[Study]) -> None:
    plot = figure(number, studies)
    with in_style():
        drawn = draw(plot)
    for axes, panel in zip(drawn.axes, panels(plot), strict=False):
        lines = [line for line in axes.get_lines() if not str(line.get_label()).startswith("_")]
        largest = max(float(np.abs(curve.y).max()) for curve in panel.curves)
        factor = words.scale(panel.y.units, largest).factor
        assert f"[{words.scale(panel.y.units, largest).unit}]" in axes.get_ylabel() or panel.y.units == "1"
        for line, curve in zip(lines, panel.curves, strict=True):
            np.testing.assert_array_equal(line.get_ydata(), curve.y / factor)
            np.testing.assert_array_equal(line.get_xdata(), curve.x)


@pytest.mark.parametrize("number", [15, 21, 27])
def test_the_interactive_plots_hold_the_same_numbers(number: int, studies: list[Study]) -> None:
    plot = figure(number, studies)
    lively = interactive(plot)
    assert lively is not None
    curves = [(panel, curve) for panel in panels(plot) for curve in panel.curves]
    for trace, (panel, curve) in zip(lively["data"], curves, strict=True):
        factor = words.scale(panel.y.units, max(float(np.abs(c.y).max()) for c in panel.curves)).factor
        packed = np.frombuffer(base64.b64decode(trace["y"]["bdata"]), dtype="<f8")
        np.testing.assert_array_equal(packed, curve.y / factor)


def test_figures_over_time_are_pictures_only(studies: list[Study]) -> None:
    assert interactive(figure(8, studies)) is None
