"""Vehicles and bridge as matrices: Lagrange's equations (7), (8) of everything that a case describes."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from tbi_cli.case import Case, Consist, Train
from tbi_cli.system.bridge import BeamModes, beam_modes
from tbi_cli.system.trains import SIDES, build_vehicle
from tbi_cli.system.vehicle import Coordinate, Row, Vehicle, coupled

Matrix = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class System:
    """One train and one bridge, ready to be integrated at any speed.

    A train of several vehicles has them as `coaches`, front to rear, and its coordinates, wheels and axles
    are theirs in this order; any other train has none.  A wheel stands on beam `wheel_beam` of `beams` and
    belongs to axle `wheel_axle`.  `stations` (m) are where the beams are looked at besides mid-span.
    """

    vehicle: Vehicle
    beams: tuple[BeamModes, ...]
    convective: bool
    unilateral: bool
    stations: tuple[float, ...] = ()
    coaches: tuple[Coach, ...] = ()

    @cached_property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """The coordinates of the train: (body, motion)."""
        return self.vehicle.coordinates

    @cached_property
    def M(self) -> Matrix:
        """Mass or moment of inertia of each coordinate, (nv,): the diagonal of the mass matrix."""
        return np.array([value for body in self.vehicle.bodies for value in body.inertia.values()])

    @cached_property
    def K_links(self) -> Matrix:
        """Stiffness (nv, nv) of the train, its wheels on nothing: sum k g g^T."""
        return self._sum_of_squares([link.stiffness for link in self.vehicle.links])

    @cached_property
    def C_links(self) -> Matrix:
        """Damping (nv, nv) of the train, its wheels on nothing: sum c g g^T."""
        return self._sum_of_squares([link.damping for link in self.vehicle.links])

    def _sum_of_squares(self, factors: list[float]) -> Matrix:
        nv = len(self.coordinates)
        total = np.zeros((nv, nv))
        for link, factor in zip(self.vehicle.links, factors, strict=True):
            g = row_vector(link.row, self.coordinates)
            at = np.flatnonzero(g)
            total[np.ix_(at, at)] += factor * np.outer(g[at], g[at])
        return total

    @cached_property
    def K(self) -> Matrix:
        """Stiffness on level, rigid track, with the wheels' suspension in it."""
        return self.K_links + self.wheel_rows.T @ (self.wheel_stiffness[:, None] * self.wheel_rows)

    @cached_property
    def C(self) -> Matrix:
        """Damping on level, rigid track, with the wheels' suspension in it."""
        return self.C_links + self.wheel_rows.T @ (self.wheel_damping[:, None] * self.wheel_rows)

    @cached_property
    def wheel_rows(self) -> Matrix:
        """The stretch of each wheel's suspension on rigid track: rows over the coordinates, (wheels, nv)."""
        rows = [row_vector(wheel.suspension.row, self.coordinates) for wheel in self.vehicle.wheels]
        return np.array(rows).reshape(len(rows), len(self.coordinates))

    @cached_property
    def wheel_stiffness(self) -> Matrix:
        """Stiffness (N/m) of each wheel's suspension."""
        return np.array([wheel.suspension.stiffness for wheel in self.vehicle.wheels])

    @cached_property
    def wheel_damping(self) -> Matrix:
        """Damping (N s/m) of each wheel's suspension."""
        return np.array([wheel.suspension.damping for wheel in self.vehicle.wheels])

    @cached_property
    def wheel_load(self) -> Matrix:
        """Static load (N) of each wheel."""
        return np.array([wheel.load for wheel in self.vehicle.wheels])

    @cached_property
    def wheel_axle(self) -> NDArray[np.int64]:
        """The axle of each wheel."""
        return np.array([wheel.axle for wheel in self.vehicle.wheels], dtype=np.int64)

    @cached_property
    def wheel_beam(self) -> NDArray[np.int64]:
        """The beam under each wheel."""
        return np.array([SIDES.index(wheel.side) for wheel in self.vehicle.wheels], dtype=np.int64)

    @cached_property
    def axle_offsets(self) -> Matrix:
        """Distance (m) of each axle behind the first."""
        return np.array(self.vehicle.axle_offsets)

    @property
    def constant_forces(self) -> bool:
        """Whether all wheels are constant forces, on one beam: nothing swings but the beam."""
        springs = self.wheel_stiffness.any() or self.wheel_damping.any() or self.wheel_rows.any()
        return len(self.beams) == 1 and not springs

    @property
    def length(self) -> float:
        """Span (m)."""
        return self.beams[0].length

    @property
    def axle_distance(self) -> float:
        """Distance (m) from the first axle to the last."""
        return float(self.axle_offsets[-1])


