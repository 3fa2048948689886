# ruff: noqa: E501 - messages are never wrapped, here neither.
"""A unit on some of the numbers of a list, a range or a distribution: what was read is said."""

from __future__ import annotations

from pathlib import Path

import pytest

from tbi_cli.case import ExtraAxis
from tests.cli.commands import tbi

from .conftest import CASE, Loads, Says

START = "some numbers have a unit and some have none; "
FORCES = "train: {model: axle-forces, positions: [0, 2.5 m, 5], forces: [180 kN, 120000, 90 kN]}\nbridge: verification-1\nvelocity: 9\n"

MIXED = [
    (
        "velocity: [20, 30, 40 km/h]",
        f'13:14: warning: sweep.velocity: {START}20 was read as 20 m/s and "40 km/h" was read as 11.1111 m/s',
    ),
    (
        "velocity: [72 km/h, 90 km/h, 30]",
        f'13:32: warning: sweep.velocity: {START}30 was read as 30 m/s and "72 km/h" was read as 20 m/s',
    ),
    (
        'velocity: ["20", 40 km/h]',
        f'13:14: warning: sweep.velocity: {START}"20" was read as 20 m/s and "40 km/h" was read as 11.1111 m/s',
    ),
    (
        "velocity: {from: 10, to: 80 km/h, step: 2}",
        f'13:14: warning: sweep.velocity.from: {START}10 was read as 10 m/s and "80 km/h" was read as 22.2222 m/s',
    ),
    (
        "velocity: {from: 36 km/h, to: 80 km/h, step: 2}",
        f'13:42: warning: sweep.velocity.step: {START}2 was read as 2 m/s and "36 km/h" was read as 10 m/s',
    ),
    (
        "velocity: {from: 36 km/h, to: 80 km/h, step: 2, refine: resonance}",
        f'13:42: warning: sweep.velocity.step: {START}2 was read as 2 m/s and "36 km/h" was read as 10 m/s',
    ),
    (
        "span: {from: 2000 cm, to: 30, count: 3}",
        f'13:25: warning: sweep.span.to: {START}30 was read as 30 m and "2000 cm" was read as 20 m',
    ),
    (
        "span: {log: {from: 20 m, to: 40, count: 3}}",
        f'13:28: warning: sweep.span.log.to: {START}40 was read as 40 m and "20 m" was read as 20 m',
    ),
    (
        "car_body_mass: [20 t, 40, 60]\n  span: [30, 40, 50]\n  zip: [car_body_mass, span]",
        f'13:25: warning: sweep.car_body_mass: {START}40 was read as 40 kg and "20 t" was read as 20000 kg',
    ),
    (
        "sample: {kind: random, count: 3, over: {span: {triangular: [20 m, 30, 40]}}}",
        f'13:69: warning: sweep.sample.over.span.triangular: {START}30 was read as 30 m and "20 m" was read as 20 m',
    ),
    (
        "sample: {kind: random, count: 3, over: {velocity: {normal: [288 km/h, 5]}}}",
        f'13:73: warning: sweep.sample.over.velocity.normal: {START}5 was read as 5 m/s and "288 km/h" was read as 80 m/s',
    ),
    (
        "sample: {kind: random, count: 3, over: {velocity: {normal: [80, 5], within: [60, 324 km/h]}}}",
        f'13:63: warning: sweep.sample.over.velocity.normal: {START}80 was read as 80 m/s and "324 km/h" was read as 90 m/s',
    ),
]


def first_lines(warnings: tuple[str, ...]) -> list[str]:
    found = [text.splitlines()[0].removeprefix("case.yaml:") for text in warnings]
    return [line for line in found if START in line or "count" in line]


@pytest.mark.parametrize(("text", "warning"), MIXED)
def test_a_warning_and_with_strict_an_error(loads: Loads, says: Says, text: str, warning: str) -> None:
    case = f"{CASE}sweep:\n  {text}\n"
    assert first_lines(loads(case).warnings) == [warning]
    assert f"case.yaml:{warning.replace('warning: ', '')}" in says(case, strict=True).splitlines()


