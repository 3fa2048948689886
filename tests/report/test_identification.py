"""scripts/identify_table1.py: known parameters are found again, bounds hold, claims weigh as printed."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tbi_cli.case import load_case
from tbi_cli.report.catalogue import data_file
from tbi_cli.scenarios import Scenarios
from tbi_cli.solve import Solver
from tbi_cli.system.bridge import natural_frequencies

sys.path.insert(0, str(Path(__file__).parents[2] / "scripts"))

from identification.parameters import PARAMETERS, PUBLISHED_CHOICE, from_unit, limits, published
from identification.search import Problem, certainty
from identification.targets import Target, half_unit, targets
from identification.trials import RUNS, Trials

FEW = tuple(p for p in PARAMETERS if p.symbol in ("mu right", "mu left", "k_by", "c_by"))
READ = [
    (table, channel, mass)
    for mass in (20e3, 80e3)
    for table, channel in (
        ("peak", "right_midspan"),
        ("peak", "left_midspan"),
        ("rms", "car_body_y"),
        ("peak", "car_body_y_acceleration"),
    )
]


def problem(known: np.ndarray) -> Problem:
    """Claims made with parameters that are known (shares of the ranges), each good to 0.1 %."""
    trials = Trials(PUBLISHED_CHOICE, FEW, RUNS[:1])
    made = [
        Target(
            channel,
            channel,
            "",
            1.0,
            0,
            1.0,
            {"table": table, "channel": channel},
            (("car_body_mass", mass),),
        )
        for table, channel, mass in READ
    ]
    truth = Problem(trials, made).ours(known[None])[0]
    return Problem(
        trials, [replace(t, value=v, error=1e-3 * v) for t, v in zip(made, truth.tolist(), strict=True)]
    )


def test_known_parameters_are_found_again() -> None:
    known = np.array([0.4, 0.6, 0.7, 0.6])
    twin = problem(known)
    start = published(FEW)
    assert np.abs(start - known).max() > 0.2
    fit = twin.fit(start, 30)
    # The eight numbers are met exactly at `known`: what is left is the tolerance of the search.
    assert fit.shares == pytest.approx(known, abs=2e-3)
    assert np.abs(fit.residuals).max() < 0.1
    sure = certainty(twin, fit)
    assert sure.spread.max() < 0.1
    assert (sure.singular > 1).all()


def test_bounds_hold_where_the_claims_ask_for_more() -> None:
    twin = problem(np.array([0.3, 0.3, 0.5, 0.5]))
    # Ten times the deflection of the right beam: only one far lighter than the bound allows has that.
    ten = [replace(t, value=10 * t.value) for t in twin.targets if t.id == "right_midspan"]
    fit = Problem(twin.trials, ten).fit(published(FEW), 20)
    lower, upper = limits(FEW)
    assert ((fit.values >= lower) & (fit.values <= upper)).all()
    assert fit.shares[0] < 0.02


def test_parameters_that_no_claim_depends_on_stay_open() -> None:
    known = np.array([0.5, 0.4, 0.5, 0.5])
    twin = problem(known)
    alone = Problem(twin.trials, [t for t in twin.targets if t.id == "left_midspan"])
    sure = certainty(alone, alone.at(known))
    spread = dict(zip([p.symbol for p in FEW], sure.spread.tolist(), strict=True))
    assert spread["mu left"] < 0.1
    assert spread["c_by"] > 0.9


def test_readings_are_those_of_a_run() -> None:
    solved = Trials(PUBLISHED_CHOICE, PARAMETERS, RUNS[:1]).solve(
        from_unit(PARAMETERS, published(PARAMETERS))[None]
    )
    solver = Solver(load_case("paper"))
    result = solver.solve([0])
    assert result is not None
    column = [channel.name for channel in solver.tables].index("car_body_y_acceleration")
    # The second moments are made from mu and EI/mu, so the last digits differ.
    assert solved[0].point("peak", "car_body_y_acceleration", {}) == pytest.approx(
        result.tables["peak"][0, column], rel=1e-6
    )


def test_the_frequencies_of_the_beams_stay_whatever_their_mass() -> None:
    ends = from_unit(FEW, np.array([[0.0, 1.0, 0.5, 0.5], [1.0, 0.0, 0.5, 0.5]]))
    scenarios = Scenarios(Trials(PUBLISHED_CHOICE, FEW, RUNS[:1]).cases(ends)[0])
    for index in range(len(scenarios)):
        bridge = scenarios.case_of(index).bridge
        assert bridge.left is not None
        found = [natural_frequencies(bridge, beam)[3] / (2 * np.pi) for beam in (bridge.right, bridge.left)]
        # Table 2 has five digits.
        assert found == pytest.approx([14.464, 14.986], abs=5e-4)


def test_what_is_published_lies_within_the_bounds() -> None:
    shares = published(PARAMETERS)
    assert ((shares >= 0) & (shares <= 1)).all()
    assert all(p.source for p in PARAMETERS)


def test_errors_are_those_of_the_digits_printed() -> None:
    assert [half_unit(text) for text in ("0.50", "18", "168.5", "2.51e-3")] == pytest.approx(
        [0.005, 0.5, 0.05, 5e-6]
    )
    found = {target.id: target for target in targets(0.0)}
    assert found["t_rear_bogie_z"].error == pytest.approx(0.005)  # printed 0.50
    assert found["rms_mid_50kmh"].error == pytest.approx(2 * 5e-7)  # one run read at four intervals
    assert targets(0.02)[0].error > targets(0.0)[0].error


def test_only_reported_numbers_are_fitted() -> None:
    claims = data_file("claims.yaml")
    found = {target.id for target in targets(0.02)}
    assert found
    for name in found:
        assert claims[name].get("trust", "reported") == "reported"
    assert "t_right_midspan" not in found  # doubtful
    assert "trend_span" not in found  # a statement
    assert "f4_left" not in found  # exact
    assert {t.id for t in targets(0.02, ["v_daf"])} == found - {"v_daf"}
