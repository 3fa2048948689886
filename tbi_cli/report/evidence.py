"""Where in the given results a number of the paper would be: the studies of its train and bridge."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from tbi_cli.case import Case, FullTrain
from tbi_cli.case.units import to_si
from tbi_cli.report.marks import axle_distance
from tbi_cli.report.study import Array, Study
from tbi_cli.store import DONE

# The run that the paper speaks of where it names nothing else.
BASE: Mapping[str, float] = {
    "velocity": 300 / 3.6,
    "car_body_mass": 40e3,
    "span": 50.0,
    "damping": 10e3,
    "modes": 4,
    "sampling": 0.001,
}
_UNITS = {"velocity": "m/s", "car_body_mass": "kg", "span": "m", "damping": "N*s/m^2", "sampling": "s"}
# EI/mu of the beams (m4/s2): all that is certain of them.
_STIFFNESS_BY_MASS = {"right": 2.07e6, "left": 2.2222e6}
_FEWEST_SPEEDS = 20


def is_papers(case: Case | None) -> bool:
    """Whether a case is the paper's, as far as is certain: 31 DOF, beams, static load, axles 20 m apart."""
    if case is None or not isinstance(case.train, FullTrain) or case.bridge.left is None:
        return False
    beams = {"right": case.bridge.right, "left": case.bridge.left}
    return (
        case.contact.static_load == "paper"
        and bool(np.isclose(axle_distance(case), 20.0, rtol=1e-4))
        and all(
            np.isclose(
                b.youngs_modulus * b.second_moment / b.mass_per_length, _STIFFNESS_BY_MASS[side], rtol=1e-3
            )
            for side, b in beams.items()
        )
    )


@dataclass(frozen=True)
class Curve:
    """A response over velocity: velocities (n,) in m/s, values (n,)."""

    velocity: Array
    value: Array


class Evidence:
    """Finds points, curves and histories in those of the studies that are the paper's."""

    def __init__(self, studies: Sequence[Study]) -> None:
        self.studies = [study for study in studies if is_papers(study.case_at({}))]

    @property
    def case(self) -> Case | None:
        """The paper's case at 300 km/h and its other base values, for what follows from formulas."""
        for study in self.studies:
            case = study.case_at({})
            if case is not None:
                bridge = case.bridge.replacing("length", BASE["span"]).replacing("modes", 4)
                return case.replacing("velocity", BASE["velocity"]).replacing("bridge", bridge)
        return None

    def where(self, at: Mapping[str, float], table: str, channel: str) -> tuple[Study, dict[str, int]] | None:
        """The first study that holds this point, solved, and its place there."""
        for study in self.studies:
            place = _place(study, {**BASE, **at})
            if place is None or not study.has(table, channel):
                continue
            if study.status[tuple(place[axis.name] for axis in study.axes)] == DONE:
                return study, place
        return None

    def point(self, table: str, channel: str, at: Mapping[str, float]) -> float | None:
        """One number of a table, at the base values and `at`; None if no study has it."""
        found = self.where(at, table, channel)
        if found is None:
            return None
        study, place = found
        value = float(study.along(table, channel, [], place))
        return value if np.isfinite(value) else None

    def curve(self, table: str, channel: str, at: Mapping[str, float]) -> Curve | None:
        """A response over the whole of the velocities, the first of the studies that have it."""
        for study in self.studies:
            axis = study.axis("velocity")
            place = _place(study, {**BASE, **at}, free="velocity")
            if (
                axis is None
                or len(axis.values) < _FEWEST_SPEEDS
                or place is None
                or not study.has(table, channel)
            ):
                continue
            values = study.along(table, channel, [axis], place)
            if np.isfinite(values).all():
                return Curve(axis.values, values)
        return None

    def values_of(self, key: str) -> list[float]:
        """The values of an axis in the first study that has it beside velocity: for each there is a curve."""
        for study in self.studies:
            axis, velocity = study.axis(key), study.axis("velocity")
            if (
                axis is not None
                and axis.varies
                and velocity is not None
                and len(velocity.values) >= _FEWEST_SPEEDS
            ):
                return list(axis.values.tolist())
        return []


def si(key: str, value: object) -> float:
    """A value of one of the axes as it stands in claims.yaml: a number in SI, or text with a unit."""
    return to_si(value, _UNITS.get(key, "1")) if isinstance(value, str) else float(value)  # type: ignore[arg-type]


def _place(study: Study, at: Mapping[str, float], free: str | None = None) -> dict[str, int] | None:
    """Where these values are in a study; None if it has others."""
    place: dict[str, int] = {}
    for key, wanted in at.items():
        if key == free:
            continue
        axis = study.axis(key)
        if axis is not None:
            if not np.isclose(axis.values[axis.nearest(wanted)], wanted, rtol=1e-6):
                return None
            place[axis.name] = axis.nearest(wanted)
        else:
            value = study.value(key, {})
            if value is None or not np.isclose(value, wanted, rtol=1e-6):
                return None
    if any(axis.name not in place for axis in study.varied if free is None or axis is not study.axis(free)):
        return None
    return {axis.name: place.get(axis.name, 0) for axis in study.axes}
