# ruff: noqa: E501 - messages are never wrapped, here neither.
"""Several studies in one case file: what each of them is, and what is wrong with one."""

from __future__ import annotations

import pytest

from tbi_cli.case import ExtraAxis, FullTrain, load_case

from .conftest import CASE, Loads, Says

STUDIES = f"""{CASE}output: {{file: both.h5}}
studies:
  heavy: {{train.car_body.mass: 60 t, sweep: {{velocity: [50, 60]}}}}
  wide: {{bridge: {{length: 60 m, right: {{damping: {{ratio: 1 %}}}}}}, sweep: {{span: [30, 60]}}}}
  plain: {{}}
"""


def test_each_study_is_the_file_with_its_own_keys(loads: Loads) -> None:
    case = loads(STUDIES)
    assert list(case.studies) == ["heavy", "wide", "plain"]
    assert case.axes == ()
    assert case.output.file == "both.h5"
    heavy, wide, plain = case.studies.values()
    alone = loads(f"{CASE}output: {{file: both.h5}}\n")
    assert plain == alone
    assert isinstance(heavy.train, FullTrain)
    assert heavy.train.car_body.mass == 60e3
    assert [axis.values for axis in heavy.axes] == [(50, 60)]
    assert (wide.bridge.length, wide.bridge.modes) == (60, 4)
    assert (wide.bridge.right.damping.form, wide.bridge.right.damping.value) == ("ratio", 0.01)
    assert wide.bridge.left == alone.bridge.left
    assert wide.train == alone.train


def test_a_round_trip(loads: Loads) -> None:
    case = loads(STUDIES)
    again = loads(case.to_yaml())
    assert again == case
    assert again.sha256 == case.sha256 != case.studies["plain"].sha256


def test_the_root_needs_not_be_a_case(loads: Loads) -> None:
    case = loads("studies:\n  a: {train: paper, bridge: paper, sweep: {velocity: [50]}}\n")
    assert case.studies["a"].axes[0].values == (50,)


def test_a_study_inherits_a_sweep_or_has_its_own(loads: Loads) -> None:
    text = f"{CASE}sweep: {{velocity: [1, 2]}}\nstudies: {{a: {{}}, b: {{sweep: {{modes: [3]}}}}, c: {{sweep: null}}}}\n"
    assert [[a.name for a in study.axes] for study in loads(text).studies.values()] == [
        ["velocity"],
        ["modes"],
        [],
    ]


def test_another_train_or_bridge_replaces_the_whole(loads: Loads) -> None:
    force = "{model: moving-load, forces: [1 kN]}"
    study = loads(f"{CASE}studies: {{a: {{train: {force}, bridge: verification-1}}}}\n").studies["a"]
    assert study.train.model == "moving-load"
    assert study.bridge.left is None
    dotted = loads(f"{CASE}studies: {{a: {{bridge: paper, bridge.length: 33}}}}\n").studies["a"]
    assert dotted.bridge.length == 33
    assert dotted.bridge.left is not None


def test_options_reach_a_study(loads: Loads) -> None:
    case = loads(
        STUDIES, overrides=["studies.wide.sweep.span=[40]", "velocity=10", "studies.plain.velocity=20"]
    )
    assert [study.velocity for study in case.studies.values()] == [10, 10, 20]
    assert case.studies["wide"].axes[0].values == (40,)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("plain: {}", "plain: {velocity: -1}", 'case.yaml:16:11: studies.plain.velocity: expected a positive speed, e.g. "300 km/h" or 83.3333, got -1\n'),
        ("plain: {}", "plain: {velocty: 1}", "case.yaml:16:11: studies.plain.velocty: unknown key; did you mean velocity?\n"),
        ("plain: {}", "plain: 5", "case.yaml:16:3: studies.plain: expected a mapping of the keys that this study changes, such as {sweep: {...}}, got 5\n"),
        ("plain: {}", "7: {}", 'case.yaml:16:3: studies.7: expected a name of at most 64 letters, digits, - and _ that begins with a letter, got "7"\n'),
        ("plain: {}", "plain: {output: {file: x.h5}}", "case.yaml:16:3: studies.plain: all studies are in one file: output.file stands outside of them\n"),
        ("velocity: 300 km/h", "velocity: 300 kg", "case.yaml:11:1: velocity: expected a positive speed"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_told_once_and_where(says: Says, old: str, new: str, message: str) -> None:
    told = says(STUDIES.replace(old, new))
    assert told.startswith(message)
    assert told.count("case.yaml:") == 1


def test_no_studies_at_all(says: Says) -> None:
    assert "studies: expected a mapping of studies" in says(f"{CASE}studies: {{}}\n")
    assert "studies: expected at most 64 studies" in says(
        f"{CASE}studies: {{{', '.join(f's{i}: {{}}' for i in range(65))}}}\n"
    )


def test_the_axes_of_all_studies_together_are_bounded(says: Says) -> None:
    axis = "{sweep: {velocity: {from: 1, to: 99, count: 400000}}}"
    told = says(f"{CASE}studies:\n  a: {axis}\n  b: {axis}\n").splitlines()
    assert told[0] == (
        "case.yaml:14:43: studies.b.sweep.velocity.count: expected at most 500000 values in all axes together, "
        "got 400000 after the 400000 before"
    )
    assert len(told) == 3


def test_a_sweep_on_the_command_line_is_refused(says: Says) -> None:
    assert (
        says(STUDIES, extra_axis=ExtraAxis("velocity"))
        == "sweep velocity: the studies of this case have their own sweeps"
    )


@pytest.mark.parametrize("campaign", ["all", "campaign"])
def test_the_papers_studies_are_those_of_their_own_files(campaign: str) -> None:
    names = {"masses": "velocity-masses", "spans": "velocity-spans", "damping": "velocity-damping"}
    for name, study in load_case(f"paper/{campaign}").studies.items():
        alone = load_case(f"paper/{names.get(name, name) if campaign == 'campaign' else name}")
        assert study.sha256 == alone.sha256
