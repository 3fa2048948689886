"""Parameters of a crossing by the 31-degree-of-freedom train, read from the mappings of a case file.

Only plain dicts of SI numbers come in, and only frozen dataclasses go out, so that the references share
neither code nor data types with the solver.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

STANDARD_GRAVITY = 9.81


@dataclass(frozen=True)
class Spring:
    """Stiffness [N/m] and damping [N s/m] of one spring-damper."""

    k: float
    c: float


@dataclass(frozen=True)
class Bogie:
    """One bogie with its share of the secondary suspension (one side) and primary suspension (one wheel)."""

    mass: float
    roll: float
    yaw: float
    pitch: float
    secondary_vertical: Spring
    secondary_lateral: Spring
    secondary_longitudinal: Spring
    primary_vertical: Spring
    primary_lateral: Spring
    primary_longitudinal: Spring


@dataclass(frozen=True)
class Train:
    """The full train; lengths by the paper's symbols."""

    car_mass: float
    car_roll: float
    car_yaw: float
    car_pitch: float
    bogies: tuple[Bogie, Bogie]
    wheelset_mass: float
    wheelset_roll: float
    wheelset_yaw: float
    l_b: tuple[float, float]
    l_w: tuple[float, float, float, float]
    a: float
    d: float
    h_c: float
    h_b: float
    h_w: float

    @property
    def axle_distances(self) -> Array:
        """(4,) distance [m] of each axle behind the first."""
        (l_b1, l_b2), (l_w1, l_w2, l_w3, l_w4) = self.l_b, self.l_w
        x = np.array([l_b1 + l_w1, l_b1 - l_w2, -l_b2 + l_w3, -l_b2 - l_w4])
        distances: Array = x[0] - x
        return distances


@dataclass(frozen=True)
class Beam:
    """One simply supported beam with n modes: Eqs. (5), (6), (14)."""

    length: float
    EI: float
    mu: float
    n: int
    damping: tuple[float, ...]

    @property
    def wave_numbers(self) -> Array:
        """(n,) i pi / L."""
        return np.arange(1.0, self.n + 1) * (math.pi / self.length)

    @property
    def omega(self) -> Array:
        """(n,) circular natural frequencies [rad/s], Eq. (14)."""
        omega: Array = self.wave_numbers**2 * math.sqrt(self.EI / self.mu)
        return omega

    @property
    def c(self) -> Array:
        """(n,) damping of each mode [N s/m per m]."""
        return np.array(self.damping)


@dataclass(frozen=True)
class Crossing:
    """A train over two beams, with what else a case says."""

    train: Train
    right: Beam
    left: Beam
    velocity: float
    static_load: str = "physical"
    convective: bool = False
    gravity: float = STANDARD_GRAVITY


def crossing_from_case(case: Mapping[str, Any]) -> Crossing:
    """The crossing that a case describes: a mapping with the keys of the case file, every number SI."""
    bridge, contact = case["bridge"], case.get("contact") or {}
    n, length = int(bridge.get("modes", 4)), float(bridge["length"])
    return Crossing(
        train=train_from_mapping(case["train"]),
        right=beam_from_mapping(bridge["right"], length, n),
        left=beam_from_mapping(bridge["left"], length, n),
        velocity=float(case["velocity"]),
        static_load=str(contact.get("static_load", "physical")),
        convective=bool(contact.get("convective", False)),
        gravity=float(case.get("gravity", STANDARD_GRAVITY)),
    )


def beam_from_mapping(beam: Mapping[str, Any], length: float, n: int) -> Beam:
    """One beam from its mapping; damping as c, or a ratio of the first mode, or one ratio for all modes."""
    EI, mu = float(beam["youngs_modulus"]) * float(beam["second_moment"]), float(beam["mass_per_length"])
    i = np.arange(1, n + 1)
    omega = (i * math.pi / length) ** 2 * math.sqrt(EI / mu)
    given = beam.get("damping", 0.0)
    if not isinstance(given, Mapping):
        given = {"coefficient": given}
    given = {form: value for form, value in given.items() if value is not None}
    if "coefficient" in given:
        c = np.full(n, float(given["coefficient"]))
    elif "first_mode_ratio" in given:
        c = np.full(n, 2 * float(given["first_mode_ratio"]) * mu * omega[0])
    else:
        c = 2 * float(given["ratio"]) * mu * omega
    return Beam(length, EI, mu, n, tuple(float(x) for x in c))


def train_from_mapping(train: Mapping[str, Any]) -> Train:
    """The 31-degree-of-freedom train from its mapping (the contract's keys, front and rear overrides too)."""
    car, wheelset, geometry = train["car_body"], train["wheelset"], train["geometry"]
    return Train(
        car_mass=float(car["mass"]),
        car_roll=float(car["roll_inertia"]),
        car_yaw=float(car["yaw_inertia"]),
        car_pitch=float(car["pitch_inertia"]),
        bogies=(_bogie(train, "front_bogie"), _bogie(train, "rear_bogie")),
        wheelset_mass=float(wheelset["mass"]),
        wheelset_roll=float(wheelset["roll_inertia"]),
        wheelset_yaw=float(wheelset["yaw_inertia"]),
        l_b=_arms(geometry, "bogie_distance", "l_b1", "l_b2"),
        l_w=(*_arms(geometry, "wheelbase", "l_w1", "l_w2"), *_arms(geometry, "wheelbase", "l_w3", "l_w4")),
        a=float(geometry["secondary_half_spacing"]),
        d=float(geometry["primary_half_spacing"]),
        h_c=float(geometry["car_body_to_secondary"]),
        h_b=float(geometry["secondary_to_bogie"]),
        h_w=float(geometry["bogie_to_axle"]),
    )


def _arms(geometry: Mapping[str, Any], whole: str, first: str, second: str) -> tuple[float, float]:
    """Two arms [m] given one by one, or one and the whole, or the whole alone, halved."""
    one, other, total = geometry.get(first), geometry.get(second), geometry.get(whole)
    if one is not None and other is not None:
        return float(one), float(other)
    if total is None:
        raise ValueError(f"train.geometry needs {whole}, or both {first} and {second}")
    if one is not None:
        return float(one), float(total) - float(one)
    if other is not None:
        return float(total) - float(other), float(other)
    return float(total) / 2, float(total) / 2


def _bogie(train: Mapping[str, Any], end: str) -> Bogie:
    own = train.get(end) or {}
    common = train.get("bogie") or {}

    def number(key: str) -> float:
        return float(own[key] if own.get(key) is not None else common[key])

    def spring(stage: str, direction: str) -> Spring:
        values = dict((train.get(stage) or {}).get(direction) or {})
        values.update((own.get(stage) or {}).get(direction) or {})
        return Spring(float(values["stiffness"]), float(values.get("damping", 0.0)))

    return Bogie(
        mass=number("mass"),
        roll=number("roll_inertia"),
        yaw=number("yaw_inertia"),
        pitch=number("pitch_inertia"),
        secondary_vertical=spring("secondary", "vertical"),
        secondary_lateral=spring("secondary", "lateral"),
        secondary_longitudinal=spring("secondary", "longitudinal"),
        primary_vertical=spring("primary", "vertical"),
        primary_lateral=spring("primary", "lateral"),
        primary_longitudinal=spring("primary", "longitudinal"),
    )
