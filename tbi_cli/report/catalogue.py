"""The figures of the paper as declared in figures.yaml."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from importlib import resources
from typing import Any

from tbi_cli.case.messages import Source
from tbi_cli.case.yaml12 import plain, read_yaml


@dataclass(frozen=True)
class Run:
    """A curve from a results file of its own: which channel of which case, and the case that produces it."""

    label: str
    channel: str
    where: Mapping[str, float | str]
    case: str


@dataclass(frozen=True)
class PanelSpec:
    """One panel: its channels in one table ("history" over time), or runs of their own."""

    title: str
    table: str
    channels: tuple[str, ...] = ()
    runs: tuple[Run, ...] = ()


@dataclass(frozen=True)
class FigureSpec:
    """One figure: what is drawn over which axis, one curve for each value of `family` or for each channel.

    `at` are values that the case must have, `case` is the built-in case that produces the data.
    """

    number: int
    heading: str
    x: str
    panels: tuple[PanelSpec, ...]
    case: str
    family: str | None = None
    at: Mapping[str, float] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """The name of its files."""
        return f"fig{self.number}"


@cache
def catalogue() -> tuple[FigureSpec, ...]:
    """All figures, in the order of the paper."""
    return tuple(_figure(number, entry) for number, entry in data_file("figures.yaml").items())


def data_file(name: str) -> dict[str, Any]:
    """A YAML file that belongs to this package, its numbers as in YAML 1.2."""
    text = resources.files("tbi_cli.report").joinpath(name).read_text(encoding="utf-8")
    node, _ = read_yaml(Source(name, text))
    found: dict[str, Any] = plain(node)
    return found


def _figure(number: str, entry: dict[str, Any]) -> FigureSpec:
    table = "history" if entry["x"] == "time" else entry.get("table", "peak")
    return FigureSpec(
        number=int(number),
        heading=entry["heading"],
        x=entry["x"],
        panels=tuple(_panel(title, table, what) for title, what in entry["panels"].items()),
        case=entry["case"],
        family=entry.get("family"),
        at=entry.get("at", {}),
    )


def _panel(title: str, table: str, what: str | list[Any]) -> PanelSpec:
    if isinstance(what, str):
        return PanelSpec(title, table, (what,))
    if all(isinstance(item, str) for item in what):
        return PanelSpec(title, table, tuple(what))
    return PanelSpec(title, table, runs=tuple(Run(**item) for item in what))
