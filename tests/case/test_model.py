# ruff: noqa: E501 - messages are never wrapped, here neither.
"""The loaded case: SI values, what follows from others, equality, hash, copies."""

from __future__ import annotations

import json
import pickle
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from tbi_cli.case import Case, FullTrain, load_case

from .conftest import CASE, Loads, Says


def full_train(case: Case) -> FullTrain:
    assert isinstance(case.train, FullTrain)
    return case.train


def test_numbers_are_si_floats(loads: Loads) -> None:
    case = loads()
    assert case.velocity == 300 / 3.6
    assert case.bridge.right.youngs_modulus == 207e9
    assert type(case.bridge.length) is float
    assert type(case.bridge.modes) is int


def test_defaults(loads: Loads) -> None:
    case = loads()
    assert case.title == ""
    assert case.gravity == 9.81
    assert (case.contact.model, case.contact.static_load, case.contact.convective) == (
        "paper",
        "physical",
        False,
    )
    assert (case.solver.method, case.solver.sampling, case.solver.substeps, case.solver.duration) == (
        "rk4",
        "auto",
        "auto",
        5.0,
    )
    assert case.output.file == "results.h5"
    assert not case.output.histories.stored
    assert case.bridge.modes == 4


def test_a_case_is_frozen(loads: Loads) -> None:
    with pytest.raises(ValidationError):
        loads().velocity = 5.0  # type: ignore[misc]


def test_both_ends_have_the_common_bogie_unless_told_otherwise(loads: Loads) -> None:
    case = loads(
        CASE,
        overrides=[
            "train.front_bogie={mass: 3 t, primary: {vertical: {damping: 5}}, secondary: {lateral: {stiffness: 7}}}"
        ],
    )
    front, rear, common = full_train(case).front_bogie, full_train(case).rear_bogie, full_train(case)
    assert (front.mass, rear.mass) == (3e3, common.bogie.mass)
    assert front.pitch_inertia == rear.pitch_inertia == common.bogie.pitch_inertia
    assert front.primary.vertical.damping == 5
    assert front.primary.vertical.stiffness == common.primary.vertical.stiffness
    assert front.secondary.lateral.stiffness == 7
    assert (rear.primary, rear.secondary) == (common.primary, common.secondary)


@pytest.mark.parametrize(
    ("keys", "arms"),
    [
        ({"bogie_distance": 17.5, "wheelbase": 2.5}, (8.75, 8.75, 1.25, 1.25, 1.25, 1.25)),
        (
            {"bogie_distance": 17.5, "wheelbase": 2.5, "l_b1": 8.0, "l_w4": 1.0},
            (8.0, 9.5, 1.25, 1.25, 1.5, 1.0),
        ),
        ({"l_b1": 8.0, "l_b2": 9.0, "wheelbase": 2.5}, (8.0, 9.0, 1.25, 1.25, 1.25, 1.25)),
        (
            {"l_b1": 8, "l_b2": 9, "l_w1": 1, "l_w2": 2, "l_w3": 3, "l_w4": 4},
            (8.0, 9.0, 1.0, 2.0, 3.0, 4.0),
        ),
        ({"bogie_distance": 17, "l_b1": 8, "l_b2": 9, "wheelbase": 2}, (8.0, 9.0, 1.0, 1.0, 1.0, 1.0)),
    ],
)
def test_arms_left_out_follow_from_the_others(
    loads: Loads, keys: dict[str, float], arms: tuple[float, ...]
) -> None:
    found = full_train(loads(CASE, overrides=geometry_options(keys))).geometry
    assert (found.l_b1, found.l_b2, found.l_w1, found.l_w2, found.l_w3, found.l_w4) == arms


