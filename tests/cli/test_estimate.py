"""What `tbi validate` says a case would cost: exact for a grid of some size, by lot for one without end."""

from __future__ import annotations

import re

import numpy as np
import pytest

from tbi_cli.case import load_case
from tbi_cli.estimate import estimate


def told(sweep: str) -> dict[str, str]:
    """The lines of an estimate, by their first word."""
    lines = estimate(load_case("paper", overrides=[f"sweep={sweep}", "output.histories=all"]))
    return dict(line.split(maxsplit=1) for line in lines)


def steps(words: str) -> float:
    return float(words.removeprefix("about ").replace(",", ""))


@pytest.mark.parametrize(
    "sweep",
    [
        "{velocity: {from: 50, to: 100, count: 40000}}",
        "{car_body_mass: {from: 30 t, to: 50 t, count: 30}, velocity: {from: 50, to: 100, count: 40}}",
    ],
    ids=["many speeds", "many models"],
)
def test_a_large_grid_costs_what_its_parts_do(sweep: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """A thousand strata of the speeds have little room for chance; twenty in a grid of two axes have more."""
    monkeypatch.setattr("tbi_cli.estimate._MOST_SCENARIOS", 1000)
    monkeypatch.setattr("tbi_cli.estimate._MOST_VEHICLES", 20)
    drawn = told(sweep)
    monkeypatch.setattr("tbi_cli.estimate._MOST_SCENARIOS", 100_000)
    monkeypatch.setattr("tbi_cli.estimate._MOST_VEHICLES", 100_000)
    counted = told(sweep)
    assert drawn["steps"].startswith("about ") and not counted["steps"].startswith("about ")
    assert drawn["histories"].startswith("about ")
    assert steps(drawn["steps"]) == pytest.approx(
        steps(counted["steps"]), rel=0.02 if "40000" in sweep else 0.2
    )
    assert drawn["scenarios"] == counted["scenarios"]


def test_studies_share_what_is_looked_at(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tbi_cli.estimate._MOST_SCENARIOS", 10)
    studies = "studies={a: {sweep: {velocity: {from: 50, to: 60, count: 40}}}, b: {velocity: 50}}"
    lines = estimate(load_case("paper", overrides=[studies]))
    assert "scenarios  41" in lines
    assert any(line.startswith("steps      about ") for line in lines)


def test_the_time_is_that_of_all_steps_of_all_coordinates(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pinned: 7 ns of a processor for a step of a coordinate, shared by all processors."""
    monkeypatch.setattr("tbi_cli.estimate.available_cpus", lambda: 3)
    first = "sweep: {velocity: {from: 10, to: 60, count: 3000}}"
    second = "sweep: {velocity: {from: 20, to: 30, count: 2000}}, bridge: {modes: 7}"
    studies = f"studies={{a: {{{first}}}, b: {{{second}}}}}"
    lines = dict(
        line.split(maxsplit=1)
        for line in estimate(load_case("paper", overrides=[studies, "solver.sampling=0.0001"]))
    )
    seconds = 0.0
    for speeds, modes in ((np.linspace(10, 60, 3000), 4), (np.linspace(20, 30, 2000), 7)):
        # Five crossing times of 50 m and 20 m between the outer axles, in steps of 0.1 ms.
        seconds += float(np.sum(5 * 70 / speeds / 1e-4)) * (27 + 2 * modes) * 7e-9 / 3
    found = re.fullmatch(r"about (\d+) s on 3 CPUs", lines["time"])
    assert found and seconds > 10
    assert int(found[1]) == pytest.approx(seconds, abs=0.51)
