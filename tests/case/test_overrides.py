# ruff: noqa: E501 - messages are never wrapped, here neither.
"""`--set KEY=VALUE` reaches any key, and its mistakes name the option."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tbi_cli.case import Case, FullTrain, load_case

from .conftest import CASE, Loads, Says


def train(case: Case) -> FullTrain:
    assert isinstance(case.train, FullTrain)
    return case.train


@pytest.mark.parametrize(
    ("options", "found", "value"),
    [
        (["velocity=50"], lambda c: c.velocity, 50.0),
        (["velocity = 180 km/h"], lambda c: c.velocity, 50.0),
        (["velocity=1", "velocity=2"], lambda c: c.velocity, 2.0),
        (["train.car_body.mass=20 t"], lambda c: train(c).car_body.mass, 20e3),
        (["train=crh380a"], lambda c: train(c).car_body.mass, 40840.0),
        (["train=crh380a", "train.car_body.mass=1e4"], lambda c: train(c).car_body.mass, 1e4),
        (["train.car_body.mass=1e4", "train=crh380a"], lambda c: train(c).car_body.mass, 40840.0),
        (["train.rear_bogie={mass: 5000}"], lambda c: train(c).rear_bogie.mass, 5e3),
        (["train.rear_bogie.mass=5000"], lambda c: train(c).front_bogie.mass, 2280.0),
        (["bridge=paper", "bridge.length=30"], lambda c: c.bridge.length, 30.0),
        (["bridge.right.damping={ratio: 1 %}"], lambda c: c.bridge.right.damping.form, "ratio"),
        (["bridge.right.damping.ratio=1 %"], lambda c: c.bridge.right.damping.value, 0.01),
        (["contact.convective=true"], lambda c: c.contact.convective, True),
        (["solver.sampling=auto"], lambda c: c.solver.sampling, "auto"),
        (["output.histories=all"], lambda c: c.output.histories.stored, True),
        (["output.histories.every=0.01"], lambda c: c.output.histories.every, 0.01),
        (["output.file=a=b.h5"], lambda c: c.output.file, "a=b.h5"),
        (["title='1e5'"], lambda c: c.title, "1e5"),
        (["gravity=null"], lambda c: c.gravity, 9.81),
        (["sweep.velocity={from: 10, to: 20, step: 5}"], lambda c: c.axes[0].values, (10.0, 15.0, 20.0)),
        (["sweep.train.car_body.mass=[1 t, 2 t]"], lambda c: c.axes[0].values, (1e3, 2e3)),
        (["sweep={span: [30]}"], lambda c: [a.name for a in c.axes], ["span"]),
        (["sweep.span=[30]", "sweep.modes=[1]"], lambda c: [a.name for a in c.axes], ["span", "modes"]),
        (["sweep.span=[30]", "sweep.span=null"], lambda c: c.axes, ()),
        (["sweep.span=[30]", "sweep=null"], lambda c: c.axes, ()),
        (
            ["sweep.span={from: 30, to: 60, step: 10}", "sweep.span.step=30"],
            lambda c: c.axes[0].values,
            (30.0, 60.0),
        ),
    ],
)
def test_any_key_can_be_set(
    loads: Loads, options: list[str], found: Callable[[Case], Any], value: object
) -> None:
    assert found(loads(CASE, overrides=options)) == value


@pytest.mark.parametrize(
    ("option", "message"),
    [
        (
            "velocity=-5",
            '--set velocity=-5: velocity: expected a positive speed, e.g. "300 km/h" or 83.3333, got -5',
        ),
        ("velocity=[1", "--set velocity=[1: not valid YAML: did not find expected ',' or ']'"),
        (
            "velocity=!!int 5",
            "--set velocity=!!int 5: tags are not used in case files, got 'tag:yaml.org,2002:int'",
        ),
        ("velocity=", '--set velocity=: expected a value after "="'),
        ("velocity", "--set velocity: expected KEY=VALUE, e.g. velocity=50"),
        ("=5", "--set =5: expected KEY=VALUE, e.g. velocity=50"),
        ("a..b=5", "--set a..b=5: expected KEY=VALUE, e.g. velocity=50"),
        ("velocty=5", "--set velocty=5: velocty: unknown key; did you mean velocity?"),
        (
            "velocity.x=5",
            '--set velocity.x=5: velocity: expected a positive speed, e.g. "300 km/h" or 83.3333, got a mapping',
        ),
        (
            "train.car_body.mas=5",
            "--set train.car_body.mas=5: train.car_body.mas: unknown key; did you mean mass?",
        ),
        ("sweep.spam=[1]", "--set sweep.spam=[1]: sweep.spam: no such key; did you mean span?"),
        ("sweep.span=[]", "--set sweep.span=[]: sweep.span: expected at least one value, got an empty list"),
        (
            "train=papr",
            '--set train=papr: train: "papr": no such file in the working folder, and no built-in train of that name; did you mean paper?',
        ),
        (
            "bridge={length: 5}",
            "--set bridge={length: 5}: bridge.right: missing; expected a mapping with the keys youngs_modulus, second_moment, mass_per_length, damping",
        ),
        (
            "title=a\x1bb",
            "--set title=a\\x1bb: control character U+001B",
        ),
    ],
)
def test_its_mistakes_name_the_option(says: Says, option: str, message: str) -> None:
    assert says(CASE, overrides=[option]).splitlines()[0] == message


def test_mistakes_of_all_options_and_of_the_file_come_together(says: Says) -> None:
    message = says(CASE.replace("modes: 4", "modes: 0"), overrides=["velocity=-1", "gravity=[", "foo=1"])
    places = [line.split(": ")[0] for line in message.splitlines() if not line.startswith(" ")]
    assert sorted(places) == ["--set foo=1", "--set gravity=[", "--set velocity=-1", "case.yaml:4:3"]


def test_taking_a_needed_key_away(says: Says) -> None:
    assert says(CASE, overrides=["velocity=null"]).splitlines()[0] == (
        'case.yaml:1:1: velocity: missing; expected a positive speed, e.g. "300 km/h" or 83.3333'
    )


def test_what_an_alias_repeats_is_changed_in_one_place_only(loads: Loads) -> None:
    text = CASE.replace("  right:", "  right: &beam").replace(
        CASE[CASE.index("{youngs") : CASE.index("\nvelocity")], "*beam"
    )
    case = loads(text, overrides=["bridge.left.second_moment=0.5"])
    assert case.bridge.left is not None
    assert (case.bridge.right.second_moment, case.bridge.left.second_moment) == (0.2, 0.5)


def test_files_named_by_an_option_are_found_in_the_working_folder(folder: Path) -> None:
    (folder / "mine.yaml").write_text("model: sprung-mass\nmass: 5\nstiffness: 1e6\ndamping: 0\n")
    options = ["train=mine.yaml", "bridge=verification-1", "contact.static_load=physical"]
    assert load_case("paper", overrides=options).train.model == "sprung-mass"


def test_an_option_that_the_sweep_sets_again_is_told_so(loads: Loads, says: Says) -> None:
    """It changed nothing, without a word; what is advised replaces the axis, by whatever name it has."""
    swept = CASE + "sweep: {span: [30, 40]}\n"
    text = "bridge.length: has no effect, as the sweep sets it; set sweep.bridge.length to replace its values"
    (warning,) = loads(swept, overrides=["bridge.length=35"]).warnings
    assert warning.splitlines()[0] == f"--set bridge.length=35: warning: {text}"
    assert text in says(swept, overrides=["bridge.length=35"], strict=True)
    (axis,) = loads(swept, overrides=["sweep.bridge.length=[35]"], strict=True).axes
    assert (axis.paths, axis.values) == (("bridge.length",), (35.0,))
    # What stands in the file beside its own sweep is the file's value where nothing is swept.
    assert not loads(swept + "gravity: 9.8\n", overrides=["gravity=9.7", "sweep.modes=[2, 3]"]).warnings
    zipped = CASE + "sweep: {bridge.length: [30, 40], velocity: [50, 60], zip: [bridge.length, velocity]}\n"
    (warning,) = loads(zipped, overrides=["velocity=35"]).warnings
    assert warning.splitlines()[0].endswith("velocity: has no effect, as the sweep sets it")