def geometry_options(keys: dict[str, float]) -> list[str]:
    taken_away = ["train.geometry.bogie_distance=null", "train.geometry.wheelbase=null"]
    return taken_away + [f"train.geometry.{key}={value}" for key, value in keys.items()]


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"wheelbase": 2.5}, "train.geometry: missing; expected bogie_distance, or both l_b1 and l_b2"),
        (
            {"wheelbase": 2.5, "l_b1": 5},
            "train.geometry: missing; expected bogie_distance, or both l_b1 and l_b2",
        ),
        (
            {"wheelbase": 2.5, "bogie_distance": 17, "l_b1": 8, "l_b2": 8},
            "train.geometry: bogie_distance = 17, but l_b1 + l_b2 = 16",
        ),
        (
            {"wheelbase": 2.5, "bogie_distance": 17, "l_b2": 17},
            "train.geometry: expected l_b2 smaller than bogie_distance = 17, got 17",
        ),
        (
            {"wheelbase": 2.5, "bogie_distance": 17, "l_w3": 3},
            "train.geometry: expected l_w3 smaller than wheelbase = 2.5, got 3",
        ),
    ],
)
def test_arms_that_contradict_each_other(says: Says, keys: dict[str, float], message: str) -> None:
    first = says(CASE, overrides=geometry_options(keys)).splitlines()[0]
    assert first.endswith(message)


SIMPLE = "bridge: verification-1\nvelocity: 5\n"


@pytest.mark.parametrize(
    ("train", "message"),
    [
        ("{model: moving-load, forces: []}", "train: expected at least one force"),
        (
            "{model: moving-load, forces: [1, 2]}",
            "train: expected one position for each of the 2 forces, got 1",
        ),
        (
            "{model: moving-load, forces: [1, 2, 3], positions: [7, 5, 5]}",
            "train.positions: expected positions in rising order, got 5 (number 2) after 7; "
            "count them backward from the first axle: change the signs",
        ),
        (
            "{model: moving-load, forces: [1, 2, 3], positions: [0, 2, 1]}",
            "train.positions: expected positions in rising order, got 1 (number 3) after 2",
        ),
        (
            "{model: moving-load, forces: 5}",
            'train.forces: expected a list, each a force >= 0, e.g. "56.4 kN" or 56400, got 5',
        ),
        (
            "{model: moving-load, forces: [1, x]}",
            'train.forces.1: expected a force >= 0, e.g. "56.4 kN" or 56400, got "x"',
        ),
    ],
)
def test_moving_loads_that_make_no_train(says: Says, train: str, message: str) -> None:
    assert message in says(f"train: {train}\n{SIMPLE}").splitlines()[0]


@pytest.mark.parametrize(
    "train",
    [
        "{model: sprung-mass, mass: 5750, stiffness: 1595 kN/m, damping: 0}",
        "{model: rigid-beam, mass: 540 t, pitch_inertia: 13.8e6, support_distance: 17.5, stiffness: 41.35e6, damping: 0}",
        "{model: moving-load, forces: [56.4 kN], positions: [0]}",
    ],
)
class TestSimpleVehicles:
    """They run on one beam, with their own weight."""

    def test_the_contracts_examples(self, loads: Loads, train: str) -> None:
        case = loads(f"train: {train}\n{SIMPLE}")
        assert case.bridge.left is None
        assert case.contact.static_load == "physical"

    def test_a_left_beam_is_an_error(self, says: Says, train: str) -> None:
        message = says(f"train: {train}\nbridge: paper\nvelocity: 5\n").splitlines()[0]
        model = train.split(",")[0].removeprefix("{model: ")
        assert message == (
            f"bridges/paper.yaml (built-in):10:1: bridge.left: not for a {model} train, which runs on one beam, "
            "bridge.right"
        )

    def test_the_papers_static_load_is_an_error(self, says: Says, train: str) -> None:
        message = says(f"train: {train}\n{SIMPLE}contact: {{static_load: paper}}\n").splitlines()[0]
        model = train.split(",")[0].removeprefix("{model: ")
        assert message == (
            f"case.yaml:4:11: contact.static_load: expected physical, got paper (Eq. 13a is for full-31dof, not for {model})"
        )


@pytest.mark.parametrize(
    ("written", "stored", "channels", "every"),
    [
        ("none", False, (), None),
        ("all", True, None, None),
        ("{channels: [car_body_y, right_midspan]}", True, ("car_body_y", "right_midspan"), None),
        ("{channels: all, every: 0.01 s}", True, None, 0.01),
        ("{every: 10 ms}", True, None, 0.01),
        ("{channels: [car_body_y], every: 0.01}", True, ("car_body_y",), 0.01),
    ],
)
def test_histories(
    loads: Loads, written: str, stored: bool, channels: tuple[str, ...] | None, every: float | None
) -> None:
    histories = loads(CASE + f"output: {{histories: {written}}}\n").output.histories
    assert (histories.stored, histories.channels, histories.every) == (stored, channels, every)


