"""Any study, and what can be asked of it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import h5py
import numpy as np
import pytest

from tbi_cli.report.draw import draw
from tbi_cli.report.errors import ReportError
from tbi_cli.report.generic_figures import generic_figures
from tbi_cli.report.plot import HeatPanel, Panel, Plot
from tbi_cli.report.study import Study, open_studies
from tbi_cli.report.style import in_style
from tbi_cli.report.wishes import Wishes
from tests.cli.commands import tbi

AXES = (
    "--set=sweep.train.secondary.vertical.stiffness=[130 kN/m, 260 kN/m, 520 kN/m]",
    "--set=sweep.span=[30, 50]",
)


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("study")
    speeds = ("--from", "40", "--to", "120", "--step", "10")
    ended = tbi("sweep", "velocity", "paper", *speeds, *AXES, "-q", "-o", "stiffness.h5", folder=folder)
    assert ended.code == 0, ended.err
    return folder / "stiffness.h5"


@pytest.fixture
def study(file: Path) -> Iterator[Study]:
    (opened,) = open_studies([file])
    yield opened
    opened.results.close()


def drawn(study: Study, **asked: object) -> dict[str, Plot]:
    wishes = Wishes(**asked)  # type: ignore[arg-type]
    wishes.check([study])
    select = wishes.selection([study])[study.name]
    return {plot.name: plot for plot in generic_figures(study, wishes, select)}


def test_curves_over_the_last_axis_a_family_and_small_multiples(study: Study, file: Path) -> None:
    plot = drawn(study)["stiffness-displacement-car_body_y"]
    assert plot.legend == ("span L", "m")
    titles = [panel.title.replace("\N{NO-BREAK SPACE}", " ") for panel in plot.panels]
    assert titles == [f"secondary vertical stiffness k = {k} kN/m" for k in (130, 260, 520)]
    with h5py.File(file, locking=False) as opened:
        peak = opened["peak/car_body_y"][...]
    for i, panel in enumerate(plot.panels):
        assert isinstance(panel, Panel)
        assert panel.x.label == "train velocity v"
        for j, curve in enumerate(panel.curves):
            np.testing.assert_array_equal(curve.y, peak[i, j, :])


def test_x_family_and_select(study: Study, file: Path) -> None:
    plots = drawn(
        study,
        channels=("rms/right_midspan",),
        x="train.secondary.vertical.stiffness",
        family="velocity",
        select=("span=50 m",),
    )
    (panel,) = plots["stiffness-rms-right_midspan"].panels
    assert isinstance(panel, Panel)
    assert panel.y.label == "RMS of mid-span deflection"
    with h5py.File(file, locking=False) as opened:
        rms = opened["rms/right_midspan"][:, 1, :]
    assert len(panel.curves) == 8  # of nine speeds, first and last among them
    np.testing.assert_array_equal(panel.curves[0].y, rms[:, 0])
    np.testing.assert_array_equal(panel.curves[-1].y, rms[:, -1])


def test_heat_maps_hold_the_table_and_the_critical_velocities(study: Study, file: Path) -> None:
    plots = drawn(
        study, channels=("left_midspan",), heat_map=True, select=("train_secondary_vertical_stiffness=260e3",)
    )
    (panel,) = plots["stiffness-heat-left_midspan"].panels
    assert isinstance(panel, HeatPanel)
    with h5py.File(file, locking=False) as opened:
        np.testing.assert_array_equal(panel.values, opened["peak/left_midspan"][1, :, :])
    first = panel.lines[0]
    # Table 5: 52.03 m/s at 30 m and 18.73 m/s at 50 m, printed with two decimals.
    assert first.x == pytest.approx([52.03, 18.73], abs=1e-2)
    assert first.y.tolist() == [30.0, 50.0]
    assert [line.label for line in panel.lines] == [f"v_cr{mode} left" for mode in range(1, 5)]
    with in_style():
        axes = draw(plots["stiffness-heat-left_midspan"]).axes[0]
    # At 50 m only the second, 74.93 m/s, is among the speeds.
    assert [text.get_text() for text in axes.texts] == [r"$v_{\mathrm{cr},2}$"]


def test_patterns_name_channels(study: Study) -> None:
    names = set(drawn(study, channels=("wheel_1_*_force", "daf/*"), select=("span=50", "velocity=80")))
    wheels = {f"stiffness-wheel_1_{side}_force" for side in ("right", "left")}
    assert names == wheels | {
        f"stiffness-daf-{name}" for name in ("right", "left", "right_static", "left_static")
    }


@pytest.mark.parametrize(
    ("asked", "message"),
    [
        (
            {"x": "mass"},
            "--x: no axis mass; expected one of: span, train_secondary_vertical_stiffness, velocity, time",
        ),
        ({"family": "mass"}, "--family: no axis mass; expected one of: span, "),
        ({"channels": ("car_body_x",)}, "--channels: no channel car_body_x; did you mean car_body_"),
        ({"select": ("span",)}, "--select span: expected AXIS=VALUE"),
        ({"select": ("mass=1",)}, "--select mass=1: no axis mass"),
        (
            {"select": ("span=41",)},
            r"not a value of the axis span \(2 values, 30 to 50 m\); the nearest is 50",
        ),
        ({"select": ("span=40 t",)}, 'expected a number in m, "t" is a mass'),
        ({"formats": ("gif",)}, "--formats: expected some of png, pdf, svg, got gif"),
    ],
)
def test_wishes_that_cannot_be_met(study: Study, asked: dict[str, object], message: str) -> None:
    with pytest.raises(ReportError, match=message):
        drawn(study, **asked)


def test_the_command_line_draws_what_is_asked_instead_of_the_papers_figures(
    file: Path, tmp_path: Path
) -> None:
    ended = tbi(
        *("report", str(file), "-o", "out", "--channels", "car_body_y,daf/right", "--x", "velocity"),
        *("--family", "none", "--formats", "svg"),
        folder=tmp_path,
    )
    assert ended.code == 0, ended.err
    assert {path.name for path in (tmp_path / "out").glob("*.svg")} == {
        "stiffness-car_body_y.svg",
        "stiffness-daf-right.svg",
    }
    assert "missing" not in ended.out


def test_by_default_a_study_of_ones_own_has_its_figures_beside_the_papers(file: Path, tmp_path: Path) -> None:
    ended = tbi("report", str(file), "-o", "out", "--formats", "png", folder=tmp_path)
    assert ended.code == 0, ended.err
    names = {path.stem for path in (tmp_path / "out").glob("*.png")}
    assert {
        "fig15",
        "fig16",
        "fig17",
        "fig22",
        "fig25",
        "stiffness-acceleration-car_body_y_acceleration",
    } <= names
    assert "missing: Figs. 19-21: tbi run paper/velocity-masses" in ended.out
