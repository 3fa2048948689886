"""What the user asks of a report beyond the paper's figures, checked against what the studies hold."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase

import numpy as np

from tbi_cli.case.messages import suggestion
from tbi_cli.case.units import UnitError, to_si
from tbi_cli.printable import printable
from tbi_cli.report import words
from tbi_cli.report.errors import ReportError
from tbi_cli.report.study import Study, StudyAxis
from tbi_cli.store import Variable

TIME, NONE = "time", "none"
FORMATS = ("png", "pdf", "svg")
Channel = tuple[str, str]  # table, channel: ("peak", "car_body_y")


@dataclass(frozen=True)
class Wishes:
    """What `tbi report` was asked for.  Channels, x, family or heat maps replace the paper's figures."""

    channels: tuple[str, ...] = ()
    x: str | None = None
    family: str | None = None
    select: tuple[str, ...] = ()
    heat_map: bool = False
    formats: tuple[str, ...] = FORMATS

    @property
    def own_figures(self) -> bool:
        """Whether figures are asked for in place of the paper's."""
        return bool(self.channels or self.x or self.family or self.heat_map)

    def check(self, studies: Sequence[Study]) -> None:
        """Raises ReportError for a format, an axis or a channel that no study has."""
        for name in self.formats:
            if name not in FORMATS:
                raise ReportError(f"--formats: expected some of {', '.join(FORMATS)}, got {printable(name)}")
        for option, key, word in (("--x", self.x, TIME), ("--family", self.family, NONE)):
            if key is not None and key != word and not any(study.axis(key) for study in studies):
                raise ReportError(f"{option}: {_no_axis(key, studies, word)}")
        for pattern in self.channels:
            if not any(channels_like(study, pattern) for study in studies):
                names = {v.name for study in studies for v in study.results.channels}
                raise ReportError(
                    f"--channels: no channel {printable(pattern)}; {suggestion(pattern, sorted(names))}"
                )
        self.selection(studies)

    def selection(self, studies: Sequence[Study]) -> dict[str, dict[str, int]]:
        """By study, where `--select` puts its axes.  Raises ReportError for what is on no axis."""
        found: dict[str, dict[str, int]] = {study.name: {} for study in studies}
        for text in self.select:
            key, sign, value = (part.strip() for part in text.partition("="))
            if not sign or not value:
                raise ReportError(
                    f"--select {printable(text)}: expected AXIS=VALUE, e.g. car_body_mass='40 t'"
                )
            axes = [(study, axis) for study in studies if (axis := study.axis(key)) and axis.varies]
            if not axes:
                raise ReportError(f"--select {printable(text)}: {_no_axis(key, studies)}")
            for study, axis in axes:
                found[study.name][axis.name] = _index(text, axis, value)
        return found


def channels_like(study: Study, pattern: str) -> list[Channel]:
    """The table channels of a study that a pattern names: "car_body_*", "rms/right_midspan", "daf/right"."""
    table, slash, name = pattern.rpartition("/")
    if slash:
        variables = study.results.layout.columns(table) if table in study.results.layout.groups else ()
        return [(table, v.name) for v in variables if fnmatchcase(v.name, name)]
    return [(table_of(v), v.name) for v in study.results.channels if fnmatchcase(v.name, name)]


def table_of(variable: Variable) -> str:
    """The table in which extremes are looked for: forces push, wheels unload, all else goes both ways."""
    return "max" if variable.units == "N" or variable.name.endswith("_unloading") else "peak"


def _index(text: str, axis: StudyAxis, value: str) -> int:
    """Where on an axis `value` is, which may carry a unit."""
    try:
        wanted = to_si(value, axis.dim.units)
    except UnitError as error:
        raise ReportError(
            f"--select {printable(text)}: expected a number in {axis.dim.units}, {error}"
        ) from None
    index = axis.nearest(wanted)
    if not np.isclose(axis.values[index], wanted, rtol=1e-5, atol=0):
        unit = "" if axis.dim.units == "1" else f" {axis.dim.units}"
        ends = f"{words.number(float(axis.values[0]))} to {words.number(float(axis.values[-1]))}{unit}"
        raise ReportError(
            f"--select {printable(text)}: not a value of the axis {axis.name} "
            f"({len(axis.values)} values, {ends}); the nearest is {words.number(float(axis.values[index]))}"
        )
    return index


def _no_axis(key: str, studies: Sequence[Study], word: str | None = None) -> str:
    names = sorted({axis.name for study in studies for axis in study.varied})
    known = ", ".join([*names, *([word] if word else [])]) or "none"
    return f"no axis {printable(key)}; expected one of: {known}"
