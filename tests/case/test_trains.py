# ruff: noqa: E501 - messages are never wrapped, here neither.
"""Axle lists, the trains HSLM-A, consists, and what is asked of a bridge: what is read, and every mistake."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tbi_cli.case import AxleForces, Consist, HslmA, load_case
from tests.cli.commands import tbi

from .conftest import Loads, Says

BRIDGE = """\
bridge:
  length: 20 m
  right: {youngs_modulus: 30 GPa, second_moment: 0.3, mass_per_length: 10 t/m, damping: {ratio: 1 %}}
velocity: 40
"""
SPRUNG = "{model: sprung-mass, mass: 1 t, stiffness: 1e6, damping: 0}"
RIGID = "{model: rigid-beam, mass: 1 t, pitch_inertia: 1e4, support_distance: 12, stiffness: 1e6, damping: 0}"
LOADS = "{model: moving-load, forces: [1e5, 1e5, 1e5], positions: [0, 3, 5]}"
CSV = "{model: axle-forces, csv: axles.csv}"
HSLM = "{model: hslm-a, number: 1}"


def case(train: str, more: str = "") -> str:
    return f"train: {train}\n{BRIDGE}{more}"


@pytest.mark.parametrize(
    ("number", "N", "D", "d", "P"),
    [
        (1, 18, 18, 2.0, 170e3),
        (2, 17, 19, 3.5, 200e3),
        (3, 16, 20, 2.0, 180e3),
        (4, 15, 21, 3.0, 190e3),
        (5, 14, 22, 2.0, 170e3),
        (6, 13, 23, 2.0, 180e3),
        (7, 13, 24, 2.0, 190e3),
        (8, 12, 25, 2.5, 190e3),
        (9, 11, 26, 2.0, 210e3),
        (10, 11, 27, 2.0, 210e3),
    ],
)
def test_the_trains_hslm_a(number: int, N: int, D: float, d: float, P: float) -> None:
    """EN 1991-2, 6.4.6.1.1 and table 6.3: 2 N + 14 axles over 37.525 m + (N + 2) D, symmetric, all with P."""
    train = load_case(
        "paper",
        overrides=[f"train=trains/hslm-a{number}.yaml", "bridge.left=null", "contact.static_load=physical"],
    ).train
    assert isinstance(train, HslmA)
    axles = [0.0, 3.0, 14.0, 17.0, 20.525, 20.525 + d]
    for i in range(1, N + 2):
        axles += [18.7625 + i * D - d / 2, 18.7625 + i * D + d / 2]
    length = 37.525 + (N + 2) * D
    axles += [length - x for x in (20.525 + d, 20.525, 17.0, 14.0, 3.0, 0.0)]
    assert len(axles) == 2 * N + 14
    assert np.allclose(train.positions, axles, rtol=0, atol=1e-12)
    assert np.allclose(np.array(train.positions), length - np.array(train.positions[::-1]), atol=1e-12)
    assert train.forces == (P,) * len(axles)
    assert train.coach_length == D


def test_axles_from_a_csv_file(loads: Loads, folder: Path) -> None:
    """Comment, heading in quotes, units, an empty line."""
    text = '# measured\n"position (m)";"force"\n0;"170 kN"\n\n250 cm;1.2e5\n 3.0 ; 56.4 kN \n'
    (folder / "axles.csv").write_text(text)
    train = loads(case(CSV)).train
    assert isinstance(train, AxleForces)
    assert train.positions == (0.0, 2.5, 3.0)
    assert train.forces == (170e3, 1.2e5, 56.4e3)
    # What the results file keeps of the case needs the file no more.
    (folder / "axles.csv").unlink()
    kept = loads(
        case(CSV).replace(
            CSV, "{model: axle-forces, forces: [170 kN, 120 kN, 56.4 kN], positions: [0, 2.5, 3]}"
        )
    )
    assert kept.train == train


def test_a_csv_file_lies_beside_the_file_that_names_it(loads: Loads, folder: Path) -> None:
    (folder / "trains").mkdir()
    (folder / "trains" / "mine.yaml").write_text("model: axle-forces\ncsv: axles.csv\n")
    (folder / "trains" / "axles.csv").write_text("0,1e5\n4,2e5\n")
    for train in ("trains/mine.yaml", "{consist: [{vehicle: trains/mine.yaml, spacing: 6, count: 2}]}"):
        found = loads(case(train)).train
        vehicle = found.consist[0].vehicle if isinstance(found, Consist) else found
        assert isinstance(vehicle, AxleForces)
        assert vehicle.positions == (0.0, 4.0)


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        ("", "axles.csv:1:1: expected lines of position (or spacing) and force, got none"),
        ("position, force\n", "axles.csv:1:1: expected lines of position (or spacing) and force, got none"),
        (
            "0, 170 kN\n3\n",
            'axles.csv:2:1: expected 2 values parted by commas, position, force, got "3"',
        ),
        (
            "0, 1e5, 3\n",
            'axles.csv:1:1: expected a heading with the columns position (or spacing) and force, or 2 values, got "0, 1e5, 3"; if the commas are decimal signs, part the columns with semicolons or tabs',
        ),
        ("0, 1e5\n3, ", 'axles.csv:2:1: expected 2 values parted by commas, position, force, got "3,"'),
        (
            "0, 1e5\n3, abc\n",
            'axles.csv:2:4: train.forces.1: expected a force >= 0, e.g. "56.4 kN" or 56400, got "abc"',
        ),
        (
            "0, 1e5\n3, -4\n",
            'axles.csv:2:4: train.forces.1: expected a force >= 0, e.g. "56.4 kN" or 56400, got -4 (a force acts downward: change the sign)',
        ),
        (
            "0, 1e5\n3 kN, 4\n",
            'axles.csv:2:1: train.positions.1: expected a length, e.g. "2.5 m" or 2.5, got "3 kN" ("kN" is a force)',
        ),
        (
            "0, 1\n3, 1\n2, 1\n",
            "axles.csv:1:1: train.positions: expected positions in rising order, got 2 (number 3) after 3",
        ),
        ("0, 1\n" * 1001, "axles.csv:1001:1: expected at most 1000 forces"),
    ],
    ids=[
        "empty",
        "heading",
        "one value",
        "three",
        "half",
        "no number",
        "negative",
        "unit",
        "order",
        "many",
    ],
)
def test_a_bad_csv_file(says: Says, folder: Path, lines: str, message: str) -> None:
    (folder / "axles.csv").write_text(lines)
    assert says(case(CSV)).splitlines()[0] == message


@pytest.mark.parametrize(
    ("train", "message"),
    [
        (CSV, "case.yaml:1:29: train.csv: axles.csv: no such file"),
        ("{model: axle-forces, csv: 3}", "case.yaml:1:29: train.csv: expected a text of one line, at most 1000 characters, got 3 (put it in quotes)"),
        ("{model: axle-forces, csv: a.csv, forces: [1]}", "case.yaml:1:29: train.csv: expected either csv, or positions and forces, got csv and forces"),
        ("{model: hslm-a, number: 11}", "case.yaml:1:24: train.number: expected a whole number from 1 to 10, got 11"),
        ("{model: hslm-a}", "case.yaml:1:1: train.number: missing; expected a whole number from 1 to 10"),
        ("{consist: []}", "case.yaml:1:1: train: expected 1 to 200 vehicles in all, got 0"),
        ("{consist: 3}", "case.yaml:1:9: train.consist: expected a list, each a mapping with the keys vehicle, count, spacing, front_overhang, rear_overhang, got 3"),
        ("{consist: [7]}", "case.yaml:1:19: train.consist.0: expected a mapping with the keys vehicle, count, spacing, front_overhang, rear_overhang, got 7"),
        ("{consist: [{spacing: 10}]}", "case.yaml:1:19: train.consist.0.vehicle: missing; expected a file, a built-in train or a mapping"),
        ("{consist: [{vehicle: 7, spacing: 10}]}", "case.yaml:1:20: train.consist.0.vehicle: expected a file, a built-in train or a mapping, got 7"),
        (f"{{consist: [{{vehicle: {SPRUNG}}}]}}", "case.yaml:1:19: train.consist.0: missing; expected spacing, or both front_overhang and rear_overhang"),
        (f"{{consist: [{{vehicle: {RIGID}, front_overhang: 2}}]}}", "case.yaml:1:19: train.consist.0: missing; expected spacing, or both front_overhang and rear_overhang"),
        (f"{{consist: [{{vehicle: {RIGID}, front_overhang: 2, rear_overhang: 3, spacing: 18}}]}}", "case.yaml:1:19: train.consist.0: expected a spacing of 17 m, as front_overhang, 12 m from the first axle to the last, and rear_overhang add up to, got 18 m; it may be left out"),
        (f"{{consist: [{{vehicle: {RIGID}, rear_overhang: 5, spacing: 16}}]}}", "case.yaml:1:19: train.consist.0: expected a rear_overhang of at most 4 m, which spacing leaves beside 12 m from the first axle to the last, got 5 m"),
        (f"{{consist: [{{vehicle: {RIGID}, front_overhang: 0, rear_overhang: 0}}]}}", "case.yaml:1:19: train.consist.0: expected a spacing of more than 12 m, from the first axle to the last, got 12 m"),
        (f"{{consist: [{{vehicle: {RIGID}, front_overhang: -1 m, spacing: 20}}]}}", 'case.yaml:1:131: train.consist.0.front_overhang: expected a length >= 0, e.g. "2.5 m" or 2.5, got "-1 m"'),
        (f"{{consist: [{{vehicle: {RIGID}, spacing: 12}}]}}", "case.yaml:1:19: train.consist.0: expected a spacing of more than 12 m, from the first axle to the last, got 12 m"),
        ("{consist: [{vehicle: {model: moving-load, forces: [1e4, 1e4], positions: [7, 9]}, spacing: 2}]}", "case.yaml:1:19: train.consist.0: expected a spacing of more than 2 m, from the first axle to the last, got 2 m"),
        (f"{{consist: [{{spacing: 500, count: 0, vehicle: {HSLM}}}]}}", "case.yaml:1:34: train.consist.0.count: expected a whole number from 1 to 200, got 0"),
        (f"{{consist: [{{spacing: 5, count: 150, vehicle: {SPRUNG}}}, {{spacing: 5, count: 51, vehicle: {SPRUNG}}}]}}", "case.yaml:1:1: train: expected 1 to 200 vehicles in all, got 201"),
        (f"{{consist: [{{spacing: 5, vehicle: {SPRUNG}}}, {{spacing: 25, vehicle: paper}}]}}", "trains/paper.yaml (built-in):7:1: train.consist.1.vehicle.model: the first vehicle runs on bridge.right alone, a full-31dof on both beams; they cannot run in one train"),
        ("{consist: [{vehicle: velaro-e-8, spacing: 300}]}", 'trains/velaro-e-8.yaml (built-in):7:1: train.consist.0.vehicle.model: expected one of full-31dof, sprung-mass, rigid-beam, moving-load, axle-forces, hslm-a, got "consist"'),
        ("{consist: [{vehicle: paper, spacing: 25}]}", "case.yaml:2:1: bridge.left: missing; a consist of full-31dof vehicles needs both beams"),
    ],
)  # fmt: skip
def test_a_bad_train(says: Says, train: str, message: str) -> None:
    assert says(case(train)).splitlines()[0] == message
    assert says(case(train)).count("case.yaml:") + says(case(train)).count("(built-in):") == 1


@pytest.mark.parametrize(
    ("train", "more", "message"),
    [
        (SPRUNG, "solver: {method: exact}\n", "case.yaml:6:10: solver.method: expected rk4, got exact (exact is for moving-load, axle-forces, hslm-a, not for sprung-mass)"),
        (HSLM, "solver: {method: exact, substeps: 4}\n", "case.yaml:6:25: solver.substeps: expected auto, as the steps of the method exact have no error"),
        (HSLM, "solver: {method: exactly}\n", 'case.yaml:6:10: solver.method: expected one of rk4, exact, got "exactly"'),
        (HSLM, "output: {coaches: some}\n", 'case.yaml:6:10: output.coaches: expected one of extremes, each, got "some"'),
        (HSLM, "track: {irregularity: {dip: {depth: 1 mm, start: 0, length: 2}}}\n", "case.yaml:6:1: track: not for an hslm-a train, whose forces do not feel the rails"),
        (HSLM, "contact: {static_load: paper}\n", "case.yaml:6:11: contact.static_load: expected physical, got paper (Eq. 13a is for full-31dof, not for hslm-a)"),
        (HSLM, "sweep:\n  train.number: [1, 11]\n", "case.yaml:7:21: sweep.train.number: expected a whole number from 1 to 10, got 11"),
        (LOADS, "sweep:\n  train.positions.1: [2, 7]\n", "case.yaml:7:3: sweep.train.positions.1: expected positions in rising order, got 5 (number 3) after 7"),
        (LOADS, "sweep:\n  train.positions.0: [0, 4]\n", "case.yaml:7:3: sweep.train.positions.0: expected positions in rising order, got 3 (number 2) after 4"),
        (LOADS, "sweep:\n  train.positions.3: [6, 7]\n", "case.yaml:7:3: sweep.train.positions.3: train.positions has no 3; counted from 0, there is 0 to 2"),
        (f"{{consist: [{{vehicle: {LOADS}, spacing: 30}}]}}", "sweep:\n  train.consist.0.vehicle.positions.2: [5, 31]\n", "case.yaml:7:3: sweep.train.consist.0.vehicle.positions.2: expected a spacing of more than 31 m, from the first axle to the last, got 30 m"),
        (f"{{consist: [{{vehicle: {RIGID}, spacing: 15}}]}}", "sweep:\n  train.consist.0.spacing: [15, 11]\n", "case.yaml:7:3: sweep.train.consist.0.spacing: expected a spacing of more than 12 m, from the first axle to the last, got 11 m"),
        (f"{{consist: [{{vehicle: {RIGID}, rear_overhang: 1, spacing: 15}}]}}", "sweep:\n  train.consist.0.rear_overhang: [1, 3.5]\n", "case.yaml:7:3: sweep.train.consist.0.rear_overhang: expected a rear_overhang of at most 3 m, which spacing leaves beside 12 m from the first axle to the last, got 3.5 m"),
        (f"{{consist: [{{vehicle: {RIGID}, spacing: 15}}]}}", "sweep:\n  train.consist.1.spacing: [15, 16]\n", "case.yaml:7:3: sweep.train.consist.1.spacing: train.consist has no 1; counted from 0, there is 0 alone"),
        (f"{{consist: [{{vehicle: {SPRUNG}, spacing: 15}}]}}", "sweep:\n  train.consist.0.count: [1, 201]\n", "case.yaml:7:30: sweep.train.consist.0.count: expected a whole number from 1 to 200, got 201"),
    ],
)  # fmt: skip
def test_what_does_not_go_together(says: Says, train: str, more: str, message: str) -> None:
    assert says(case(train, more)).splitlines()[0] == message


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("stations: []", "expected a list of positions, or {fractions: [...]}, and at least one of them"),
        ("stations: {positions: [1], fractions: [0.5]}", "expected a list of positions, or {fractions: [...]}, and at least one of them"),
        ("stations: [21 m]", "expected positions on the span of 20 m, got 21 m"),
        ("low_pass: en1990", 'expected a positive frequency, e.g. "30 Hz" or 30, or none, or en-1990, got "en1990"'),
        ("low_pass: 0", 'expected a positive frequency, e.g. "30 Hz" or 30, or none, or en-1990, got 0'),
        ("low_pass: 30 s", 'expected a positive frequency, e.g. "30 Hz" or 30, or none, or en-1990, got "30 s" ("s" is a time)'),
    ],
)  # fmt: skip
def test_what_is_asked_of_a_bridge(says: Says, line: str, message: str) -> None:
    text = case(HSLM).replace("length: 20 m\n", f"length: 20 m\n  {line}\n")
    assert says(text).splitlines()[0] == f"case.yaml:4:3: bridge.{line.partition(':')[0]}: {message}"


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("stations: [1, -1]", 'case.yaml:4:3: bridge.stations.positions.1: expected a length >= 0, e.g. "12.5 m" or 12.5, got -1'),
        ("stations: {fractions: [1.2]}", 'case.yaml:4:26: bridge.stations.fractions.0: expected a ratio >= 0, e.g. "25 %" or 0.25, got 1.2 (larger than 1)'),
        ("stations: {fraction: [0.5]}", "case.yaml:4:14: bridge.stations.fraction: unknown key; did you mean fractions?"),
        ("stations: 7", 'case.yaml:4:3: bridge.stations.positions: expected a list, each a length >= 0, e.g. "12.5 m" or 12.5, got 7'),
        (f"stations: [{', '.join(['1'] * 101)}]", "case.yaml:4:3: bridge.stations.positions: expected at most 100 values in this list, got 101"),
    ],
)  # fmt: skip
def test_bad_stations(says: Says, line: str, message: str) -> None:
    assert says(case(HSLM).replace("length: 20 m\n", f"length: 20 m\n  {line}\n")).splitlines()[0] == message


def test_stations_beyond_the_shortest_of_the_spans(says: Says) -> None:
    text = case(HSLM, "sweep: {span: [20, 15, 19]}\n").replace(
        "length: 20 m\n", "length: 20 m\n  stations: [18]\n"
    )
    assert (
        says(text).splitlines()[0]
        == "case.yaml:4:3: bridge.stations: expected positions on the span of 15 m, got 18 m"
    )


@pytest.mark.parametrize(
    ("axis", "message"),
    [
        ("{from: 40, to: 120, step: 2, refine: resonanc}", '42: sweep.velocity.refine: expected resonance, got "resonanc"'),
        ("{from: 40, to: 120, step: 2, refine: resonance, tolerance: 0}", '61: sweep.velocity.tolerance: expected a positive ratio, e.g. "1 %" or 0.01, got 0'),
        ("{from: 40, to: 120, step: 2, refine: resonance, tolerance: 2}", '61: sweep.velocity.tolerance: expected a positive ratio, e.g. "1 %" or 0.01, got 2 (larger than 1)'),
        ("{from: 40, to: 120, step: 200, refine: resonance}", "33: sweep.velocity.step: expected a positive step, smaller than from to"),
        ("{from: 120, to: 40, step: -2, refine: resonance}", "33: sweep.velocity.step: expected a positive step, smaller than from to"),
        ("{from: 40, to: 120, count: 20, refine: resonance}", "3: sweep.velocity: expected {from, to, step, refine} and perhaps tolerance and channels, got {from, to, count, refine}"),
        ("{from: 40, to: 120, step: 2, refine: resonance, tol: 1}", "3: sweep.velocity: expected {from, to, step, refine} and perhaps tolerance and channels, got {from, to, step, refine, tol}"),
        ("{from: 40, to: 120, step: 0.0001, refine: resonance}", "33: sweep.velocity.step: expected at most 500000 values in all axes together, got 800001"),
        ("{from: 40, to: 120, step: 2, refine: resonance, channels: []}", "61: sweep.velocity.channels: expected all, or a list of channel names such as [car_body_y, right_midspan], got an empty list"),
    ],
)  # fmt: skip
def test_a_bad_refinement(says: Says, axis: str, message: str) -> None:
    expected = f"case.yaml:7:{message}"
    assert says(case(HSLM, f"sweep:\n  velocity: {axis}\n")).splitlines()[0] == expected


def test_only_the_velocity_is_refined(says: Says) -> None:
    text = case(HSLM, "sweep:\n  span: {from: 10, to: 20, step: 1, refine: resonance}\n")
    assert (
        says(text).splitlines()[0]
        == "case.yaml:7:37: sweep.span.refine: unknown key; known here: from, to, step, count, log"
    )


@pytest.mark.parametrize(
    ("more", "message"),
    [
        (
            "sweep:\n  velocity: {from: 40, to: 60, step: 2, refine: resonance, channels: [car_body_y]}\n",
            "case.yaml:7:60: sweep.velocity.channels: expected some of right_midspan, right_midspan_acceleration; got car_body_y",
        ),
        (
            "solver: {sampling: 0.02}\nsweep:\n  velocity: [40, 60]\n",
            "case.yaml:7:10: solver.sampling at velocity = 40 m/s: expected at most 0.01666 s, 4 samples in a period of 15 Hz (bridge.low_pass), got 0.02 s",
        ),
    ],
    ids=["unknown channel", "samples too far apart"],
)  # fmt: skip
def test_what_is_found_out_before_the_run(folder: Path, more: str, message: str) -> None:
    """Exit code 2, nothing printed, no results file."""
    text = case(HSLM, more)
    if "sampling" in more:
        text = text.replace("length: 20 m\n", "length: 20 m\n  low_pass: 15 Hz\n")
    (folder / "case.yaml").write_text(text)
    for command in ("run", "validate"):
        ended = tbi(command, "case.yaml", folder=folder)
        assert (ended.code, ended.out, ended.err.splitlines()[0]) == (2, "", message)
    assert [path.name for path in folder.iterdir()] == ["case.yaml"]


def test_what_a_refined_sweep_may_cost(folder: Path) -> None:
    """At least the steps of the axis, at most 32 parts of each and what peaks need beyond."""
    (folder / "case.yaml").write_text(
        case(HSLM, "sweep:\n  velocity: {from: 40, to: 60, step: 2, refine: resonance}\n")
    )
    lines = tbi("validate", "case.yaml", folder=folder).out.splitlines()
    assert "axis       velocity: 11 to about 321 values, 40 to 60 m/s" in lines
    assert "scenarios  at most about 321" in lines
    assert any(line.startswith("steps      at most about ") for line in lines)


def test_odd_numbers_of_a_vehicle_in_a_train(loads: Loads) -> None:
    text = case(f"{{consist: [{{vehicle: {SPRUNG}, spacing: 10}}, {{vehicle: {SPRUNG}, spacing: 10}}]}}")
    assert loads(text).warnings == ()
    head, _, tail = text.rpartition("1 t")
    (warning,) = loads(f"{head}0.1{tail}").warnings
    assert warning.splitlines()[0] == (
        "case.yaml:1:135: warning: train.consist.1.vehicle.mass: 0.1 kg is outside the usual 1 to 1e6 kg; "
        'was "0.1 t" meant?'
    )
