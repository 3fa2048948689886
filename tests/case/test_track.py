# ruff: noqa: E501 - messages are never wrapped, here neither.
"""Irregular rails in a case file: what is read, and what is said of mistakes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tbi_cli.case import load_case
from tbi_cli.report.stored_case import stored_case

from .conftest import CASE, Loads, Says

RANDOM = "track: {irregularity: {random: {spectrum: german-low}}}\n"


def track(irregularity: str, more: str = "") -> str:
    return f"{CASE}track:\n  irregularity: {{{irregularity}}}\n{more}"


def first_line(message: str) -> str:
    return message.splitlines()[0]


def test_defaults_are_those_of_the_spectrum(loads: Loads) -> None:
    case = loads(CASE + RANDOM)
    assert case.track is not None
    random = case.track.irregularity.random
    assert random is not None
    assert case.track.approach == 100
    assert (random.seed, random.coherence) == (1, "same")
    assert (random.shortest_wavelength, random.longest_wavelength) == (3, 150)
    assert case.resolved()["track"]["irregularity"]["random"]["longest_wavelength"] == 150


def test_level_rails_need_no_word(loads: Loads) -> None:
    """And a case without a track is what it was before there were tracks: its hash too."""
    case = loads()
    assert case.track is None
    assert "track" not in case.resolved()


def test_the_seed_is_an_axis(loads: Loads) -> None:
    case = loads(CASE + RANDOM + "sweep: {seed: {from: 1, to: 4, step: 1}}\n")
    (axis,) = case.axes
    assert (axis.name, axis.paths) == ("seed", ("track.irregularity.random.seed",))
    at = case.at({"seed": 3.0})
    assert at.track is not None
    assert at.track.irregularity.random is not None
    assert at.track.irregularity.random.seed == 3


def test_any_number_of_the_track_is_an_axis(loads: Loads) -> None:
    case = loads(
        track(
            "dip: {at: 0, length: 5 m, depth: 2 mm}", "sweep: {track.irregularity.dip.depth: [1 mm, 3 mm]}\n"
        )
    )
    assert case.axes[0].values == (0.001, 0.003)
    assert case.axes[0].name == "track_irregularity_dip_depth"


def test_a_csv_file_becomes_numbers(loads: Loads, folder: Path) -> None:
    """With units in the heading or in a cell; the case is complete without the file."""
    (folder / "rails.csv").write_text(
        "# measured\nx [m]; right [mm]; left [mm]\n-10;1.5;0\n0;2.5;-1 mm\n\n10;0.5;1\n"
    )
    case = loads(track("profile: {csv: rails.csv}"))
    assert case.track is not None
    profile = case.track.irregularity.profile
    assert profile is not None
    assert profile.x == (-10, 0, 10)
    assert profile.right == (1.5e-3, 2.5e-3, 0.5e-3)
    assert profile.left == (0, -1e-3, 1e-3)
    (folder / "rails.csv").unlink()
    again = stored_case(case.to_yaml())
    assert again == case
    assert again is not None
    assert again.sha256 == case.sha256


@pytest.mark.parametrize("heading", ["", "x, right\n", '"x (m)", "right (m)"\n'])
def test_two_columns_are_for_both_rails(loads: Loads, folder: Path, heading: str) -> None:
    (folder / "rails.csv").write_text(heading + "0, 0.001\n5 m, 2 mm\n")
    case = loads(track("profile: {csv: rails.csv}"))
    assert case.track is not None
    assert case.track.irregularity.profile is not None
    assert case.track.irregularity.profile.right == (0.001, 0.002)
    assert case.track.irregularity.profile.left == ()


@pytest.mark.parametrize(
    ("table", "message"),
    [
        (
            "x, level\n0, 1\n",
            'rails.csv:1:1: expected a heading with the columns x, right and left (or x and right), with their units if not SI, got "x, level"; lines that are neither heading nor numbers begin with #',
        ),
        ("x, right\n0, 0\n1\n", 'rails.csv:3:1: expected 2 values parted by commas, x, right, got "1"'),
        (
            "0, 0, 0, 0\n",
            'rails.csv:1:1: expected a heading with the columns x, right and left (or x and right), or 2 or 3 values, got "0, 0, 0, 0"; if the commas are decimal signs, part the columns with semicolons or tabs',
        ),
        ("x, right\n", "rails.csv:1:1: expected lines of x, right and left (or x and right), got none"),
        (
            "x, right\n0, 0\n1, high\n",
            'rails.csv:3:4: track.irregularity.profile.right.1: expected a length, e.g. "1 mm" or 0.001, got "high"',
        ),
        (
            "x [s], right\n0, 0\n1, 0\n",
            'rails.csv:1:1: expected the unit of a length, e.g. x [m], got "x [s]" ("s" is a time)',
        ),
        (
            "x, right\n" + "".join(f"{k}, 0\n" for k in range(10_001)),
            "rails.csv:10002:1: expected at most 10000 points",
        ),
    ],
)
def test_what_is_wrong_with_a_csv_file(says: Says, folder: Path, table: str, message: str) -> None:
    (folder / "rails.csv").write_text(table)
    assert first_line(says(track("profile: {csv: rails.csv}"))) == message


@pytest.mark.parametrize(
    ("irregularity", "message"),
    [
        (
            "profile: {csv: rails.csv}",
            "case.yaml:13:28: track.irregularity.profile.csv: rails.csv: no such file",
        ),
        (
            "profile: {csv: rails.csv, x: [0, 1]}",
            "case.yaml:13:28: track.irregularity.profile.csv: expected either csv, or x, right and left, got csv and x",
        ),
        (
            "",
            "case.yaml:13:3: track.irregularity: expected one or more of ramp, dip, half_sine, harmonic, random, profile, got none of them",
        ),
        (
            "bump: {at: 0}",
            "case.yaml:13:18: track.irregularity.bump: unknown key; known here: ramp, dip, half_sine, harmonic, random, profile",
        ),
        (
            "random: {spectrum: german}",
            'case.yaml:13:27: track.irregularity.random.spectrum: expected one of german-low, german-high, fra-1, fra-2, fra-3, fra-4, fra-5, fra-6, got "german"',
        ),
        (
            "random: {spectrum: fra-6, coherence: none}",
            'case.yaml:13:44: track.irregularity.random.coherence: expected one of same, independent, cross-level, got "none"',
        ),
        (
            "random: {spectrum: fra-6, seed: -1}",
            "case.yaml:13:44: track.irregularity.random.seed: expected a whole number from 0 to 4294967295, got -1",
        ),
        (
            "random: {spectrum: fra-6, shortest_wavelength: 20, longest_wavelength: 20}",
            "case.yaml:13:44: track.irregularity.random.shortest_wavelength: expected 0.05 to 18 m, 0.9 of the longest wavelength, got 20 m",
        ),
        (
            "dip: {at: -200, length: 5, depth: 1 mm}",
            "case.yaml:13:24: track.irregularity.dip.at: expected a place on the approach, -100 m, or after it, got -200 m",
        ),
        (
            "dip: {at: 0, length: 0, depth: 1 mm}",
            'case.yaml:13:31: track.irregularity.dip.length: expected a positive length, e.g. "5 m" or 5, got 0',
        ),
        (
            "harmonic: {wavelength: 1 mm, amplitude: 1 mm}",
            "case.yaml:12:1: track: expected at most 1.5625 m of track with waves of 0.001 m on it, got 250 m",
        ),
        (
            "harmonic: {wavelength: 10}",
            'case.yaml:13:18: track.irregularity.harmonic.amplitude: missing; expected a positive length, e.g. "2 mm" or 0.002',
        ),
        (
            "profile: {x: [0, 1, 1], right: [0, 0, 0]}",
            "case.yaml:13:38: track.irregularity.profile.x.2: expected places that rise from point to point, or fall, each of them once, got 1 after 1",
        ),
        (
            "profile: {x: [9, 4, 5], right: [0, 0, 0]}",
            "case.yaml:13:38: track.irregularity.profile.x.2: expected places that rise from point to point, or fall, each of them once, got 5 after 4",
        ),
        (
            "profile: {x: [0, 1], right: [0]}",
            "case.yaml:13:18: track.irregularity.profile: expected one level in right for each of the 2 places, got 1",
        ),
        (
            "profile: {x: [0, 1, 2, 50], right: [0, 0, 1 mm, 1 mm]}",
            "case.yaml:13:18: track.irregularity.profile: expected closer points between 2 and 50 m: a smooth rail through them goes to 0.00947674 m",
        ),
    ],
)
def test_mistakes(says: Says, irregularity: str, message: str) -> None:
    assert first_line(says(track(irregularity))) == message


def test_waves_need_an_approach(says: Says) -> None:
    text = CASE + "track: {approach: 0, irregularity: {harmonic: {wavelength: 5, amplitude: 1 mm}}}\n"
    assert first_line(says(text)) == (
        "case.yaml:12:9: track.approach: expected more than 0, as waves and measured rails begin level on the approach, got 0"
    )


def test_a_swept_place_may_not_leave_the_approach(says: Says) -> None:
    text = track("dip: {at: 0, length: 5, depth: 1 mm}", "sweep: {track.irregularity.dip.at: [0, -150, 3]}\n")
    assert first_line(says(text)) == (
        "case.yaml:14:9: sweep.track.irregularity.dip.at: track.irregularity.dip.at: expected a place on the approach, -100 m, or after it, got -150 m"
    )


PROFILE = "x: [123400, 123450, 123500], right: [0, 1 mm, 0]"


@pytest.mark.parametrize(
    ("irregularity", "more", "message"),
    [
        (
            "dip: {at: 350, length: 5, depth: 1 mm}",
            "",
            "case.yaml:13:24: track.irregularity.dip.at: expected a place before 350 m, as far as the first axle comes (solver.duration), got 350 m",
        ),
        (
            f"profile: {{{PROFILE}}}",
            "",
            "case.yaml:13:18: track.irregularity.profile: expected points between -100 and 150 m, where a train meets them, got 123400 to 123500 m; start is the x at which the bridge begins",
        ),
        (
            f"profile: {{start: 133.42 km, {PROFILE}}}",
            "",
            "case.yaml:13:18: track.irregularity.profile: expected points between 133320 and 133570 m, where a train meets them, got 123400 to 123500 m; start is the x at which the bridge begins",
        ),
        (
            f"profile: {{start: 123.345678 km, {PROFILE}}}",
            "solver: {duration: 0.5}\n",
            "case.yaml:13:18: track.irregularity.profile: expected points between 123245.678 and 123380.678 m, where a train meets them, got 123400 to 123500 m; start is the x at which the bridge begins",
        ),
        (
            f"profile: {{start: 123.42 km, {PROFILE}}}",
            "sweep: {track.irregularity.profile.start: [123.42 km, 124 km]}\n",
            "case.yaml:14:9: sweep.track.irregularity.profile.start: track.irregularity.profile: expected points between 123900 and 124150 m, where a train meets them, got 123400 to 123500 m; start is the x at which the bridge begins",
        ),
        (
            "dip: {at: 100, length: 5, depth: 1 mm}",
            "sweep: {solver.duration: [1, 3]}\n",
            "case.yaml:14:9: sweep.solver.duration: track.irregularity.dip.at: expected a place before 70 m, as far as the first axle comes (solver.duration), got 100 m",
        ),
    ],
)
def test_rails_that_no_wheel_meets_are_refused(
    says: Says, irregularity: str, more: str, message: str
) -> None:
    """The bridge ends at 50 m, the track at 150 m; the first axle comes to 5 x (50 + 20) m."""
    assert first_line(says(track(irregularity, more))) == message


@pytest.mark.parametrize(
    ("irregularity", "more", "warning"),
    [
        (
            "half_sine: {at: 348, length: 5, height: 1 mm}",
            "",
            "case.yaml:13:18: warning: track.irregularity.half_sine: met only in part: it ends at 353 m, behind 350 m, as far as the first axle comes (solver.duration)",
        ),
        (
            "profile: {start: 123.42 km, x: [123300, 123450, 123500], right: [0, 1 mm, 0]}",
            "",
            "case.yaml:13:18: warning: track.irregularity.profile: met only in part: its points go from 123300 to 123500 m, the train from 123320 to 123570 m",
        ),
        (
            f"profile: {{{PROFILE}}}",
            "sweep: {track.irregularity.profile.start: [123.42 km, 123.52 km]}\n",
            "case.yaml:14:9: warning: sweep.track.irregularity.profile.start: track.irregularity.profile: met only in part: its points go from 123400 to 123500 m, the train from 123420 to 123670 m",
        ),
        ("dip: {at: 200, length: 5, depth: 1 mm}", "", None),
        (f"profile: {{start: 123.42 km, {PROFILE}}}", "", None),
    ],
)
def test_rails_that_are_met_only_in_part_are_odd(
    loads: Loads, says: Says, irregularity: str, more: str, warning: str | None
) -> None:
    text = track(irregularity, more)
    assert [first_line(found) for found in loads(text).warnings] == ([warning] if warning else [])
    if warning:
        assert first_line(says(text, strict=True)) == warning.replace("warning: ", "")


def test_a_profile_counts_from_its_own_origin_and_either_way(loads: Loads, folder: Path) -> None:
    """`start` is an axis like others, and absent where it is not given: the hash of older cases stands."""
    (folder / "rails.csv").write_text("x [km]; right [mm]\n123.5; 1\n123.46; 3\n123.4; 2\n")
    case = loads(track("profile: {csv: rails.csv, start: 123.42 km}"))
    assert case.track is not None
    profile = case.track.irregularity.profile
    assert profile is not None
    places, right, left = profile.points
    assert places == pytest.approx((-20, 40, 80), abs=1e-9)
    assert right == left == (2e-3, 3e-3, 1e-3)
    assert stored_case(case.to_yaml()) == case
    assert "start" not in loads(track("profile: {x: [0, 9], right: [0, 1 mm]}")).to_yaml()


def test_constant_forces_do_not_feel_rails(says: Says) -> None:
    text = (CASE + RANDOM).replace("train: paper", "train: {model: moving-load, forces: [1 kN]}")
    text = "\n".join(line for line in text.splitlines() if "left:" not in line)
    assert first_line(says(text)) == (
        "case.yaml:11:1: track: not for a moving-load train, whose forces do not feel the rails"
    )


def test_a_band_beyond_the_spectrum_is_odd(loads: Loads) -> None:
    case = loads(track("random: {spectrum: german-low, shortest_wavelength: 1}"))
    assert [warning.splitlines()[0] for warning in case.warnings] == [
        "case.yaml:13:49: warning: track.irregularity.random.shortest_wavelength: 1 m is outside the 3 to 150 m for which german-low holds"
    ]


def test_a_case_with_ten_thousand_points(loads: Loads, folder: Path) -> None:
    """The largest there may be is read, kept as text, and read back the same."""
    x = np.round(np.arange(10_000) * 0.25 - 1000, 2)
    level = 1e-3 * np.sin(x / 3)
    rows = "\n".join(f"{a},{b!r}" for a, b in zip(x.tolist(), level.tolist(), strict=True))
    (folder / "rails.csv").write_text(rows)
    case = loads(track("profile: {csv: rails.csv}"))
    assert stored_case(case.to_yaml()) == case
    assert load_case("case.yaml") == case
