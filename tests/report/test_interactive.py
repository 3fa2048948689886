"""The interactive plots beside their curves: what the pointer is told, limits, marks, the legend."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tbi_cli.report.interactive import interactive
from tbi_cli.report.marks import ISO_2631
from tbi_cli.report.plot import Axis, Curve, Limit, Mark, Panel, Plot

X = np.geomspace(10.0, 100.0, 30)


def panel(
    labels: tuple[str, ...] = ("one", "two"),
    height: float = 1.0,
    logarithmic: bool = False,
    limits: tuple[Limit, ...] = (),
) -> Panel:
    curves = tuple(Curve(label, X, height * np.sqrt(X / X[-1]), k) for k, label in enumerate(labels))
    return Panel(
        "a panel",
        Axis("train velocity v", "m/s", logarithmic),
        Axis("acceleration", "m/s2"),
        curves,
        marks=(Mark("v_cr2", ((72.0, "right"),)),),
        limits=limits,
    )


def made(*panels: Panel, legend: tuple[str, str] = ("", "")) -> dict[str, Any]:
    found = interactive(Plot("name", "heading", "caption", panels, legend))
    assert found is not None
    return found


def notes(found: dict[str, Any]) -> dict[str, dict[str, Any]]:
    return {note["text"]: note for note in found["layout"]["annotations"]}


def test_the_pointer_is_told_where_it_is() -> None:
    assert made(panel())["layout"]["xaxis"]["unifiedhovertitle"]["text"] == "train velocity v %{x:.6~g} m/s"


@pytest.mark.parametrize("logarithmic", [False, True])
def test_a_mark_and_its_name_stand_at_the_same_place(logarithmic: bool) -> None:
    layout = made(panel(logarithmic=logarithmic))["layout"]
    (line,) = layout["shapes"]
    note = notes({"layout": layout})["<i>v</i><sub>cr,2</sub>"]
    assert line["x0"] == 72.0
    assert note["x"] == pytest.approx(np.log10(72.0) if logarithmic else 72.0)


def test_the_numbers_of_limits_do_not_cover_each_other() -> None:
    assert {"0.49", "0.37"} <= set(notes(made(panel(limits=ISO_2631))))
    assert "0.49<br>0.37" in notes(made(panel(height=8.0, limits=ISO_2631)))
    assert not {"0.49", "0.37", "0.49<br>0.37"} & set(notes(made(panel(height=0.01, limits=ISO_2631))))


def test_limits_hold_in_both_directions() -> None:
    """Also below zero, where the curves go there."""
    swinging = panel(("one",), limits=ISO_2631)
    curve = replace(swinging.curves[0], y=np.sin(X))
    shapes = made(replace(swinging, curves=(curve,)))["layout"]["shapes"]
    assert sorted(line["y0"] for line in shapes if line["y0"] == line["y1"]) == [-0.49, -0.37, 0.37, 0.49]


def test_curves_of_different_panels_are_told_apart() -> None:
    apart = made(panel(), panel(("three", "four")), legend=("damping c", "kN s/m²"))
    assert [trace["name"] for trace in apart["data"]] == ["(a) one", "(a) two", "(b) three", "(b) four"]
    shared = made(panel(), panel())
    assert [trace["name"] for trace in shared["data"]] == ["one", "two"] * 2


def test_the_legend_has_room_for_its_rows() -> None:
    few = made(panel())["layout"]
    many = made(panel(tuple(f"a curve with a long name, {k}" for k in range(12))), legend=("modes n", ""))
    assert many["layout"]["margin"]["b"] > few["margin"]["b"]
    assert many["layout"]["height"] - few["height"] == many["layout"]["margin"]["b"] - few["margin"]["b"]
