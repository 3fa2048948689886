"""The case that `tbi init` writes loads as it is, whatever train and bridge it is asked for."""

from __future__ import annotations

import pytest
from jsonschema import Draft202012Validator

from tbi_cli.case import CaseError, list_builtin, load_case, starter_case
from tbi_cli.case.messages import Source
from tbi_cli.case.schema import json_schema
from tbi_cli.case.yaml12 import plain, read_yaml

from .conftest import Loads

TRAINS = [builtin.name for builtin in list_builtin("train")]
BRIDGES = ("composite-40m", "paper", "paper-fitted", "simply-supported")
WHOLE_DECKS = ("verification-1", "verification-2", "whole-deck")
PAIRS = [
    (train, bridge) for train in TRAINS for bridge in (WHOLE_DECKS if train.startswith("hslm") else BRIDGES)
]


def test_no_bridge_is_left_out() -> None:
    assert {builtin.name for builtin in list_builtin("bridge")} == {*BRIDGES, *WHOLE_DECKS}


@pytest.mark.parametrize(("train", "bridge"), PAIRS)
def test_it_is_the_train_and_the_bridge_asked_for(loads: Loads, train: str, bridge: str) -> None:
    case = loads(starter_case(train, bridge))
    assert case.warnings == ()
    assert case.contact.static_load == "physical"
    named = load_case(overrides=[f"train={train}", f"bridge={bridge}", "contact.static_load=physical"])
    assert (case.train, case.bridge) == (named.train, named.bridge)


@pytest.mark.parametrize("train", TRAINS)
def test_without_a_bridge_the_train_gets_one_that_fits(loads: Loads, train: str) -> None:
    assert (loads(starter_case(train)).bridge.left is None) == train.startswith("hslm")


def test_its_schema_holds() -> None:
    value = plain(read_yaml(Source("case.yaml", starter_case()))[0])
    assert list(Draft202012Validator(json_schema()).iter_errors(value)) == []


@pytest.mark.parametrize(
    ("train", "bridge", "message"),
    [
        ("crh308a", "paper", '--train "crh308a": no built-in train of that name; did you mean crh380a?'),
        ("paper", "papre", '--bridge "papre": no built-in bridge of that name; did you mean paper?'),
        (
            "paper",
            "verification-1",
            '--bridge "verification-1": it has one beam only; the train needs two',
        ),
        (
            "hslm-a3",
            "paper",
            '--bridge "paper": it has two beams; '
            "the train hslm-a3 needs one for the whole deck, e.g. whole-deck",
        ),
        ("../paper", "paper", '--train "../paper": no built-in train of that name; did you mean paper?'),
    ],
)
def test_what_it_cannot_write(train: str, bridge: str, message: str) -> None:
    with pytest.raises(CaseError) as caught:
        starter_case(train, bridge)
    assert str(caught.value) == message
