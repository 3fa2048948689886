# ruff: noqa: E501 - messages are never wrapped, here neither.
"""A change that gives one of several forms takes the others away: as if the file had been written so."""

from __future__ import annotations

from pathlib import Path

import pytest

from tbi_cli.case.forms import _DISTRIBUTION_FORMS, _RANGE_FORMS
from tbi_cli.case.part import Part

from .conftest import Loads, Says

BEAM = "{{youngs_modulus: 34 GPa, second_moment: {0}, mass_per_length: 9 t/m, damping: {1}}}"
FORCES = "{model: axle-forces, positions: [0, 3], forces: [1e5, 2e5]}"
HERTZ = "{model: hertz, stiffness: 1.1e9, damping: 10, running_circle: 0.7}"
CAR = "{vehicle: {model: sprung-mass, mass: 5 t, stiffness: 1e6, damping: 0}, spacing: 20}"
RAILS = "{irregularity: {profile: {x: [-20, 0, 9], right: [0, 0.001, 0], left: [0, 0, 0.002]}}}"


def case(**changes: str) -> str:
    """A case with some keys written otherwise; that of two beams has a full train."""
    keys = {"train": FORCES, "damping": "{ratio: 1 %}", "left": "", "velocity": "40", "more": ""} | changes
    left = f", left: {BEAM.format(1.3, '1e4')}" if keys["left"] else ""
    stations = f", stations: {keys['stations']}" if "stations" in keys else ""
    return (
        f"train: {keys['train']}\n"
        f"bridge: {{length: 20 m, right: {BEAM.format(1.1, keys['damping'])}{left}{stations}}}\n"
        f"velocity: {keys['velocity']}\n{keys['more']}"
    )


def sweep(axes: str) -> str:
    return case(more=f"sweep: {{{axes}}}\n")


def full(more: str) -> str:
    return case(train="paper", left="yes", more=more)


def sample(distribution: str) -> str:
    return sweep(f"sample: {{kind: sobol, count: 4, over: {{velocity: {distribution}}}}}")


