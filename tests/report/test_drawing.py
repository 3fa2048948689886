"""Figures as they are drawn: nothing is cut off, and a picture alone says what its lines are."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tbi_cli.report.draw import draw
from tbi_cli.report.marks import ISO_2631, LIFT_OFF
from tbi_cli.report.plot import Axis, Curve, Limit, Mark, Panel, Plot, Points
from tbi_cli.report.style import in_style

X = np.linspace(0.0, 200.0, 50)
VELOCITY = Axis("train velocity v", "m/s")
BOTH_BEAMS = (Mark("v_cr1", ((72.0, "right"), (75.0, "left"))),)


def panel(
    curves: int = 3,
    height: float = 1.0,
    marks: tuple[Mark, ...] = (),
    limits: tuple[Limit, ...] = (),
    points: tuple[Points, ...] = (),
    title: str = "a panel",
    from_zero: bool = False,
) -> Panel:
    drawn = tuple(
        Curve(f"{k}00", X, height * (1 + 0.2 * np.sin(0.02 * (k + 1) * X)), k) for k in range(curves)
    )
    return Panel(
        title, VELOCITY, Axis("acceleration", "m/s2"), drawn, marks, (), points, limits, from_zero=from_zero
    )


def drawn(*panels: Panel, legend: tuple[str, str] = ("", "")) -> Figure:
    with in_style():
        figure = draw(Plot("name", "heading", "caption", panels, legend))
        figure.draw_without_rendering()
    return figure


def legend_texts(figure: Figure) -> list[str]:
    legends = [*figure.legends, *(a.get_legend() for a in figure.axes if a.get_legend() is not None)]
    return [text.get_text() for legend in legends for text in legend.get_texts()]


def notes(figure: Figure) -> list[str]:
    return [text.get_text() for axes in figure.axes for text in axes.texts]


@pytest.mark.parametrize("count", [1, 2, 4])
@pytest.mark.parametrize("curves", [1, 3, 5, 8])
def test_the_legend_stays_within_the_figure(count: int, curves: int) -> None:
    figure = drawn(
        *[panel(curves, marks=BOTH_BEAMS)] * count, legend=("secondary vertical stiffness k", "kN/m")
    )
    (legend,) = figure.legends
    extent, page = legend.get_window_extent(), figure.bbox
    assert page.x0 <= extent.x0 < extent.x1 <= page.x1
    assert page.y0 <= extent.y0 < extent.y1 <= page.y1
    assert len(legend.get_texts()) == curves + 2


def test_a_picture_alone_tells_the_beams_lines_apart() -> None:
    keys = [r"$v_\mathrm{cr}$, right beam", r"$v_\mathrm{cr}$, left beam"]
    assert legend_texts(drawn(panel(2, marks=BOTH_BEAMS))) == ["000", "100", *keys]
    # A curve alone needs no name, the lines do; the lines of one beam are those of the panel's title.
    assert legend_texts(drawn(panel(1, marks=BOTH_BEAMS))) == keys
    assert legend_texts(drawn(panel(1, marks=(Mark("v_cr1", ((72.0, "right"),)),)))) == []


def test_a_picture_alone_tells_what_its_points_are() -> None:
    found = Points(LIFT_OFF, X[3:5], np.zeros(2), 0)
    figure = drawn(panel(2, points=(found,)), panel(2))
    assert legend_texts(figure) == ["000", "100", LIFT_OFF]
    assert figure.legends[0].get_lines()[-1].get_marker() == "v"


def test_limits_out_of_sight_are_told_with_their_unit() -> None:
    # The axis is in mm/s2, the limits are not.
    assert "ISO 2631: 0.37, 0.49 m/s² far above" in notes(drawn(panel(height=0.001, limits=ISO_2631)))
    assert {"0.37", "0.49", "ISO 2631"} <= set(notes(drawn(panel(height=0.6, limits=ISO_2631))))


def test_limits_hold_in_both_directions() -> None:
    """Also below zero, where the curves go there."""
    swinging = panel(curves=1, limits=ISO_2631, from_zero=True)
    (above,) = drawn(swinging).axes
    curve = replace(swinging.curves[0], y=np.sin(X))
    (both,) = drawn(replace(swinging, curves=(curve,), from_zero=False)).axes

    def levels(axes: Axes) -> list[float]:
        return sorted(line.get_ydata()[0] for line in axes.get_lines() if len(line.get_ydata()) == 2)

    assert levels(above) == [0.37, 0.49]
    assert levels(both) == [-0.49, -0.37, 0.37, 0.49]


@pytest.mark.parametrize("height", [1e-6, 1.0])
def test_curves_from_zero_keep_clear_of_the_upper_edge(height: float) -> None:
    shown = panel(height=height, from_zero=True)
    (axes,) = drawn(shown).axes
    highest = max(float(line.get_ydata().max()) for line in axes.get_lines()[:3])
    low, high = axes.get_ylim()
    assert low == 0
    assert 1.03 * highest < high < 1.1 * highest


def test_a_number_keeps_to_the_word_before_it() -> None:
    title = "time aloft of the right wheel of axle 1"
    figure = drawn(panel(title=title), panel(title=title))
    lines = figure.axes[0].get_title(loc="left").splitlines()
    assert lines[-1] == "axle\N{NO-BREAK SPACE}1"


@pytest.mark.parametrize(("height", "plain"), [(1.0, True), (1e8, False)])
def test_only_powers_of_ten_are_set_as_mathematics(height: float, plain: bool) -> None:
    (axes,) = drawn(panel(height=height)).axes
    ticks = [label.get_text() for label in axes.get_yticklabels()]
    assert all("$" not in text for text in ticks) is plain
    assert bool(axes.yaxis.get_offset_text().get_text()) is not plain
