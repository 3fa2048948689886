"""Tables of axles and rails in every form that programs write, whole or after an accident, and what they say.

The numbers are multiplied here, with factors written out: nothing of the reader is used.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction

from hypothesis import strategies as st

LENGTHS = {"m": Fraction(1), "mm": Fraction(1, 1000), "cm": Fraction(1, 100), "ft": Fraction(3048, 10000)}
FORCES = {
    "N": Fraction(1),
    "kN": Fraction(1000),
    "MN": Fraction(10**6),
    "daN": Fraction(10),
    "kip": Fraction("4448.2216152605"),
}
AXLES = {
    "position": ("position", "Position", "axle position", "x", "Axle_Position"),
    "spacing": ("spacing", "Axle spacing", "pitch"),
    "force": ("force", "Axle load", "P", "FORCE", "axle_force"),
}
RAILS = {
    "x": ("x", "chainage", "Station", "distance"),
    "right": ("right", "Right rail"),
    "left": ("left", "LEFT"),
}
# Columns that no case asks for, and what stands in them.
OTHERS = {
    "no": "7",
    "axle type": "drive",
    "wheel load": "3.5",
    "remark": "",
    "Größe": "-",
    "date": "01.02.2024",
}
HEADS = ("{} [{}]", "{} ({})", "{} / {}", "{}_{}", "{} in {}", "{}[{}]")
CASES = {
    "axles": "train: {model: axle-forces, csv: table.csv}\n",
    "rails": "train: {model: sprung-mass, mass: 5 t, stiffness: 1 MN/m, damping: 0}\n"
    "track: {irregularity: {profile: {csv: table.csv}}}\n",
}
BRIDGE = """\
bridge:
  length: 20 m
  right: {youngs_modulus: 30 GPa, second_moment: 0.3, mass_per_length: 10 t/m, damping: {ratio: 1 %}}
