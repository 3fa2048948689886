"""Vehicles as data: bodies, spring-dampers and wheels.

A point fixed to a body at (X, Y, Z) from its centre of mass moves, for small rotations, by r + theta x (X, Y,
Z). A spring-damper joins two such points: its stretch is one row of numbers times the coordinates.  Every
bracket of the paper's Eqs. (1b), (1c) and (12a-f) is such a row, and Lagrange's equations (7) are sums over
the rows.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

Coordinate = tuple[str, str]  # (body, motion): ("front_bogie", "pitch")
Row = Mapping[Coordinate, float]
Side = Literal["right", "left"]


@dataclass(frozen=True)
class Body:
    """A rigid body: its name, and the inertia (kg or kg m2) of each motion that it is free to make."""

    name: str
    inertia: Mapping[str, float]


@dataclass(frozen=True)
class SpringDamper:
    """A spring (N/m) and a damper (N s/m) side by side, with the row that gives their stretch (m)."""

    row: Row
    stiffness: float
    damping: float


@dataclass(frozen=True)
class Wheel:
    """A wheel that presses on a beam: its axle, its side, its static load (N) and the suspension above it.

    The stretch of the suspension is the row times the coordinates, less the level under the wheel.  Where
    the wheel has a mass of its own, what presses on the rail is a contact spring, and `primary` is above it.
    """

    axle: int
    side: Side
    load: float
    suspension: SpringDamper
    primary: SpringDamper | None = None


@dataclass(frozen=True)
class Vehicle:
    """Bodies, the spring-dampers between them, the wheels, and each axle's distance (m) behind the first."""

    bodies: tuple[Body, ...]
    links: tuple[SpringDamper, ...]
    wheels: tuple[Wheel, ...]
    axle_offsets: tuple[float, ...]

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """The coordinates in order: body by body, motion by motion [Eq. (9)]."""
        return tuple((body.name, motion) for body in self.bodies for motion in body.inertia)


def vertical(body: str, x: float = 0.0, z: float = 0.0) -> Row:
    """Vertical displacement r_y + theta_z X - theta_x Z of a point of a body."""
    return {(body, "y"): 1.0, (body, "pitch"): x, (body, "roll"): -z}


def lateral(body: str, x: float = 0.0, y: float = 0.0) -> Row:
    """Lateral displacement r_z + theta_x Y - theta_y X of a point of a body."""
    return {(body, "z"): 1.0, (body, "roll"): y, (body, "yaw"): -x}


def longitudinal(body: str, z: float) -> Row:
    """Longitudinal displacement theta_y Z of a point of a body by its yaw."""
    return {(body, "yaw"): z}


def between(a: Row, b: Row) -> Row:
    """The stretch of a spring from point b to point a."""
    return {key: a.get(key, 0.0) - b.get(key, 0.0) for key in (*a, *(key for key in b if key not in a))}


def without(row: Row, *coordinates: Coordinate) -> Row:
    """A row less some of its coordinates."""
    return {key: value for key, value in row.items() if key not in coordinates}


def coupled(row: Sequence[tuple[str, Vehicle, float]]) -> Vehicle:
    """Vehicles on one track as one: each with its name, and its first axle's distance (m) behind the train's.

    The name is put before those of its bodies.
    """
    bodies: list[Body] = []
    links: list[SpringDamper] = []
    wheels: list[Wheel] = []
    offsets: list[float] = []
    for name, vehicle, front in row:
        first = len(offsets)
        bodies += [Body(f"{name}_{body.name}", body.inertia) for body in vehicle.bodies]
        links += [_named(link, name) for link in vehicle.links]
        for wheel in vehicle.wheels:
            primary = None if wheel.primary is None else _named(wheel.primary, name)
            suspension = _named(wheel.suspension, name)
            wheels.append(Wheel(first + wheel.axle, wheel.side, wheel.load, suspension, primary))
        offsets += [front + offset for offset in vehicle.axle_offsets]
    return Vehicle(tuple(bodies), tuple(links), tuple(wheels), tuple(offsets))


def _named(part: SpringDamper, name: str) -> SpringDamper:
    row = {(f"{name}_{body}", motion): value for (body, motion), value in part.row.items()}
    return SpringDamper(row, part.stiffness, part.damping)


def with_loads(vehicle: Vehicle, load: float) -> Vehicle:
    """The same vehicle with one static load on every wheel."""
    return replace(vehicle, wheels=tuple(replace(wheel, load=load) for wheel in vehicle.wheels))
