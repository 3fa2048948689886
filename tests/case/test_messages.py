# ruff: noqa: E501 - messages are never wrapped, here neither.
"""Every kind of mistake in a case file has one exact message, with its place."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from tbi_cli.case import CaseError, load_case

from .conftest import CASE, Loads, Says


def changed(old: str, new: str) -> str:
    assert CASE.count(old) == 1, old
    return CASE.replace(old, new)


def first_line(message: str) -> str:
    return message.splitlines()[0]


def test_a_wrong_unit_is_shown_with_its_line_and_a_caret(says: Says) -> None:
    assert says(changed("207 GPa", "207 GPx")) == (
        'case.yaml:6:5: bridge.right.youngs_modulus: expected a positive pressure, e.g. "207 GPa" or 2.07e11, '
        'got "207 GPx" (no unit "GPx")\n'
        "    6 |     youngs_modulus: 207 GPx\n"
        "      |     ^               ~~~~~~~"
    )


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        pytest.param(
            "second_moment: 0.2\n",
            "second_moment: 0.2 m\n",
            'case.yaml:7:5: bridge.right.second_moment: expected a positive second moment of area, e.g. "0.2 m^4" '
            'or 0.2, got "0.2 m" ("m" is a length)',
            id="wrong dimension",
        ),
        pytest.param(
            "length: 50 m",
            "length: 0",
            'case.yaml:3:3: bridge.length: expected a positive length, e.g. "50 m" or 50, got 0',
            id="zero span",
        ),
        pytest.param(
            "velocity: 300 km/h",
            "velocity: -5",
            'case.yaml:11:1: velocity: expected a positive speed, e.g. "300 km/h" or 83.3333, got -5',
            id="negative velocity",
        ),
        pytest.param(
            "velocity: 300 km/h",
            "velocity: 0",
            'case.yaml:11:1: velocity: expected a positive speed, e.g. "300 km/h" or 83.3333, got 0',
            id="no velocity",
        ),
        pytest.param(
            "velocity: 300 km/h",
            "velocity: true",
            'case.yaml:11:1: velocity: expected a positive speed, e.g. "300 km/h" or 83.3333, got true',
            id="boolean for a number",
        ),
        pytest.param(
            "velocity: 300 km/h",
            "velocity: .nan",
            'case.yaml:11:1: velocity: expected a positive speed, e.g. "300 km/h" or 83.3333, got .nan',
            id="not a number",
        ),
        pytest.param(
            "velocity: 300 km/h",
            "velocity: .inf",
            'case.yaml:11:1: velocity: expected a positive speed, e.g. "300 km/h" or 83.3333, got .inf',
            id="infinite",
        ),
        pytest.param(
            "velocity: 300 km/h",
            "velocity: 1e999",
            'case.yaml:11:1: velocity: expected a positive speed, e.g. "300 km/h" or 83.3333, got .inf',
            id="more than a float holds",
        ),
        pytest.param(
            "velocity: 300 km/h",
            "velocity: 1e20",
            'case.yaml:11:1: velocity: expected a positive speed, e.g. "300 km/h" or 83.3333, got 1e20 '
            "(larger than 1e15)",
            id="too large for anything",
        ),
        pytest.param(
            "velocity: 300 km/h",
            "velocity: 300km",
            'case.yaml:11:1: velocity: expected a positive speed, e.g. "300 km/h" or 83.3333, got "300km" '
            '("km" is a length)',
            id="unit without space",
        ),
        pytest.param(
            "velocity: 300 km/h",
            "velocity:",
            'case.yaml:11:1: velocity: expected a positive speed, e.g. "300 km/h" or 83.3333, got nothing',
            id="nothing",
        ),
        pytest.param(
            "velocity: 300 km/h",
            "velocity: [1]",
            'case.yaml:11:1: velocity: expected a positive speed, e.g. "300 km/h" or 83.3333, got a list',
            id="a list",
        ),
        pytest.param(
            "velocity: 300 km/h",
            "gravity: 9.8",
            'case.yaml:1:1: velocity: missing; expected a positive speed, e.g. "300 km/h" or 83.3333',
            id="missing key",
        ),
        pytest.param(
            "    damping: 10 kN*s/m^2\n",
            "    damping: 2 %\n",
            'case.yaml:9:5: bridge.right.damping: expected a damping per length >= 0, e.g. "10 kN*s/m^2" or 10000, '
            'or {first_mode_ratio: 2.36 %}, or {ratio: 1 %}, got "2 %" ("%" is a ratio)',
            id="bare percentage",
        ),
        pytest.param(
            "    damping: 10 kN*s/m^2\n",
            "    damping: {ratio: 1 %, first_mode_ratio: 2 %}\n",
            "case.yaml:9:5: bridge.right.damping: expected one of coefficient, first_mode_ratio, ratio, got "
            "first_mode_ratio and ratio",
            id="two forms of damping",
        ),
        pytest.param(
            "    damping: 10 kN*s/m^2\n",
            "    damping: {}\n",
            "case.yaml:9:5: bridge.right.damping: expected one of coefficient, first_mode_ratio, ratio, got none of them",
            id="no form of damping",
        ),
        pytest.param(
            "modes: 4",
            "modes: 2.5",
            "case.yaml:4:3: bridge.modes: expected a whole number from 1 to 20, got 2.5",
            id="half a mode",
        ),
        pytest.param(
            "modes: 4",
            "modes: 21",
            "case.yaml:4:3: bridge.modes: expected a whole number from 1 to 20, got 21",
            id="too many modes",
        ),
        pytest.param(
            "train: paper",
            "train: {model: maglev}",
            "case.yaml:1:9: train.model: expected one of full-31dof, sprung-mass, rigid-beam, moving-load, axle-forces, "
            'hslm-a, consist, got "maglev"',
            id="unknown vehicle",
        ),
        pytest.param(
            "train: paper",
            "train: {mass: 5}",
            "case.yaml:1:1: train.model: missing; expected one of full-31dof, sprung-mass, rigid-beam, moving-load, axle-forces, "
            "hslm-a, consist",
            id="vehicle without a model",
        ),
        pytest.param(
            "train: paper",
            "train: 5",
            "case.yaml:1:1: train: expected a file, a built-in train or a mapping, got 5",
            id="a number for a train",
        ),
        pytest.param(
            "train: paper",
            "train: crh308a",
            'case.yaml:1:1: train: "crh308a": no such file beside the case, and no built-in train of that name; '
            "did you mean crh380a?",
            id="misspelt built-in train",
        ),
        pytest.param(
            "train: paper",
            "train: case.yaml",
            'case.yaml:1:1: train: "case.yaml" includes itself',
            id="include cycle",
        ),
        pytest.param(
            "train: paper",
            "train: /dev/zero",
            "case.yaml:1:1: train: /dev/zero: expected a file, got a device",
            id="device for a train",
        ),
        pytest.param(
            "train: paper",
            "train: .",
            "case.yaml:1:1: train: .: expected a file, got a directory",
            id="directory for a train",
        ),
        pytest.param(
            "  left: {youngs",
            "  lift: {youngs",
            "case.yaml:2:1: bridge.left: missing; a full-31dof train needs both beams",
            id="missing beam",
        ),
        pytest.param(
            "velocity: 300",
            "contact: {model: rigid}\nvelocity: 300",
            'case.yaml:11:11: contact.model: expected one of paper, hertz, got "rigid"',
            id="contact model",
        ),
        pytest.param(
            "velocity: 300",
            "contact: {convective: on}\nvelocity: 300",
            'case.yaml:11:11: contact.convective: expected true or false, got "on"',
            id="on is a string in YAML 1.2",
        ),
        pytest.param(
            "velocity: 300",
            "solver: {sampling: 0 s}\nvelocity: 300",
            'case.yaml:11:10: solver.sampling: expected a positive time, e.g. "0.001 s" or 0.001, or auto, got "0 s"',
            id="no sampling",
        ),
        pytest.param(
            "velocity: 300",
            "solver: {substeps: 0}\nvelocity: 300",
            "case.yaml:11:10: solver.substeps: expected a whole number from 1 to 1000000, or auto, got 0",
            id="no substeps",
        ),
        pytest.param(
            "velocity: 300",
            "output: {histories: some}\nvelocity: 300",
            "case.yaml:11:10: output.histories: expected none, all or {channels: [...], every: 0.01 s}, "
            'got "some"',
            id="histories",
        ),
        pytest.param(
            "velocity: 300",
            "output: {histories: {every: 0.0203}}\nsolver: {sampling: 0.001}\nvelocity: 300",
            "case.yaml:11:22: output.histories.every: expected a multiple of the sampling interval, 0.001 s, "
            "got 0.0203 s",
            id="histories between samples",
        ),
        pytest.param(
            "velocity: 300",
            "title: 2024\nvelocity: 300",
            "case.yaml:11:1: title: expected a text of one line, at most 500 characters, got 2024 (put it in quotes)",
            id="a number for a title",
        ),
        pytest.param(
            "velocity: 300",
            "velocity: 3\nvelocity: 300",
            "case.yaml:12:1: velocity: given twice, on lines 11 and 12",
            id="duplicate key",
        ),
    ],
)
def test_a_mistake_has_its_message(says: Says, old: str, new: str, message: str) -> None:
    assert first_line(says(changed(old, new))) == message


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "case.yaml:1:1: the file is empty"),
        ("# only a comment\n", "case.yaml:1:1: the file is empty"),
        ("velocity: [1\n", "case.yaml:2:1: not valid YAML: did not find expected ',' or ']'"),
        ("a: b: c\n", "case.yaml:1:5: not valid YAML: mapping values are not allowed in this context"),
        (
            "bridge:\n\tlength: 5\n",
            "case.yaml:2:1: not valid YAML: found character that cannot start any token (a tab; YAML indents with "
            "spaces)",
        ),
        (
            "[1, 2]\n",
            "case.yaml:1:1: expected a case: a mapping with the keys train, bridge, velocity, ..., got a list",
        ),
        ("a: 1\n---\nb: 2\n", "case.yaml:2:1: a second document; a case file is one document"),
        ("%YAML 1.1\n---\na: 1\n", "case.yaml:1:1: directives (%) are not used in case files"),
        ("a: !!python/name:os.system x\n", "case.yaml:1:4: tags are not used in case files, got "),
        ("a: !!str 5\n", "case.yaml:1:4: tags are not used in case files, got 'tag:yaml.org,2002:str'"),
        ("a: *b\n", "case.yaml:1:4: unknown alias *b"),
        ("a: &b [*b]\n", "case.yaml:1:8: alias *b stands inside of what it names"),
        ("? [1]\n: 2\n", "case.yaml:1:3: expected a plain word as the key of a mapping"),
        ("a: \x01\n", "case.yaml:1:4: control character U+0001"),
        ('a: "\\e[31m"\n', "case.yaml:1:4: a string with control characters"),
        ("a: " + "[" * 50 + "\n", "case.yaml:1:28: nested deeper than 24 levels"),
        (
            "a: [" + "1," * 100_000 + "]\n",
            "case.yaml:1:200001: more than 100000 values (aliases counted each time)",
        ),
        ("".join(f"k{i}: 1\n" for i in range(300)), "case.yaml:201:1: more than 200 keys in one mapping"),
    ],
)
def test_what_is_not_a_case_file_at_all(says: Says, text: str, message: str) -> None:
    assert first_line(says(text)).startswith(message)


def test_aliases_that_explode_are_counted(says: Says) -> None:
    lines = ["a0: &a0 [x, x, x, x, x, x, x, x, x]"]
    lines += [f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 9)}]" for i in range(1, 30)]
    assert (
        first_line(says("\n".join(lines)))
        == "case.yaml:6:10: more than 100000 values (aliases counted each time)"
    )


def test_all_mistakes_are_reported_at_once_in_the_order_of_the_file(says: Says) -> None:
    text = changed("length: 50 m", "length: -1").replace("modes: 4", "mods: 4").replace("300 km/h", "fast")
    text += "sweep: {span: [], velocity: [1, 1]}\nsolver: {method: euler}\n"
    places = [
        line.split(": ")[0] + " " + line.split(": ")[1]
        for line in says(text).splitlines()
        if "case.yaml" in line
    ]
    assert places == [
        "case.yaml:3:3 bridge.length",
        "case.yaml:4:3 bridge.mods",
        "case.yaml:11:1 velocity",
        "case.yaml:12:9 sweep.span",
        "case.yaml:12:33 sweep.velocity",
        "case.yaml:13:10 solver.method",
    ]


def test_many_mistakes_are_counted_not_all_shown(says: Says) -> None:
    text = CASE + "sweep:\n  velocity: [" + ", ".join(f"-{i}" for i in range(1, 81)) + "]\n"
    message = says(text)
    assert message.count("case.yaml:13:") == 50
    assert message.splitlines()[-1] == "... and 30 more errors"


def test_of_very_many_mistakes_a_thousand_are_looked_at(says: Says) -> None:
    groups = ", ".join(["{vehicle: {model: rigid-beam}}"] * 200)
    message = says(CASE.replace("train: paper", f"train: {{consist: [{groups}]}}"))
    assert message.count("case.yaml:1:") == 50
    assert message.splitlines()[-1] == "... and at least 951 more errors"


def test_one_mistake_in_many_values_is_said_once(says: Says) -> None:
    """Of each cause in a list the first, and how many there are; whatever the values are."""
    levels = ", ".join([*["q"] * 900, "2 s", *["1 mm"] * 50, *(f"{k} kg" for k in range(1, 51))])
    message = says(CASE + f"track: {{irregularity: {{profile: {{x: [0, 1], right: [{levels}]}}}}}}\n")
    key = "track.irregularity.profile.right"
    assert [line.partition(": ")[2] for line in message.splitlines() if line.startswith("case")] == [
        f'{key}.0: expected a length, e.g. "1 mm" or 0.001, got "q"; 900 such values',
        f'{key}.900: expected a length, e.g. "1 mm" or 0.001, got "2 s" ("s" is a time)',
        f'{key}.951: expected a length, e.g. "1 mm" or 0.001, got "1 kg" ("kg" is a mass); 50 such values',
    ]


def test_a_mistake_in_an_included_file_is_placed_there(says: Says, folder: Path) -> None:
    (folder / "trains").mkdir()
    (folder / "trains" / "mine.yaml").write_text("model: sprung-mass\nmass: -5\nstiffness: 1e6\n")
    text = "train: trains/mine.yaml\nbridge: verification-1\nvelocity: 50\n"
    assert says(text).splitlines() == [
        'trains/mine.yaml:1:1: train.damping: missing; expected a damping >= 0, e.g. "40 kN*s/m" or 40000',
        "    1 | model: sprung-mass",
        "      | ^",
        'trains/mine.yaml:2:1: train.mass: expected a positive mass, e.g. "5750 kg" or 5750, got -5',
        "    2 | mass: -5",
        "      | ^     ~~",
    ]


def test_includes_are_read_beside_the_file_that_names_them(folder: Path) -> None:
    (folder / "deep").mkdir()
    (folder / "deep" / "car.yaml").write_text("model: sprung-mass\nmass: 5\nstiffness: 1e6\ndamping: 0\n")
    (folder / "deep" / "case.yaml").write_text("train: car.yaml\nbridge: verification-1\nvelocity: 50\n")
    assert load_case("deep/case.yaml").train.model == "sprung-mass"


def test_lines_are_cut_around_the_caret_but_never_wrapped(says: Says) -> None:
    text = changed("velocity: 300 km/h", "solver: {" + " " * 400 + "method: euler}\nvelocity: 5")
    lines = says(text).splitlines()
    assert len(lines) == 3
    assert lines[1][lines[2].index("^") :].startswith("method: euler}")


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("nosuch.yaml", "nosuch.yaml: no such file"),
        (
            "paper/mases",
            "paper/mases: no such file, and no built-in case of that name; did you mean paper/masses?",
        ),
        ("/dev/zero", "/dev/zero: expected a file, got a device"),
        (".", ".: expected a file, got a directory"),
        ("a\0b.yaml", "a\\x00b.yaml: cannot be read: "),
        ("x" * 300 + ".yaml", "x" * 300 + ".yaml: cannot be read: file name too long"),
        ("loop.yaml", "loop.yaml: cannot be read: too many levels of symbolic links"),
        ("pipe.yaml", "pipe.yaml: expected a file, got a pipe"),
        ("large.yaml", "large.yaml: larger than 1000000 bytes, too large for a case file"),
        ("latin1.yaml", "latin1.yaml: not UTF-8 text: byte 0xe9 on line 2"),
        ("trains/paper", "trains/paper: no such file, and no built-in case of that name; "),
        ("../configs/paper", "../configs/paper: no such file, and no built-in case of that name; "),
    ],
)
def test_what_cannot_be_read(folder: Path, name: str, message: str) -> None:
    (folder / "loop.yaml").symlink_to("loop.yaml")
    os.mkfifo(folder / "pipe.yaml")
    (folder / "large.yaml").write_text("#" * 1_000_001)
    (folder / "latin1.yaml").write_bytes(b"a: 1\nb: caf\xe9\n")
    with pytest.raises(CaseError) as caught:
        load_case(name)
    assert str(caught.value).startswith(message)


def test_a_forbidden_file_is_said_to_be_so(folder: Path) -> None:
    path = folder / "mine.yaml"
    path.write_text(CASE)
    path.chmod(0)
    if os.access(path, os.R_OK):
        path.chmod(0o600)
        return  # Root may read everything.
    with pytest.raises(CaseError, match=r"^mine\.yaml: cannot be read: permission denied$"):
        load_case("mine.yaml")


@pytest.mark.parametrize(
    ("old", "new", "warning"),
    [
        (
            "300 km/h",
            "300",
            "case.yaml:11:1: warning: velocity: 300 m/s is outside the usual 0.5 to 200 m/s; "
            'was "300 km/h" meant?',
        ),
        (
            "207 GPa",
            "207",
            "case.yaml:6:5: warning: bridge.right.youngs_modulus: 207 Pa is outside the usual 1e8 to 1e12 Pa; "
            'was "207 GPa" meant?',
        ),
        (
            "    damping: 10 kN*s/m^2\n",
            "    damping: {ratio: 50 %}\n",
            "case.yaml:9:15: warning: bridge.right.damping.ratio: 0.5 is outside the usual 1e-5 to 0.2",
        ),
        (
            "    damping: 10 kN*s/m^2\n",
            "    damping: 200 kN*s/m^2\n",
            "case.yaml:9:5: warning: bridge.right.damping: 88 % of critical in the first mode is outside the usual "
            "0.001 to 20 %",
        ),
    ],
)
def test_odd_values_are_warnings_and_errors_when_strict(
    loads: Loads, says: Says, old: str, new: str, warning: str
) -> None:
    text = changed(old, new)
    assert [first_line(given) for given in loads(text).warnings] == [warning]
    assert first_line(says(text, strict=True)) == warning.replace("warning: ", "")


def test_odd_values_are_told_all_at_once(loads: Loads) -> None:
    text = changed("207 GPa", "207").replace(
        "    damping: 10 kN*s/m^2\n", "    damping: {first_mode_ratio: 50 %}\n"
    )
    told = [first_line(given).partition("warning: ")[2] for given in loads(text).warnings]
    assert [line.split(":")[0] for line in told] == ["bridge.right.youngs_modulus", "bridge.right.damping"]


def test_an_odd_value_in_the_sweep_is_a_warning(loads: Loads) -> None:
    mixed, warning = loads(CASE + "sweep: {car_body_mass: [40, 40 t]}\n").warnings
    assert "some numbers have a unit and some have none" in mixed
    assert first_line(warning) == (
        "case.yaml:12:9: warning: sweep.car_body_mass: 40 kg is outside the usual 2000 to 200000 kg; "
        'was "40 t" meant?'
    )


def test_a_misspelt_required_key_is_one_message(says: Says) -> None:
    """Of the word, not of what is missing as well; a key that no word stands for is missing all the same."""
    text = """\
sweep:
  speed: [10]
trian: paper
bridge: {lenght: 3, right: {E: 3, I: 3, zeta: 2}}
speed: 3
"""
    lines = [line for line in says(text).splitlines() if line.startswith("case.yaml")]
    assert lines == [
        "case.yaml:2:3: sweep.speed: no such key; did you mean velocity?",
        "case.yaml:3:1: trian: unknown key; did you mean train?",
        *[
            f"case.yaml:4:{column}: bridge.{key}: {text}"
            for column, key, text in (
                (10, "lenght", "unknown key; did you mean length?"),
                (
                    21,
                    "right.mass_per_length",
                    'missing; expected a positive mass per length, e.g. "20 t/m" or 20000',
                ),
                (29, "right.E", "unknown key; did you mean youngs_modulus?"),
                (35, "right.I", "unknown key; did you mean second_moment?"),
                (41, "right.zeta", "unknown key; did you mean damping?"),
            )
        ],
        "case.yaml:5:1: speed: unknown key; did you mean velocity?",
    ]
