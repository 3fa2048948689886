# ruff: noqa: E501 - messages are never wrapped, here neither.
"""Tables of axles and rails as other programs write them: what is read, and the one line where it is not.

Many more, with numbers that are known beforehand, are drawn by `scripts/fuzz.py --tables` (test_fuzz.py).
"""

from __future__ import annotations

from pathlib import Path
from random import Random

import h5py
import pytest

from tbi_cli.case import Case
from tbi_cli.case.track import Profile
from tests.cli.commands import tbi

from .conftest import Loads, Says

BRIDGE = """\
bridge:
  length: 20 m
  right: {youngs_modulus: 34 GPa, second_moment: 1.1, mass_per_length: 9 t/m, damping: {ratio: 1.5 %}}
velocity: 160 km/h
"""
AXLES = "train: {model: axle-forces, csv: axles.csv}\n" + BRIDGE
SPRUNG = "train: {model: sprung-mass, mass: 5 t, stiffness: 1 MN/m, damping: 0}\n"
RAILS = SPRUNG + "track: {irregularity: {profile: {csv: rails.csv}}}\n" + BRIDGE

# A locomotive of six axles and a wagon of four, as four programs might write it.
PLACES = (0.0, 2.1, 4.2, 11.25, 13.35, 15.45, 20.07, 21.87, 31.37, 33.17)
LOADS = (196e3, 196e3, 196e3, 198e3, 198e3, 198e3, 112.5e3, 112.5e3, 0.0, 112.5e3)
GERMAN = "1st wheelset;Axle load [kN];Position [m]\r\n" + "".join(
    f"{k};{p / 1e3:.1f};{x:.2f}\r\n".replace(".", ",")
    for k, (x, p) in enumerate(zip(PLACES, LOADS, strict=True), 1)
)
SPACED = "# locomotive and wagon\n   axle_spacing     P\n      mm            daN\n" + "".join(
    f"{1000 * (x - before):12.0f} {p / 10:14.1f}\n"
    for before, x, p in zip((0.0, *PLACES), PLACES, LOADS, strict=False)
)
SPREADSHEET = 'sep=;\n"Vehicle";"x";"Force"\n"-";"(cm)";"(MN)"\n' + "".join(
    f'"{"loco" if k < 6 else "wagon"}";"{100 * x + 310:.0f}";"{p / 1e6:.6f}";\n'
    for k, (x, p) in enumerate(zip(PLACES, LOADS, strict=True))
)
SAVED = "# position_m,force_kN\n" + "".join(
    f"{x:.18e},{p / 1e3:.18e}\n" for x, p in zip(PLACES, LOADS, strict=True)
)


def first_lines(message: str) -> list[str]:
    """The messages without the lines that they quote."""
    return [line for line in message.splitlines() if not line.startswith("   ")]


@pytest.mark.parametrize(
    ("content", "left_out"),
    [
        (GERMAN.encode("utf-16"), ['"1st wheelset"']),
        (SPACED.encode(), []),
        (SPREADSHEET.replace("Vehicle", "Länge über Puffer").encode("latin-1"), ['"Länge über Puffer"']),
        (SAVED.encode("utf-8-sig"), []),
    ],
    ids=["german", "spaced", "spreadsheet", "numpy"],
)
def test_lists_of_axles(loads: Loads, says: Says, folder: Path, content: bytes, left_out: list[str]) -> None:
    """The places behind the first axle and the forces, an axle without a force too; --strict wants all named."""
    (folder / "axles.csv").write_bytes(content)
    case = loads(AXLES)
    train = case.train
    assert train.behind == pytest.approx(
        PLACES, abs=1e-12
    )  # a difference of places below 40 m is rounded to 7e-15
    assert train.forces == pytest.approx(LOADS, rel=1e-15)
    expected = [f"left out, as it is not position (or spacing) and force: {name}" for name in left_out]
    assert [first_lines(text)[0].partition("warning: ")[2] for text in case.warnings] == expected
    if left_out:
        assert expected[0] in says(AXLES, strict=True)
    else:
        assert loads(AXLES, strict=True) == case


