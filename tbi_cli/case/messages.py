"""Messages to the author of a case file: where, which key, what was expected, what was found."""

from __future__ import annotations

import bisect
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from difflib import get_close_matches
from functools import cached_property
from pathlib import Path

from tbi_cli.errors import UserError
from tbi_cli.printable import printable

_SHOWN_ERRORS = 50
MOST_ERRORS = 1000  # that are put into words
_SHOWN_WIDTH = 160
_SHOWN_VALUE = 60
UNPRINTABLE = re.compile(
    "[\x00-\x1f\x7f-\x9f\u2028\u2029\u200e\u200f\u202a-\u202e\u2066-\u2069\ufeff\ufffe\uffff]"
)


def quoted(value: object) -> str:
    """A value as the author would recognise it: strings in quotes, mappings and lists by their kind."""
    match value:
        case None:
            return "nothing"
        case bool():
            return "true" if value else "false"
        case dict():
            return "a mapping" if value else "an empty mapping"
        case list() | tuple():
            return "a list" if value else "an empty list"
        case str():
            shown = printable(value)
            return f'"{shown}"' if len(shown) <= _SHOWN_VALUE else f'"{shown[:_SHOWN_VALUE]}..."'
        case float():
            return plain_number(value)
        case _:
            shown = str(value)
            return shown if len(shown) <= _SHOWN_VALUE else f"{shown[:_SHOWN_VALUE]}..."


def plain_number(value: float) -> str:
    """A number as one would write it in a case file: 2.07e11, 0.01, 83.3333."""
    if value != value or value in (float("inf"), float("-inf")):
        return {"nan": ".nan", "inf": ".inf", "-inf": "-.inf"}[str(float(value))]
    shown = f"{value:.6g}"
    mantissa, sign, exponent = shown.partition("e")
    return f"{mantissa}e{int(exponent)}" if sign else shown


def of_many(text: str, count: int) -> str:
    """The message about the first of so many values of which the same is to be said."""
    return f"{text}; {count} such values" if count > 1 else text


# What engineers call a key, and the keys that may be meant, where they are known.
_SYNONYMS = {
    **dict.fromkeys(("speed", "speeds", "train_speed", "velocities", "v"), ("velocity",)),
    **dict.fromkeys(("span", "spans", "span_length", "bridge_length", "l"), ("length", "span")),
    **dict.fromkeys(("length",), ("span",)),
    **dict.fromkeys(("e", "modulus", "elastic_modulus", "stiffness"), ("youngs_modulus",)),
    **dict.fromkeys(("i", "inertia", "moment_of_inertia"), ("second_moment",)),
    **dict.fromkeys(("mass", "mu", "line_mass"), ("mass_per_length", "car_body_mass")),
    **dict.fromkeys(("damping_ratio", "zeta"), ("ratio", "damping")),
    **dict.fromkeys(("dt", "step", "time_step", "timestep"), ("sampling",)),
    **dict.fromkeys(("load", "loads", "axle_loads", "axle_forces"), ("forces",)),
}


def synonym(word: str, known: Iterable[str]) -> str:
    """The known word that is another one for this; empty if there is none."""
    return next((key for key in _SYNONYMS.get(word.lower(), ()) if key in known), "")


_MOST_NAMES = 12  # of those known, in a message


def suggestion(word: str, known: Iterable[str]) -> str:
    """'did you mean ...' for a synonym or the nearest known word, or else the list of them."""
    words = list(known)
    if meant := meant_by(word, words):
        return f"did you mean {meant}?"
    return f"known here: {', '.join(words)}" if words else "nothing is known here"


def meant_by(word: str, known: Sequence[str]) -> str:
    """The known word of which this one is a synonym, or to which it is nearest; empty if there is none."""
    return synonym(word, known) or next(
        iter(get_close_matches(word[:80].lower(), known, n=1, cutoff=0.6)), ""
    )


def not_among(name: str, known: Sequence[str]) -> str:
    """Says that a name is none of those known: with the nearest one, else with the first of them."""
    near = get_close_matches(name[:80], known, n=1, cutoff=0.6)
    if near:
        return f"unknown name {quoted(name)}; did you mean {near[0]}?"
    more = f" and {len(known) - _MOST_NAMES} more" if len(known) > _MOST_NAMES else ""
    return f"expected some of {', '.join(known[:_MOST_NAMES])}{more}; got {name}"


# What a key may look like: a line such as root:x:0: is one to YAML as well, and no word of a train.
_KEY = re.compile(r"[A-Za-z][A-Za-z0-9_-]{0,31}|[0-9]{1,6}")
_CONTENT = re.compile(r'(?<!e\.g\. )"[^"]*"|\*\S+')  # quoted values, but for examples, and aliases


