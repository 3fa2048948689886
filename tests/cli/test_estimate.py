"""What `tbi validate` says a case would cost: exact for a grid of some size, by lot for one without end."""

from __future__ import annotations

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
