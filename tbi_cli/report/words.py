"""The words of figures and tables: quantities, bodies, symbols and units, from what the file says of them."""

from __future__ import annotations

import re
from dataclasses import dataclass

from tbi_cli.printable import one_line
from tbi_cli.store import Dim, Variable

#: What the numbers of a table are, before the quantity.
OF_TABLE = {
    "peak": "largest",
    "max": "largest",
    "min": "smallest",
    "rms": "RMS of",
    "time_of_peak": "time of largest",
    "daf": "",
    "history": "",
}
_JOINTS = re.compile(r" (?:of|on|under) ")
_COACHES = re.compile(r", (?:coach [0-9]+|largest of all coaches)$")
_DERIVED = {"displacement": "acceleration", "deflection": "acceleration"}
_PREFIXES = ((1e9, "G"), (1e6, "M"), (1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "µ"), (1e-9, "n"))
# Units that are never counted in thousands; "1" and powers have no prefix at all.
_ONLY_SMALLER = ("m", "m/s2", "s", "rad", "rad/s2", "rad/s")
_BOTH_WAYS = ("N", "Pa", "N/m", "N s/m", "N s/m^2", "N m", "Hz")
_IN_TONNES = {"kg": "t", "kg/m": "t/m", "kg m^2": "t m²"}
_SYMBOL = re.compile(r"(?<![\w/.\\-])(?:[A-Za-z]|mu|[A-Za-z]+_[A-Za-z0-9]+)(?![\w/])")
_ARTICLE = "a"


@dataclass(frozen=True)
class Scale:
    """How a quantity is printed: its SI numbers divided by `factor`, and the unit then ("mm")."""

    factor: float
    unit: str


def scale(units: str, largest: float) -> Scale:
    """A sensible prefix for numbers in `units` of which the largest is `largest`."""
    if units == "1":
        return Scale(1.0, "")
    if units in _IN_TONNES and largest >= 1000:
        return Scale(1e3, _IN_TONNES[units])
    # A tenth of 1 m/s2 is read more easily than 100 mm/s2.
    least = 0.0995 if units.endswith("/s2") else 0.9995
    if largest > 0 and units in (*_ONLY_SMALLER, *_BOTH_WAYS):
        top = 1e9 if units in _BOTH_WAYS else 1.0
        for factor, prefix in _PREFIXES:
            if factor <= top and largest >= least * factor:
                return Scale(factor, prefix + typeset(units))
    return Scale(1.0, typeset(units))


def typeset(units: str) -> str:
    """Units with raised powers: "N s/m^2" becomes "N s/m²"."""
    raised = str.maketrans("0123456789.", "⁰¹²³⁴⁵⁶⁷⁸⁹·")
    return re.sub(r"\^?(?<=[A-Za-z^])([0-9]+)", lambda found: found[1].translate(raised), units)


def clean(text: str) -> str:
    """A name from a file on one line, without what no one can see."""
    return one_line(text[:200])


def quantity_of(variable: Variable) -> str:
    """What is measured, without where: "vertical acceleration"."""
    words, _, derived = _without_coach(clean(variable.long_name)).partition(", ")
    quantity = _JOINTS.split(words, maxsplit=1)[0]
    if derived != "acceleration":
        return quantity if not derived else f"{quantity}, {derived}"
    head, _, last = quantity.rpartition(" ")
    return f"{head} {_DERIVED[last]}" if last in _DERIVED else f"{quantity} acceleration"


def body_of(variable: Variable) -> str:
    """Where it is measured: "front bogie", "right beam"."""
    name = clean(variable.long_name)
    parts = _JOINTS.split(name.partition(", ")[0], maxsplit=1)
    place = parts[1] if len(parts) > 1 else parts[0]
    coach = _COACHES.search(name)
    own = coach[0] if coach and coach[0].startswith(", coach") else ""
    return place.removeprefix("the ").removesuffix(" on its rail") + own


def full_name(variable: Variable) -> str:
    """Quantity and place in one: "vertical acceleration of the car body"."""
    whole = clean(variable.long_name)
    name = _without_coach(whole)
    words, _, derived = name.partition(", ")
    if derived != "acceleration":
        return whole
    found = _JOINTS.search(words)
    return quantity_of(variable) + (words[found.start() :] if found else "") + whole.removeprefix(name)


def _without_coach(long_name: str) -> str:
    """The name of a channel without the coach of a train that it belongs to, or all of them."""
    return _COACHES.sub("", long_name)


def of_table(table: str, quantity: str) -> str:
    """A quantity with what the table holds of it: "largest vertical displacement"."""
    return f"{OF_TABLE.get(table, table)} {quantity}".strip()


def axis_words(dim: Dim, paths: frozenset[str]) -> str:
    """The name of a swept axis; one that the case gives by its dotted key keeps the words of the key."""
    name = clean(dim.long_name).partition(";")[0].strip().removeprefix("its ") or clean(dim.name)
    path = next(iter(paths)) if len(paths) == 1 else ""
    if path.count(".") < 2 or path.replace(".", "_") != dim.name:
        return name
    words = [word.replace("_", " ") for word in path.split(".")[1:-1]]
    missing = [word for word in words if word not in name]
    return " ".join((*missing, name))


def capital(text: str) -> str:
    """The text with a capital first letter; "" stays ""."""
    return text[:1].upper() + text[1:]


def number(value: float) -> str:
    """A number for a legend: six digits at most, no exponent where none is needed."""
    shown = f"{value:.6g}"
    if "e" not in shown:
        return shown
    mantissa, _, exponent = shown.partition("e")
    return f"{mantissa}·10{str(int(exponent)).translate(str.maketrans('-0123456789', '⁻⁰¹²³⁴⁵⁶⁷⁸⁹'))}"


def literal(text: str) -> str:
    """Text for matplotlib, to the letter: a dollar sign starts no mathematics."""
    return text.replace("$", r"\$")


def mathtext(text: str) -> str:
    """The name of an axis for matplotlib: symbols such as m_c set as mathematics."""

    def symbol(found: re.Match[str]) -> str:
        head, _, index = found[0].partition("_")
        if found[0] == _ARTICLE:
            return found[0]
        head = r"\mu" if head == "mu" else head
        return f"${head}_{{{index}}}$" if index else f"${head}$"

    return _SYMBOL.sub(symbol, literal(text))


def html_symbols(text: str) -> str:
    """The name of an axis, already escaped, for HTML: m_c with its index lowered."""
    return re.sub(r"(?<![\w/])([A-Za-z]+)_([A-Za-z0-9]+)(?![\w/])", r"<i>\1</i><sub>\2</sub>", text)