@dataclass(frozen=True)
class Source:
    """A text that was read: a case file, an included or built-in file, or an option of the command line."""

    name: str
    text: str = ""
    folder: Path = field(default_factory=Path)
    is_option: bool = False
    #: A file outside the case's folder: a case from a stranger may name any, and what is in it is not shown.
    foreign: bool = False

    @cached_property
    def _line_starts(self) -> list[int]:
        return [0, *(found.end() for found in re.finditer(r"\r\n|\r|\n", self.text))]

    def line(self, number: int) -> str:
        """Line `number`, counted from 1, without its end; empty when there is no such line."""
        if not 1 <= number <= len(self._line_starts):
            return ""
        start = self._line_starts[number - 1]
        end = self._line_starts[number] if number < len(self._line_starts) else len(self.text)
        return self.text[start:end].rstrip("\r\n")

    def position(self, index: int) -> tuple[int, int]:
        """Line and column, both from 1, of the character at `index`."""
        line = bisect.bisect_right(self._line_starts, index)
        return line, index - self._line_starts[line - 1] + 1


@dataclass(frozen=True)
class Place:
    """Where something stands: line and column of the key, and of its value if it stands on the same line."""

    source: Source
    line: int = 1
    column: int = 1
    width: int = 1
    value_column: int = 0
    value_width: int = 0

    def __str__(self) -> str:
        name = printable(self.source.name)
        return name if self.source.is_option else f"{name}:{self.line}:{self.column}"

    def excerpt(self) -> str:
        """The line, with a caret beneath the key and a wavy line beneath the value; empty for an option."""
        text = self.source.line(self.line)
        if self.source.is_option or self.source.foreign or not text.strip():
            return ""
        start = max(0, self.column - 1 - _SHOWN_WIDTH // 2) if len(text) > _SHOWN_WIDTH else 0
        shown = printable(text[start : start + _SHOWN_WIDTH].replace("\t", " "))
        marks = [" "] * (len(shown) + 1)
        for column, width, mark in ((self.value_column, self.value_width, "~"), (self.column, 1, "^")):
            first = column - 1 - start
            for i in range(max(first, 0), min(first + width, len(marks))):
                marks[i] = mark
        number = f"{self.line:>5} | "
        return f"\n{number}{shown}\n{' ' * (len(number) - 2)}| {''.join(marks).rstrip()}"


@dataclass(frozen=True)
class Problem:
    """One thing that is wrong, or only odd, in what was read."""

    place: Place | None
    key: str
    text: str
    odd: bool = False

    def render(self, kind: str = "") -> str:
        """`place: key: text`, then the line that it stands on; `kind` is put before the key."""
        shown = withheld(self) if self.place and self.place.source.foreign else self
        parts = [str(self.place) if self.place else "", kind, printable(shown.key), printable(shown.text)]
        return ": ".join(part for part in parts if part) + (self.place.excerpt() if self.place else "")


def withheld(problem: Problem) -> Problem:
    """The problem without what stands in the file, but for the keys, which are the field's own words."""
    key = ".".join(word if _KEY.fullmatch(word) else "..." for word in problem.key.split("."))
    text, got, _ = problem.text.partition(", got ")
    text = _CONTENT.sub("...", text)
    if got:
        text += ", got something else (what is in files outside the case's folder is not shown)"
    return replace(problem, key=key if problem.key else "", text=text)


def in_order(problems: Sequence[Problem], first: Source) -> list[Problem]:
    """Problems of `first`, then of other files, then of options; those of one file by line and column."""
    files = list(
        dict.fromkeys(id(p.place.source) for p in problems if p.place and p.place.source is not first)
    )

    def key(problem: Problem) -> tuple[bool, int, int, int]:
        place = problem.place
        if place is None or place.source.is_option:
            return (True, 0, 0, 0)
        return (
            False,
            1 + files.index(id(place.source)) if place.source is not first else 0,
            place.line,
            place.column,
        )

    return sorted(problems, key=key)


class CaseError(UserError):
    """Everything that is wrong with a case. `str()` of it is the whole text for standard error."""

    def __init__(self, problems: Sequence[Problem]) -> None:
        self.problems = tuple(problems)
        shown = [problem.render() for problem in self.problems[:_SHOWN_ERRORS]]
        if len(self.problems) > _SHOWN_ERRORS:
            least = "at least " if len(self.problems) >= MOST_ERRORS else ""
            shown.append(f"... and {least}{len(self.problems) - _SHOWN_ERRORS} more errors")
        super().__init__(*(line for text in shown for line in text.split("\n")))


class RunError(CaseError):
    """A case that was read and cannot be run as it is."""


def fail(name: str, text: str) -> CaseError:
    """The error of a file that cannot be read at all."""
    return CaseError([Problem(None, name, text)])