def test_units_in_the_heading_count(folder: Path) -> None:
    """Two axles of 180 kN: 1.627 mm, where newtons would give a thousandth.

    The numbers were read off to four digits.  The same train in SI in the case file has the same bits, and so has
    it in mm and meganewtons, with the first axle somewhere else.
    """
    (folder / "axles.csv").write_text("position [m];force [kN]\n0;180\n2.5;180\n")
    (folder / "far.csv").write_text("force [MN],position [mm]\n0.18,64000\n0.18,66500\n")
    (folder / "case.yaml").write_text(AXLES + "solver: {method: exact, sampling: 1 ms}\n")
    listed = "train={model: moving-load, forces: [180000, 180000], positions: [0, 2.5]}"
    tables = [f"train={{model: axle-forces, csv: {name}.csv}}" for name in ("axles", "far")]
    peaks = []
    for number, option in enumerate([*tables, listed]):
        run = tbi("run", "case.yaml", "--strict", "-q", "--set", option, "-o", f"{number}.h5", folder=folder)
        assert run.code == 0, run.err
        with h5py.File(folder / f"{number}.h5") as results:
            peaks.append(float(results["peak/right_midspan"][0]))
    assert peaks[0] == pytest.approx(1.627e-3, abs=0.0005e-3)
    assert peaks[1] == peaks[2] == peaks[0]


def test_rails_in_any_order_and_direction(loads: Loads, folder: Path) -> None:
    """Columns shuffled, each with a unit of its own, lines rising or falling: the same rails."""
    random = Random(15)
    x = [round(-30 + 0.5 * k + random.uniform(0, 0.1), 3) for k in range(40)]
    levels = {side: [random.randint(-4000, 4000) for _ in x] for side in ("right", "left")}  # in micrometres
    factors = {"m": 1.0, "mm": 1e-3, "µm": 1e-6, "ft": 0.3048, "in": 0.0254}
    for number in range(12):
        units = {name: random.choice(list(factors)) for name in ("x", "right", "left")}
        texts = {
            name: [f"{value * scale / factors[units[name]]:.12f}" for value in values]
            for name, values, scale in (("x", x, 1), *((side, levels[side], 1e-6) for side in levels))
        }
        names = random.sample(sorted(texts), 3)
        rows = list(zip(*(texts[name] for name in names), strict=True))
        if number % 2:
            rows.reverse()
        lines = ["\t".join(f"{name} [{units[name]}]" for name in names), *("\t".join(row) for row in rows)]
        (folder / "rails.csv").write_text("\n".join(lines), encoding="utf-8" if number % 3 else "latin-1")
        places, right, left = profile_of(loads(RAILS, strict=True)).points
        # Written with twelve digits behind the point, of a unit of up to 1 m: half of the last one.
        assert places == pytest.approx(x, abs=5e-13)
        assert right == pytest.approx([level * 1e-6 for level in levels["right"]], abs=5e-13)
        assert left == pytest.approx([level * 1e-6 for level in levels["left"]], abs=5e-13)


def profile_of(case: Case) -> Profile:
    assert case.track is not None
    assert case.track.irregularity.profile is not None
    return case.track.irregularity.profile


@pytest.mark.parametrize(
    ("text", "right", "left"),
    [
        ("-20;0,1 mm\n-10;-0,5 mm\n0;0,9 mm\n", (1e-4, -5e-4, 9e-4), ()),
        ("x right\n-20 0,0001\n-10 -0,0005\n0 0,0009\n", (1e-4, -5e-4, 9e-4), ()),
        (
            "x (m)\tleft (mm)\tright (mm)\n-20\t1,5\t0,1\n-10\t2\t-0,5\n0\t3\t0,9\n",
            (1e-4, -5e-4, 9e-4),
            (1.5e-3, 2e-3, 3e-3),
        ),
    ],
    ids=["no heading", "blanks", "tabs"],
)
def test_decimal_commas(
    loads: Loads, folder: Path, text: str, right: tuple[float, ...], left: tuple[float, ...]
) -> None:
    (folder / "rails.csv").write_text(text)
    profile = profile_of(loads(RAILS))
    assert (profile.x, profile.right, profile.left) == ((-20.0, -10.0, 0.0), right, left)