@dataclass(frozen=True, eq=False)
class Coach:
    """One vehicle of a train: its system by itself, shared by equal ones, and where it stands in the train's.

    The train's coordinates, wheels and axles from `first_coordinate`, `first_wheel` and `first_axle` on are
    those of this vehicle.
    """

    system: System
    first_coordinate: int
    first_wheel: int
    first_axle: int


def row_vector(row: Row, coordinates: tuple[Coordinate, ...]) -> Matrix:
    """A row as a vector over the coordinates; what multiplies no coordinate must be zero."""
    vector = np.zeros(len(coordinates))
    place = {coordinate: i for i, coordinate in enumerate(coordinates)}
    for coordinate, value in row.items():
        if value != 0.0:
            vector[place[coordinate]] += value
    return vector


def coach_name(number: int) -> str:
    """The name of a vehicle of a train, counted from 0 at the front."""
    return f"coach_{number + 1}"


def build_system(case: Case) -> System:
    """The train and the bridge of a case without sweep."""
    sides = [case.bridge.right, case.bridge.left]
    beams = tuple(beam_modes(case.bridge, beam) for beam in sides if beam is not None)
    unilateral = case.contact.model == "hertz"
    convective = case.contact.convective or unilateral

    def system(vehicle: Vehicle, coaches: tuple[Coach, ...] = ()) -> System:
        return System(vehicle, beams, convective, unilateral, case.bridge.places, coaches)

    if not isinstance(case.train, Consist):
        return system(build_vehicle(case.train, case))
    row: list[tuple[System, float]] = []
    different: list[tuple[Train, System]] = []
    for group, fronts in zip(case.train.consist, case.train.fronts, strict=True):
        one = next((known for vehicle, known in different if vehicle == group.vehicle), None)
        if one is None:
            one = system(build_vehicle(group.vehicle, case))
            different.append((group.vehicle, one))
        row += [(one, front) for front in fronts]
    coaches: list[Coach] = []
    coordinate = wheel = axle = 0
    for one, _ in row:
        coaches.append(Coach(one, coordinate, wheel, axle))
        coordinate += len(one.coordinates)
        wheel += len(one.vehicle.wheels)
        axle += len(one.vehicle.axle_offsets)
    whole = coupled([(coach_name(i), one.vehicle, front) for i, (one, front) in enumerate(row)])
    return system(whole, tuple(coaches))


def equal_coaches(system: System) -> list[tuple[System, int]]:
    """The different vehicles of a train by themselves, and how many of each can be on the bridge at once.

    A train of one vehicle is that vehicle, once.
    """
    if not system.coaches:
        return [(system, 1)]
    fronts: dict[int, list[float]] = {}
    for coach in system.coaches:
        fronts.setdefault(id(coach.system), []).append(float(system.axle_offsets[coach.first_axle]))
    kinds = {id(coach.system): coach.system for coach in system.coaches}
    return [(one, _most_within(fronts[key], one.length + one.axle_distance)) for key, one in kinds.items()]


def _most_within(places: list[float], distance: float) -> int:
    """How many of some places, in rising order, lie within a distance of each other at most."""
    behind = np.searchsorted(places, np.array(places) + distance, side="right")
    return int(np.max(behind - np.arange(len(places))))