# Before, what is changed, and the file that has only that.
CHANGES = {
    "numbers to a file": (case(), ["train.csv=axles.csv"], case(train="{model: axle-forces, csv: axles.csv}")),
    "a file to numbers": (
        case(train="{model: axle-forces, csv: axles.csv}"),
        ["train.positions=[0, 5]", "train.forces=[7e4, 8e4]"],
        case(train="{model: axle-forces, positions: [0, 5], forces: [7e4, 8e4]}"),
    ),
    "another file": (
        case(train="{model: axle-forces, csv: other.csv}"),
        ["train.csv=axles.csv"],
        case(train="{model: axle-forces, csv: axles.csv}"),
    ),
    "a file of a vehicle in a consist": (
        case(train=f"{{consist: [{{vehicle: {FORCES}, spacing: 20}}]}}"),
        ["train.consist.0.vehicle.csv=axles.csv"],
        case(train="{consist: [{vehicle: {model: axle-forces, csv: axles.csv}, spacing: 20}]}"),
    ),
    "rails to a file": (
        full(f"track: {RAILS}\n"),
        ["track.irregularity.profile.csv=rails.csv"],
        full("track: {irregularity: {profile: {csv: rails.csv}}}\n"),
    ),
    "a file to rails": (
        full("track: {irregularity: {profile: {csv: rails.csv}}}\n"),
        [f"track.irregularity.profile.{key}" for key in ("x=[-20, 0, 9]", "right=[0, 0.001, 0]", "left=[0, 0, 0.002]")],
        full(f"track: {RAILS}\n"),
    ),
    **{
        f"damping {old} to {key}": (case(damping=old), [f"bridge.right.damping{key}={value}"], case(damping=new))
        for old in ("{ratio: 1 %}", "{first_mode_ratio: 3 %}", "{coefficient: 2e4}", "2e4")
        for key, value, new in (
            (".ratio", "2 %", "{ratio: 2 %}"),
            (".first_mode_ratio", "2 %", "{first_mode_ratio: 2 %}"),
            (".coefficient", "1e4", "{coefficient: 1e4}"),
            ("", "1e4", "{coefficient: 1e4}"),
            ("", "{first_mode_ratio: 2 %}", "{first_mode_ratio: 2 %}"),
        )
    },
    **{
        f"stations {old} to {key}": (case(stations=old), [f"bridge.stations{key}={value}"], case(stations=new))
        for old in ("[4 m, 7 m]", "{positions: [4 m]}", "{fractions: [0.25, 40 %]}")
        for key, value, new in (
            (".fractions", "[0.5]", "{fractions: [0.5]}"),
            (".positions", "[3 m]", "[3 m]"),
            ("", "[3 m]", "[3 m]"),
            ("", "{fractions: [0.5]}", "{fractions: [0.5]}"),
        )
    },
    "a vehicle to a row": (case(), [f"train.consist=[{CAR}]"], case(train=f"{{consist: [{CAR}]}}")),
    "another contact": (full(f"contact: {HERTZ}\n"), ["contact.model=paper"], full("")),
    "another method": (case(more="solver: {substeps: 7}\n"), ["solver.method=exact"], case(more="solver: {method: exact}\n")),
}  # fmt: skip
# What replaces the whole in a study, or cannot be named there one by one.
OPTIONS = {
    "a row to a vehicle": (
        case(train=f"{{consist: [{CAR}]}}"),
        ["train.model=moving-load", "train.forces=[1e5]"],
        case(train="{model: moving-load, forces: [1e5]}"),
    ),
    "another model, what both have stays": (
        case(train="{model: rigid-beam, mass: 5 t, pitch_inertia: 1e5, support_distance: 9, stiffness: 1e6, damping: 3}"),
        ["train.model=sprung-mass"],
        case(train="{model: sprung-mass, mass: 5 t, stiffness: 1e6, damping: 3}"),
    ),
    "the last option counts": (
        case(),
        ["train.csv=axles.csv", "train.positions=[0, 5]", "train.forces=[7e4, 8e4]"],
        case(train="{model: axle-forces, positions: [0, 5], forces: [7e4, 8e4]}"),
    ),
    "stations of options alone": (
        case(),
        ["bridge.stations=[1 m]", "bridge.stations.fractions=[0.5]"],
        case(stations="{fractions: [0.5]}"),
    ),
    "a step to a count": (
        sweep("velocity: {from: 20, to: 40, step: 5}"),
        ["sweep.velocity.count=3"],
        sweep("velocity: {from: 20, to: 40, count: 3}"),
    ),
    "a count to a step": (
        sweep("velocity: {from: 20, to: 40, count: 9}"),
        ["sweep.velocity.step=10"],
        sweep("velocity: {from: 20, to: 40, step: 10}"),
    ),
    "a refined step to a count": (
        sweep("velocity: {from: 20, to: 40, step: 5, refine: resonance, tolerance: 2 %}"),
        ["sweep.velocity.count=3"],
        sweep("velocity: {from: 20, to: 40, count: 3}"),
    ),
    "a step to a logarithm": (
        sweep("velocity: {from: 20, to: 40, step: 5}"),
        ["sweep.velocity.log={from: 10, to: 80, count: 4}"],
        sweep("velocity: {log: {from: 10, to: 80, count: 4}}"),
    ),
    "a logarithm to a step": (
        sweep("bridge.length: {log: {from: 10, to: 80, count: 4}}"),
        ["sweep.bridge.length.from=10", "sweep.bridge.length.to=30", "sweep.bridge.length.step=10"],
        sweep("bridge.length: {from: 10, to: 30, step: 10}"),
    ),
    "a part of a logarithm": (
        sweep("velocity: {log: {from: 10, to: 80, count: 4}}"),
        ["sweep.velocity.log.count=5"],
        sweep("velocity: {log: {from: 10, to: 80, count: 5}}"),
    ),
    "one value of a list": (sweep("velocity: [20, 30]"), ["sweep.velocity.1=35"], sweep("velocity: [20, 35]")),
    "a short name for a key": (
        sweep("bridge.length: [20, 30], velocity: [20, 30]"), ["sweep.span=[15]"], sweep("span: [15], velocity: [20, 30]"),
    ),
    "a key for a short name": (
        sweep("velocity: [20, 30], span: [20, 30]"), ["sweep.bridge.length=[15]"], sweep("velocity: [20, 30], bridge.length: [15]"),
    ),
    "another distribution": (
        sample("{uniform: [20, 50], within: [25, 45]}"),
        ["sweep.sample.over.velocity.normal=[30, 5]"],
        sample("{normal: [30, 5], within: [25, 45]}"),
    ),
    "the size of a sample": (
        sample("{uniform: [20, 50]}"), ["sweep.sample.count=4", "sweep.sample.seed=0"], sample("{uniform: [20, 50]}"),
    ),
}  # fmt: skip


@pytest.fixture(autouse=True)
def files(folder: Path) -> None:
    (folder / "axles.csv").write_text("0,8e4\n2.5,9e4\n7,7e4\n")
    (folder / "other.csv").write_text("0,1e5\n")
    (folder / "rails.csv").write_text("-30,0,0\n-4,1e-3,2e-3\n11,0,1e-3\n")


@pytest.mark.parametrize("name", [*CHANGES, *OPTIONS])
def test_an_option_replaces_the_other_forms(loads: Loads, name: str) -> None:
    before, options, after = (CHANGES | OPTIONS)[name]
    changed = loads(before, overrides=options)
    assert changed == loads(after)
    assert changed.sha256 == loads(after).sha256