def test_one_message_for_one_cause(loads: Loads, says: Says, folder: Path) -> None:
    """A rail file in mm that does not say so, and a list of axles with x forward and z upward."""
    lines = [f"{0.1 * k:.1f},{(k % 9) / 10}" for k in range(900)]
    (folder / "rails.csv").write_text("\n".join(lines))
    (warning,) = loads(RAILS).warnings
    assert first_lines(warning) == [
        'rails.csv:4:5: warning: track.irregularity.profile.right.3: 0.3 m is outside the usual -0.2 to 0.2 m; was "0.3 mm" meant?; 600 such values'
    ]
    (folder / "axles.csv").write_text("".join(f"{-3 * k},-170000\n" for k in range(49)))
    assert first_lines(says(AXLES)) == [
        "axles.csv:1:1: train.positions: expected positions in rising order, got -3 (number 2) after 0; count them backward from the first axle: change the signs",
        'axles.csv:1:3: train.forces.0: expected a force >= 0, e.g. "56.4 kN" or 56400, got -170000 (a force acts downward: change the sign); 49 such values',
    ]


def test_a_column_with_units_on_some_of_its_numbers(loads: Loads, folder: Path) -> None:
    """It is said; where the heading has the unit, one in a cell is but another unit."""
    (folder / "axles.csv").write_text("position;force\n0 m;180 kN\n2.5 m;180000\n")
    (warning,) = loads(AXLES).warnings
    assert first_lines(warning)[0].startswith(
        "axles.csv:3:7: warning: train.forces: some numbers have a unit and some have none"
    )
    (folder / "axles.csv").write_text("position [mm];force [kN]\n0;180\n2.5 m;180000 N\n")
    train = loads(AXLES, strict=True).train
    assert (train.positions, train.forces) == ((0.0, 2.5), (180e3, 180e3))