def test_the_hash_leaves_out_where_the_results_go_and_how_an_axis_is_written(loads: Loads) -> None:
    def sha(*options: str) -> str:
        return loads(CASE, overrides=options).sha256

    assert sha("output.file=a.h5") == sha("output.file=b.h5")
    assert sha("velocity=300 km/h") == sha("velocity=83.33333333333333")
    assert sha("sweep.span=[30, 40]") == sha("sweep.span={from: 30, to: 40, step: 10}")
    different = [
        sha(),
        sha("velocity=5"),
        sha("title=x"),
        sha("output.histories=all"),
        sha("sweep.span=[30, 40]"),
        sha("sweep.span=[40, 30]"),
        sha("sweep.bridge.length=[30, 40]"),
        sha("train.car_body.mass=41 t"),
    ]
    assert len(set(different)) == len(different)


def test_a_case_can_be_sent_to_another_process(loads: Loads) -> None:
    case = loads(CASE, overrides=["sweep.span=[30, 40]", "velocity=300"])
    again = pickle.loads(pickle.dumps(case))
    assert again == case
    assert again.axes == case.axes
    assert again.warnings == case.warnings
    assert again.at({"span": 40.0}) == case.at({"span": 40.0})


POSITIVE = st.floats(1e-6, 1e12)
DAMPINGS = st.one_of(
    POSITIVE,
    st.just(0.0),
    st.builds(lambda form, v: {form: v}, st.sampled_from(["ratio", "first_mode_ratio"]), st.floats(1e-9, 5)),
)
BEAMS = st.fixed_dictionaries(
    {"youngs_modulus": POSITIVE, "second_moment": POSITIVE, "mass_per_length": POSITIVE, "damping": DAMPINGS}
)
TRAINS: st.SearchStrategy[Any] = st.one_of(
    st.fixed_dictionaries(
        {"model": st.just("sprung-mass"), "mass": POSITIVE, "stiffness": POSITIVE, "damping": POSITIVE}
    ),
    st.builds(
        lambda loads: {
            "model": "moving-load",
            "forces": [force for force, _ in loads],
            "positions": [0.0, *sorted(place for _, place in loads)[1:]],
        },
        st.lists(
            st.tuples(POSITIVE, st.floats(0, 1e6).filter(lambda x: x == 0 or x > 1e-9)),
            min_size=1,
            max_size=5,
        ),
    ),
)
AXES = st.dictionaries(
    st.sampled_from(["velocity", "span", "gravity", "bridge.right.mass_per_length", "solver.duration"]),
    st.lists(st.floats(1e-3, 1e3), min_size=1, max_size=6, unique=True)
    | st.builds(lambda a, n: {"from": a, "to": 1.5 * a, "count": n}, st.floats(1e-3, 1e3), st.integers(1, 9))
    | st.builds(
        lambda a, n: {"log": {"from": a, "to": 3 * a, "count": n}}, st.floats(1e-3, 1e3), st.integers(1, 9)
    )
    | st.builds(
        lambda a, n: {"from": a, "to": a * (1 + n), "step": a}, st.floats(1e-3, 1e2), st.integers(0, 9)
    ),
    max_size=3,
)


@settings(deadline=None)
@given(train=TRAINS, beam=BEAMS, span=POSITIVE, modes=st.integers(1, 20), velocity=POSITIVE, axes=AXES)
def test_a_resolved_case_loads_as_the_same_case(
    tmp_path_factory: pytest.TempPathFactory,
    train: dict[str, Any],
    beam: dict[str, Any],
    span: float,
    modes: int,
    velocity: float,
    axes: dict[str, Any],
) -> None:
    path: Path = tmp_path_factory.mktemp("case") / "case.yaml"
    written = {
        "train": train,
        "bridge": {"length": span, "modes": modes, "right": beam},
        "velocity": velocity,
        "sweep": axes,
    }
    path.write_text(json.dumps(written))
    case = load_case(path)
    assert (case.velocity, case.bridge.length, case.bridge.modes) == (velocity, span, modes)
    path.write_text(case.to_yaml())
    again = load_case(path)
    assert again == case
    assert again.sha256 == case.sha256
    assert again.to_yaml() == case.to_yaml()