@pytest.mark.parametrize("name", CHANGES)
def test_so_does_a_study(loads: Loads, name: str) -> None:
    """By dotted keys, by mappings within mappings, and by options of the study."""
    before, options, after = CHANGES[name]
    wanted = loads(after)
    pairs = [option.split("=", 1) for option in options]
    dotted = "".join(f"    {key}: {value}\n" for key, value in pairs)
    told = [f"{before}studies:\n  one:\n{dotted}"]
    if not any(word.isdigit() for key, _ in pairs for word in key.split(".")):
        stem = pairs[0][0].rpartition(".")[0]
        inner = ", ".join(f"{key.rpartition('.')[2]}: {value}" for key, value in pairs)
        words = stem.split(".")
        nested = ": {".join([*words, inner]) + "}" * len(words)
        told.append(f"{before}studies: {{one: {{{nested}}}}}\n")
    for text in told:
        assert loads(text).studies["one"] == wanted, text
    there = loads(
        f"{before}studies: {{one: {{}}}}\n", overrides=[f"studies.one.{option}" for option in options]
    )
    assert there.studies["one"] == wanted


def test_every_form_that_there_is_was_tried() -> None:
    """A new form is to be found here: its keys are those of the changes above."""
    parts, found = [Part], set()
    while parts:
        part = parts.pop()
        parts += part.__subclasses__()
        found |= {key for form in part.forms for key in form} | set(part.needs)
    found |= {key for form in (*_RANGE_FORMS, *_DISTRIBUTION_FORMS) for key in form}
    tried = " ".join(before + str(options) for before, options, _ in (CHANGES | OPTIONS).values())
    assert {key for key in found if key not in tried} == {"channels", "loguniform", "triangular"}


@pytest.mark.parametrize(
    ("text", "options", "message"),
    [
        (case(train=f"{FORCES[:-1]}, csv: axles.csv}}"), [], "case.yaml:1:68: train.csv: expected either csv, or positions and forces, got csv and positions and forces"),
        (case(damping="{ratio: 1 %, coefficient: 1}"), [], "case.yaml:2:100: bridge.right.damping: expected one of coefficient, first_mode_ratio, ratio, got coefficient and ratio"),
        (case(more="studies: {a: {bridge.right.damping.ratio: 1 %, bridge.right.damping.coefficient: 1}}\n"), [], "case.yaml:4:48: bridge.right.damping: expected one of coefficient, first_mode_ratio, ratio, got coefficient and ratio"),
        (case(more="studies: {a: {bridge: {stations: {fractions: [0.5], positions: [1]}}}}\n"), [], "case.yaml:4:24: bridge.stations: expected a list of positions, or {fractions: [...]}, and at least one of them"),
        (case(), ["train.forces.x=1"], "--set train.forces.x=1: train.forces has no x; counted from 0, there is 0 to 1"),
        (case(train="{model: moving-load, forces: [1e5]}"), ["train.forces.1=1"], "--set train.forces.1=1: train.forces has no 1; counted from 0, there is 0 alone"),
        (case(more="studies: {a: {train.forces.2: 1}}\n"), [], "case.yaml:4:15: studies.a.train.forces: studies.a.train.forces has no 2; counted from 0, there is 0 to 1"),
        (case(stations="[1]"), ["bridge.stations.bogus=1"], "--set bridge.stations.bogus=1: bridge.stations.bogus: unknown key; known here: positions, fractions"),
    ],
)  # fmt: skip
def test_two_forms_by_one_hand_are_refused(says: Says, text: str, options: list[str], message: str) -> None:
    assert says(text, overrides=options).splitlines()[0] == message


def test_what_a_study_names_stays_under_an_option(loads: Loads) -> None:
    """An option below a train or a bridge that the study names changes that one."""
    text = full("studies: {one: {train: crh380a, bridge: paper}}\n")
    study = loads(
        text, overrides=["studies.one.train.car_body.mass=30 t", "studies.one.bridge.length=33"]
    ).studies["one"]
    named = loads(
        full(
            "studies: {one: {train: crh380a, train.car_body.mass: 30 t, bridge: paper, bridge.length: 33}}\n"
        )
    )
    assert study == named.studies["one"]
    assert (
        study.train.front_bogie.mass
        == loads(full("").replace("train: paper", "train: crh380a")).train.front_bogie.mass
    )  # type: ignore[union-attr]
    assert study.bridge.length == 33


def test_null_takes_away_what_the_study_has(loads: Loads) -> None:
    text = case(more="studies: {one: {solver: {duration: 3, sampling: 0.01}}}\n")
    solver = loads(text, overrides=["studies.one.solver.duration=null"]).studies["one"].solver
    assert (solver.duration, solver.sampling) == (5, 0.01)