velocity: 40
"""


@dataclass(frozen=True)
class TrueTable:
    """A table as text, and the columns (SI) that it must be read as; `whole` if nothing has happened to it.

    Columns of axles are their distances behind the first, and forces.
    """

    kind: str
    lines: tuple[str, ...]
    columns: tuple[tuple[float, ...], ...]
    separator: str
    sign: str
    encoding: str
    left_out: bool
    heading: int
    whole: bool = True

    @property
    def content(self) -> bytes:
        """The bytes of the file."""
        return "\r\n".join(self.lines).encode(self.encoding)


@st.composite
def tables(draw: st.DrawFn) -> TrueTable:
    """A table that must be read, and its numbers."""
    kind = draw(st.sampled_from(["axles", "rails"]))
    spaced = kind == "axles" and draw(st.booleans())
    if kind == "axles":
        keys = ["spacing" if spaced else "position", "force"]
    else:
        keys = ["x", "right", "left"][: draw(st.integers(2, 3))]
    units = {key: draw(st.sampled_from(sorted(FORCES if key == "force" else LENGTHS))) for key in keys}
    where = draw(st.sampled_from(["heading", "heading", "row", "cell", "none"]))
    named = spaced or draw(st.integers(0, 4)) > 0
    if where == "none" or (not named and where != "cell"):
        where, units = "none", {key: "N" if key == "force" else "m" for key in keys}
    separator = draw(st.sampled_from([";", "\t", ",", " "]))
    if separator == " " and where == "cell":
        separator = ";"
    sign = draw(st.sampled_from(".," if separator != "," and (named or separator != " ") else "."))
    numbers = {key: _texts(draw, key, units[key], spaced) for key in keys}
    count = min(len(column) for column in numbers.values())
    numbers = {key: column[:count] for key, column in numbers.items()}

    heads = [
        (key, _head(draw, kind, key, units[key] if where == "heading" else "", separator)) for key in keys
    ]
    others = draw(st.lists(st.sampled_from(sorted(OTHERS)), max_size=2, unique=True)) if named else []
    if separator in ", ":
        others = [name for name in others if separator == "," and "Gr" not in name]
    columns = [*heads, *(("", name) for name in others)]
    if named:
        columns = draw(st.permutations(columns))
    rows = [[head for _, head in columns]] if named else []
    if named and where == "row":
        rows.append(
            [
                units[key] if key else draw(st.sampled_from(["", "-"])) if separator != " " else "-"
                for key, _ in columns
            ]
        )
    for number in range(count):
        cells = []
        for key, head in columns:
            text = numbers[key][number].replace(".", sign) if key else OTHERS[head]
            cells.append(f"{text} {units[key]}" if key and where == "cell" else text)
        rows.append(cells)
    quote = separator != " " and draw(st.booleans())
    lines = [separator.join(f'"{cell}"' if quote and cell else cell for cell in row) for row in rows]
    if separator != " " and not others and draw(st.booleans()):
        lines = [line + separator for line in lines]
    if draw(st.booleans()):
        lines = [f"# Made by a test, 1{separator}2", "", *lines, ""]
    heading = next(k for k, line in enumerate(lines) if line and not line.startswith("#"))
    encoding = draw(st.sampled_from(["utf-8", "utf-8-sig", "utf-16", "latin-1"]))
    return TrueTable(
        kind,
        tuple(lines),
        _truth(kind, keys, numbers, units, spaced),
        separator,
        sign,
        encoding,
        bool(others),
        heading,
    )


def _head(draw: st.DrawFn, kind: str, key: str, unit: str, separator: str) -> str:
    """What a heading may say of a column."""
    word = draw(st.sampled_from((AXLES if kind == "axles" else RAILS)[key]))
    if separator == " ":
        word = word.replace(" ", "_")
    forms = HEADS if separator != " " else ("{} [{}]", "{}_{}", "{}[{}]")
    return draw(st.sampled_from(forms)).format(word, unit) if unit else word


def _texts(draw: st.DrawFn, key: str, unit: str, spaced: bool) -> list[str]:
    """Decimals of a column in its unit: axles of 20 to 300 kN metres apart, levels of millimetres."""
    count = draw(st.integers(2, 6))
    if key == "force":
        return [_shown(draw(st.integers(20, 300)) * 1000 / FORCES[unit], draw) for _ in range(count)]
    if key in ("right", "left"):
        return [_shown(draw(st.integers(-9, 9)) / (LENGTHS[unit] * 1000), draw) for _ in range(count)]
    # Uneven, but the points of a rail not so much that its spline swings.
    apart = st.integers(20, 24) if key == "x" else st.integers(11, 99)
    steps = [_shown(draw(apart) / (LENGTHS[unit] * 10), draw) for _ in range(count)]
    if spaced:
        return [draw(st.sampled_from(["0", "0.0"])), *steps[1:]]
    place = Fraction(draw(st.sampled_from(["0", "0", "-3", "12.5"])) if key != "spacing" else "0")
    places = [place]
    for step in steps[1:]:
        places.append(places[-1] + Fraction(step))
    return [_decimal(place) for place in places]


def _shown(number: Fraction, draw: st.DrawFn) -> str:
    """About this number, with one digit or two behind the point more than it needs for its size, or none."""
    digits = 0 if abs(number) >= 10 else 1 if abs(number) >= 1 else 5
    return _decimal(round(Fraction(number), digits + draw(st.integers(0, 1))))


def _decimal(number: Fraction) -> str:
    """A finite decimal fraction without zeros at its end, in plain digits."""
    text = f"{float(number):.6f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text


def _truth(
    kind: str, keys: list[str], numbers: dict[str, list[str]], units: dict[str, str], spaced: bool
) -> tuple[tuple[float, ...], ...]:
    columns: list[list[Fraction]] = []
    for key in keys:
        factor = (FORCES if key == "force" else LENGTHS)[units[key]]
        columns.append([Fraction(text) * factor for text in numbers[key]])
    if kind == "axles":
        places = columns[0]
        columns[0] = [
            sum(places[: k + 1], Fraction(0)) if spaced else x - places[0] for k, x in enumerate(places)
        ]
    return tuple(tuple(float(value) for value in column) for column in columns)


@st.composite
def hurt(draw: st.DrawFn, table: TrueTable) -> TrueTable:
    """The table after an accident that leaves its numbers known to a reader, or makes it no table."""
    lines = list(table.lines)
    at = draw(st.integers(table.heading, len(lines) - 1))
    line = lines[at]
    other = draw(st.sampled_from([sign for sign in ";\t, " if sign != table.separator]))
    match draw(st.integers(0, 7)):
        case 0:  # another separator in one place
            lines[at] = line.replace(table.separator, other, 1)
        case 1:  # and in all of a line
            lines[at] = line.replace(table.separator, other)
        case 2:  # the other decimal sign in a line
            lines[at] = line.replace(table.sign, "." if table.sign == "," else ",", 1)
        case 3 if "[" not in line:  # a cell lost
            lines[at] = line.rpartition(table.separator)[0]
        case 4:  # a cell too many
            lines[at] = f"{line}{table.separator}5"
        case 5:  # a title
            lines.insert(
                table.heading, draw(st.sampled_from(["Train 7", "axles;1", "Loads of a train", "m;kN"]))
            )
        case 6:  # a unit of something else
            lines[at] = line.replace("[", "[s", 1).replace("(", "(s", 1)
        case _:  # a quotation mark; in the heading it would make the name of another column
            at = max(at, table.heading + 1)
            line = lines[at]
            where = draw(st.integers(0, len(line)))
            lines[at] = line[:where] + '"' + line[where:]
    return replace(table, lines=tuple(lines), whole=False)


def close(found: tuple[tuple[float, ...], ...], expected: tuple[tuple[float, ...], ...]) -> bool:
    """Equal but for rounding: of a product and of a difference of places below 1 km."""
    if [len(column) for column in found] != [len(column) for column in expected]:
        return False
    pairs = zip(found, expected, strict=True)
    return all(
        abs(a - b) <= 1e-12 * max(abs(b), 100)
        for one, other in pairs
        for a, b in zip(one, other, strict=True)
    )