@pytest.mark.parametrize(
    "text",
    [
        "velocity: [20, 30, 40]",
        "velocity: [72 km/h, 30 m/s]",
        # 0 is 0 in every unit.
        "train.geometry.bogie_to_axle: [0, 8 cm]",
        "train.secondary.vertical.damping: {from: 0, to: 40 kN*s/m, step: 10 kN*s/m}",
        "modes: {from: 1, to: 4, step: 1}",
        "velocity: {from: 72 km/h, to: 90 km/h, count: 3}",
        "sample: {kind: random, count: 3, over: {velocity: {normal: [80, 5]}, span: {uniform: [20 m, 30 m]}}}",
    ],
)
def test_no_warning_where_all_are_alike(loads: Loads, text: str) -> None:
    assert first_lines(loads(f"{CASE}sweep:\n  {text}\n").warnings) == []


def test_lists_of_the_case_itself(loads: Loads, says: Says) -> None:
    stations = "bridge.stations=[12.5, 2000 mm, 0]"
    found = first_lines(loads(FORCES, overrides=[stations]).warnings)
    assert found == [
        f'1:51: warning: train.positions: {START}5 was read as 5 m and "2.5 m" was read as 2.5 m',
        f'1:72: warning: train.forces: {START}120000 was read as 120000 N and "180 kN" was read as 180000 N',
        f'--set {stations}: warning: bridge.stations: {START}12.5 was read as 12.5 m and "2000 mm" was read as 2 m',
    ]
    assert "train.forces" in says(FORCES, strict=True)
    fractions = "bridge.stations={fractions: [25 %, 0.5]}"
    found = first_lines(loads(FORCES.replace("5]", "5 m]"), overrides=[fractions]).warnings)
    assert found[1:] == [
        f'--set {fractions}: warning: bridge.stations.fractions: {START}0.5 was read as 0.5 and "25 %" was read as 0.25'
    ]


def test_a_vehicle_of_a_consist_and_a_profile(loads: Loads) -> None:
    consist = """\
train:
  consist:
    - {count: 2, spacing: 20, vehicle: {model: moving-load, positions: [0, 15 m, 17], forces: [1 kN, 2 kN, 3 kN]}}
bridge: verification-1
velocity: 9
"""
    assert first_lines(loads(consist).warnings) == [
        f'3:82: warning: train.consist.0.vehicle.positions: {START}17 was read as 17 m and "15 m" was read as 15 m'
    ]
    track = "track={irregularity: {profile: {x: [0, 5 m, 9 m], right: [0, 1 mm, 2e-3]}}}"
    assert first_lines(loads(CASE, overrides=[track]).warnings) == [
        f'--set {track}: warning: track.irregularity.profile.right: {START}0.002 was read as 0.002 m and "1 mm" was read as 0.001 m'
    ]


@pytest.mark.parametrize(
    ("options", "key"),
    [
        (("--values", "20,30,40 km/h"), "sweep.velocity"),
        (("--from", "20", "--to", "90 km/h", "--step", "1"), "sweep.velocity.from"),
    ],
)
def test_options_of_the_command_line(tmp_path: Path, options: tuple[str, ...], key: str) -> None:
    (tmp_path / "case.yaml").write_text(FORCES.replace("5]", "5 m]").replace("120000", "120 kN"))
    command = ("sweep", "velocity", "case.yaml", *options, "-q", "-o", "r.h5")
    ended = tbi(*command, "--strict", folder=tmp_path)
    assert (ended.code, ended.err.startswith(f"sweep velocity: {key}: {START}20 was read as")) == (2, True)
    assert not (tmp_path / "r.h5").exists()


def test_a_count_of_one_says_what_it_leaves_out(loads: Loads, says: Says) -> None:
    for form, key in (("{from: 20, to: 40, count: 1}", ""), ("{log: {from: 20, to: 40, count: 1}}", "log.")):
        text = f"{CASE}sweep:\n  velocity: {form}\n"
        case = loads(text)
        assert case.axes[0].values == (20.0,)
        (line,) = first_lines(case.warnings)
        assert line.endswith(f"velocity.{key}count: a count of 1 is the value 20 alone; 40, to, is left out")
        assert f"{key}count: a count of 1" in says(text, strict=True)
    assert loads(f"{CASE}sweep:\n  velocity: {{from: 20, to: 20, count: 1}}\n").warnings == ()


def test_python_is_told_as_well(loads: Loads) -> None:
    case = loads(CASE, extra_axis=ExtraAxis("span", values=[30, "4000 cm"]))
    assert first_lines(case.warnings) == [
        f'sweep span: warning: sweep.span: {START}30 was read as 30 m and "4000 cm" was read as 40 m'
    ]
