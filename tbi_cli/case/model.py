"""The case: everything that decides a result, validated and in SI."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import Field, PrivateAttr

from tbi_cli.case.axes import Axis, resolved_sweep
from tbi_cli.case.bridge import Bridge, Damping, Stations
from tbi_cli.case.consist import Consist, wheelbase_of
from tbi_cli.case.emit import emit_yaml
from tbi_cli.case.fields import ACCELERATION, SPEED, Quantity, Text
from tbi_cli.case.messages import Problem, RunError
from tbi_cli.case.part import Part, replaced
from tbi_cli.case.places import Places
from tbi_cli.case.settings import Contact, Histories, Output, Solver
from tbi_cli.case.track import Track
from tbi_cli.case.train import Train


class Case(Part):
    """One train on one bridge, or a grid of such cases (`axes`); every number in SI.

    Field names are the keys of the case file. `axes` is its sweep, in the order of the file; `warnings` are
    the complete texts about values that are odd but not impossible. A case that is a union of `studies`
    stands for these alone; its own fields, title and output file apart, are those of the first.
    """

    title: Annotated[str, Text("what this case is, in a line")] = ""
    train: Annotated[Train, Field(discriminator="model")]
    bridge: Bridge
    contact: Contact = Contact()
    track: Track | None = None
    velocity: Annotated[float, Quantity("train velocity v", SPEED, "300 km/h", usual=(0.5, 200))]
    gravity: Annotated[
        float,
        Quantity("acceleration of gravity g", ACCELERATION, "9.81 m/s^2", "not negative", usual=(9.7, 9.9)),
    ] = 9.81
    solver: Solver = Solver()
    output: Output = Output()

    _axes: tuple[Axis, ...] = PrivateAttr(())
    _warnings: tuple[str, ...] = PrivateAttr(())
    _studies: dict[str, Case] = PrivateAttr({})
    _places: Places | None = PrivateAttr(None)
    _study: str = PrivateAttr("")

    @property
    def axes(self) -> tuple[Axis, ...]:
        """The swept axes, in the order of the case file."""
        return self._axes

    @property
    def warnings(self) -> tuple[str, ...]:
        """Messages about values that are odd but not impossible."""
        return self._warnings

    @property
    def studies(self) -> Mapping[str, Case]:
        """The cases that this one is the union of, by name, in the order of the file; none for one grid."""
        return self._studies

    @property
    def way(self) -> float:
        """How far (m) the first axle of a single case comes from the beginning of the bridge."""
        train = self.train
        wheelbase = train.wheelbase if isinstance(train, Consist) else wheelbase_of(train)
        return self.solver.duration * (self.bridge.length + wheelbase)

    @property
    def window(self) -> float:
        """How long (s) a single case is looked at: on the approach, and from the bridge on."""
        approach = self.track.approach if self.track is not None else 0.0
        return (approach + self.way) / self.velocity

    def swept(self, axes: tuple[Axis, ...], warnings: tuple[str, ...] = ()) -> Case:
        """The same case with this sweep (and these warnings); the axes are taken as checked."""
        return self._holding(_axes=axes, _warnings=warnings, _studies={})

    def standing_at(self, places: Places | None) -> Case:
        """The same case, whose keys stand there; None: in no file, or in one that is gone."""
        studies = {} if places is not None else {n: s.standing_at(None) for n, s in self._studies.items()}
        return self._holding(_places=places, _studies=studies or self._studies)

    def problem(self, key: str, text: str, at: str = "") -> Problem:
        """What turns out to be wrong, or odd, with a dotted key after the case was read.

        It has the place of the key, if the case is of a file; `at` says in words where in the grid.
        """
        place = None if self._places is None else self._places.of(key, self._axes)
        study = f"studies.{self._study}." if self._study else ""
        return Problem(place, study + key + (f" at {at}" if at else ""), text)

    def refused(self, key: str, text: str, at: str = "") -> RunError:
        """The error about a dotted key, for a case that cannot be run; see `problem`."""
        return RunError([self.problem(key, text, at)])

    def _holding(self, **private: Any) -> Case:
        copy = self.replacing("title", self.title)
        object.__setattr__(copy, "__pydantic_private__", {**(self.__pydantic_private__ or {}), **private})
        return copy

    def at(self, values: Mapping[str, float]) -> Case:
        """The single case at one point of the grid: axis name -> value in SI.

        Unchecked: every value of every axis was checked when the case was loaded.

        Raises KeyError for a name that is not an axis of this case.
        """
        axes = {axis.name: axis for axis in self._axes}
        case = self.swept(())
        for name, value in values.items():
            for chain, number in axes[name].settings(value):
                case = replaced(case, chain, number)
        return case

    def resolved(self) -> dict[str, Any]:
        """The whole case as plain dicts, lists, strings and SI numbers, in the form of a case file."""
        if self._studies:
            studies = {name: study.resolved() for name, study in self._studies.items()}
            for study in studies.values():
                del study["output"]["file"]
            return {"title": self.title, "output": {"file": self.output.file}, "studies": studies}
        case: dict[str, Any] = _plain(self)
        if self._axes:
            case["sweep"] = resolved_sweep(self._axes)
        return case

    def to_yaml(self) -> str:
        """The whole case as a case file in SI; loading it gives an equal case."""
        return emit_yaml(self.resolved())

    @property
    def sha256(self) -> str:
        """SHA-256 of all that decides the results: `resolved()` without output.file, axes value by value."""
        if self._studies:
            text = "".join(f"{name} {study.sha256}\n" for name, study in self._studies.items())
            return hashlib.sha256(text.encode()).hexdigest()
        case = self.resolved()
        case["output"] = {key: value for key, value in case["output"].items() if key != "file"}
        case["sweep"] = [
            [[column.key, list(column.values)] for column in axis.members or (axis,)] for axis in self._axes
        ]
        refined = [axis.refinement for axis in self._axes if axis.refinement is not None]
        if refined:
            case["refine"] = [[r.per_step, r.tolerance, r.channels] for r in refined]
        canonical = json.dumps(case, sort_keys=True, separators=(",", ":"), allow_nan=False)
        return hashlib.sha256(canonical.encode()).hexdigest()

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, Case)
            and self.resolved() == other.resolved()
            and self._axes == other._axes
            and self._studies == other._studies
        )

    def __hash__(self) -> int:
        return hash(self.sha256)


def union(studies: dict[str, Case], title: str) -> Case:
    """The case that stands for several, by name, whose results go into one file."""
    first = next(iter(studies.values())).replacing("title", title)
    warnings = dict.fromkeys(text for study in studies.values() for text in study.warnings)
    named = {name: study._holding(_study=name) for name, study in studies.items()}
    return first._holding(_axes=(), _warnings=tuple(warnings), _studies=named)


def _plain(value: Any) -> Any:
    if isinstance(value, Damping):
        return value.value if value.form == "coefficient" else {value.form: value.value}
    if isinstance(value, Stations):
        return list(value.positions) or ({"fractions": list(value.fractions)} if value.fractions else None)
    if isinstance(value, Histories):
        if not value.stored:
            return "none"
        if value.channels is None and value.every is None:
            return "all"
        channels = "all" if value.channels is None else list(value.channels)
        return {"channels": channels} | ({} if value.every is None else {"every": value.every})
    if isinstance(value, Part):
        fields = (
            (info.alias or name, getattr(value, name)) for name, info in type(value).model_fields.items()
        )
        found = ((key, _plain(field)) for key, field in fields if field is not None)
        return {key: plain for key, plain in found if plain is not None}
    return [_plain(item) for item in value] if isinstance(value, tuple) else value