def test_a_train_of_four_kilometres_is_usual(loads: Loads, folder: Path) -> None:
    (folder / "axles.csv").write_text(
        "position;force [kN]\n" + "".join(f"{4 * k};225\n" for k in range(1000))
    )
    assert loads(AXLES, strict=True).train.positions[-1] == 3996
    # Millimetres taken for metres are not.
    (folder / "axles.csv").write_text("0;225 kN\n2600;225 kN\n10400;225 kN\n")
    assert [first_lines(text)[0] for text in loads(AXLES).warnings] == [
        "axles.csv:3:1: warning: train.positions.2: 10400 m is outside the usual -4000 to 4000 m",
        "axles.csv:3:1: warning: train.positions.2: 7800 m behind the axle before is more than the usual 100 m",
    ]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("position;force [t]\n0;18.3\n", '1:10: expected the unit of a force, e.g. force [kN], got "force [t]" ("t" is a mass, 1 t weighs 9.807 kN)'),
        ("position;mass [t]\n0;18.3\n", '1:10: "mass [t]" is not a force: multiply by 9.81 m/s^2, and name the column force'),
        ("position;force\n0;18.3 t\n3;18.3 t\n", '2:3: train.forces.0: expected a force >= 0, e.g. "56.4 kN" or 56400, got "18.3 t" ("t" is a mass, 1 t weighs 9.807 kN); 2 such values'),
        ("position;force\ns;kN\n0;18.3\n", '2:1: expected the unit of a length, e.g. position [m], got "s" ("s" is a time)'),
        ("position [mm];force\nm;kN\n0;18.3\n", '2:1: expected one unit, got "position [mm]" and "m"'),
        ("distance;force\n0;1\n", '1:1: "distance" may be a position or a spacing: name it position (from the first axle) or spacing (from the axle before)'),
        ("spacing;force\n2.5;1 kN\n0;1 kN\n", "2:1: spacing: expected 0 or nothing for the first axle: a spacing is the distance to the axle before, got 2.5"),
        ("spacing;force\n0;1 kN\n-2.5;1 kN\n", '3:1: spacing: expected a length >= 0, e.g. "2.5 m" or 2.5, got -2.5'),
        ("spacing;force\n0;1 kN\n2.5 m;1 kN\n2.5;1 kN\n", "4:1: spacing: expected a unit for every spacing, or for none, best in the heading, got 2.5"),
        ("Achse;Kraft\n0;1\n", '1:1: expected a heading with the columns position (or spacing) and force, with their units if not SI, got "Achse, Kraft"; lines that are neither heading nor numbers begin with #'),
        ("position;x;force\n0;0;1\n", '1:10: "position" and "x" name one column'),
        ("position,force\n0;180 kN\n", '2:1: expected 2 values parted by commas, position, force, got "0;180 kN"'),
        ("position,force\n2,5,180000\n", '2:1: expected 2 values parted by commas, position, force, got "2,5,180000"; if the commas are decimal signs, part the columns with semicolons or tabs'),
        ("position,force,remark\n0,180000,\n2,5,180000,\n", '3:1: expected 3 values parted by commas, position, force, remark, got "2,5,180000,"; if the commas are decimal signs, part the columns with semicolons or tabs'),
        ("position;remark;force;axle\n0\t;180000;7\n", '2:1: expected 4 values parted by semicolons, position, remark, force, axle, got "0\\x09;180000;7"'),
        ('position,force\n0,"170,000"\n', '2:4: a comma parts the columns here, so that "170,000" cannot be read; write a decimal point, or part the columns with semicolons'),
        ("0;170,000\n3;170,000\n", '1:3: "170,000" may be 170.000 or 170000; write one of these'),
        ("0;170000\n2,5;170.5\n", '2:1: expected one decimal sign, got "170.5" and "2,5"; write numbers without signs between thousands'),
        ("0;1,170,000\n", '1:3: expected a number without signs between thousands, got "1,170,000"'),
        ("0,170 000\n", '1:1: a comma may part the columns here or be a decimal sign; part them with semicolons or tabs, got "0,170 000"'),
        ("12,5\n13,6;180\n", '2:1: expected columns parted by commas, as on line 1, got "13,6;180"'),
    ],
)  # fmt: skip
def test_a_list_of_axles_that_could_be_misread(says: Says, folder: Path, text: str, message: str) -> None:
    (folder / "axles.csv").write_text(text)
    assert first_lines(says(AXLES)) == [f"axles.csv:{message}"]


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"-20,0,1\n-10,-0,5\n0,0,9\n", 'rails.csv:1:1: expected a heading with the columns x, right and left (or x and right), got "-20,0,1"; if the commas are decimal signs, part the columns with semicolons or tabs'),
        (b"-20 0,1\n-10 -0,5\n", 'rails.csv:1:1: a comma may part the columns here or be a decimal sign; part them with semicolons or tabs, got "-20 0,1"'),
        ("x;right\n0;0\n1;0\n".encode("utf-16-le"), "case.yaml:2:34: track.irregularity.profile.csv: rails.csv: neither UTF-8 nor UTF-16 with its byte order mark; save the table as UTF-8"),
        (b"x;right\xff\x81\n", "case.yaml:2:34: track.irregularity.profile.csv: rails.csv: not text in UTF-8, UTF-16 or Latin-1; save the table as UTF-8"),
    ],
    ids=["commas", "blanks and commas", "no mark", "bytes"],
)  # fmt: skip
def test_rails_that_could_be_misread(says: Says, folder: Path, content: bytes, message: str) -> None:
    (folder / "rails.csv").write_bytes(content)
    assert first_lines(says(RAILS)) == [message]
