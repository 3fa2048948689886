"""What is free in Table 1: parameters with bounds from published vehicles, and discrete choices."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Parameter:
    """One number of Table 1: its symbol, what the built-in `paper` has, its bounds and where they were read.

    keys: the keys of the case that it sets, each with the factor from the parameter to the key's value.
    """

    symbol: str
    unit: str
    published: float
    lower: float
    upper: float
    source: str
    keys: tuple[tuple[str, float], ...]


def _train(
    key: str, symbol: str, unit: str, published: float, lower: float, upper: float, source: str
) -> Parameter:
    return Parameter(symbol, unit, published, lower, upper, source, ((f"train.{key}", 1.0),))


def _beam(side: str, symbol: str, published: float, stiffness_by_mass: float, modulus: float) -> Parameter:
    """mu of a beam; I follows, so that EI/mu (m4/s2), which the frequencies of Table 2 fix, stays."""
    keys = (
        (f"bridge.{side}.mass_per_length", 1.0),
        (f"bridge.{side}.second_moment", stiffness_by_mass / modulus),
    )
    source = "the built-in composite-40m .. the paper's second verification case (section 3.1)"
    return Parameter(symbol, "kg/m", published, 6e3, 36e3, source, keys)


# Bounds are the least and the largest of published vehicles: CRH380A (data sheet values); Zhai's high-speed
# and ordinary passenger cars (Vehicle-Track Coupled Dynamics, appendix); ICE3 motor car; Shinkansen 300 (Wu
# and Yang 2003); Velaro E (Goicolea, UPM); Manchester benchmark (Iwnicki 1998).  All are built-in trains.
PARAMETERS: tuple[Parameter, ...] = (
    _beam("right", "mu right", 20e3, 2.07e6, 207e9),
    _beam("left", "mu left", 18e3, 40e9 / 18e3, 200e9),
    _train("car_body.roll_inertia", "I_cx", "kg m2", 110.2e3, 75.06e3, 115e3, "Zhai high-speed .. ICE3"),
    _train("car_body.yaw_inertia", "I_cy", "kg m2", 1.5722e6, 1.5722e6, 2.996e6, "CRH380A .. Zhai ordinary"),
    _train("car_body.pitch_inertia", "I_cz", "kg m2", 1.666e6, 1.666e6, 2.966e6, "CRH380A .. Zhai ordinary"),
    _train("bogie.mass", "m_b", "kg", 2280, 2280, 3500, "CRH380A .. Velaro E"),
    _train("bogie.roll_inertia", "I_bx", "kg m2", 1847, 1847, 3200, "CRH380A .. ICE3"),
    _train("bogie.yaw_inertia", "I_by", "kg m2", 2280, 2280, 6800, "CRH380A .. ICE3"),
    _train("bogie.pitch_inertia", "I_bz", "kg m2", 1249, 1249, 7200, "CRH380A .. ICE3"),
    # Eq. (13a) counts eight m_w: it may be the mass of one wheel, half of a wheelset.
    _train("wheelset.mass", "m_w", "kg", 1901.8, 700, 2400, "half of Zhai high-speed's .. ICE3"),
    _train("wheelset.roll_inertia", "I_wx", "kg m2", 685, 685, 1200, "CRH380A .. ICE3"),
    _train("wheelset.yaw_inertia", "I_wy", "kg m2", 685, 685, 1120, "CRH380A .. Zhai ordinary"),
    _train("secondary.vertical.stiffness", "k_by", "N/m", 260e3, 260e3, 430e3, "CRH380A .. Manchester"),
    _train("secondary.vertical.damping", "c_by", "N s/m", 40e3, 20e3, 80e3, "Velaro E .. Zhai high-speed"),
    _train("secondary.lateral.stiffness", "k_bz", "N/m", 168.9e3, 90e3, 480e3, "Zhai ordinary .. ICE3"),
    _train("secondary.lateral.damping", "c_bz", "N s/m", 58.8e3, 30e3, 60e3, "ICE3 .. Zhai high-speed"),
    _train("secondary.longitudinal.stiffness", "k_bx", "N/m", 168.9e3, 130e3, 168.9e3, "Zhai .. CRH380A"),
    _train(
        "primary.vertical.stiffness", "k_wy", "N/m", 1.176e6, 0.55e6, 1.2e6, "Zhai high-speed .. Velaro E"
    ),
    _train("primary.vertical.damping", "c_wy", "N s/m", 29.6e3, 4e3, 50e3, "Manchester .. ICE3"),
    _train("primary.lateral.stiffness", "k_wz", "N/m", 0.98e6, 0.98e6, 5e6, "CRH380A .. Zhai high-speed"),
    _train(
        "primary.longitudinal.stiffness", "k_wx", "N/m", 0.98e6, 0.98e6, 10e6, "CRH380A .. Zhai high-speed"
    ),
    _train("geometry.secondary_half_spacing", "a", "m", 1.23, 0.95, 1.23, "ICE3 .. CRH380A"),
    _train("geometry.primary_half_spacing", "d", "m", 1.0, 0.978, 1.0, "Zhai high-speed .. CRH380A"),
    _train("geometry.car_body_to_secondary", "h_c", "m", 0.52, 0.52, 1.415, "CRH380A .. Zhai high-speed"),
    _train("geometry.secondary_to_bogie", "h_b", "m", 0.29, -0.081, 0.3, "Zhai high-speed .. ICE3"),
    _train("geometry.bogie_to_axle", "h_w", "m", 0.08, -0.05, 0.14, "ICE3 .. Zhai high-speed"),
)


def to_unit(parameters: Sequence[Parameter], values: Array) -> Array:
    """Values of the parameters as shares of their ranges, 0 .. 1."""
    lower, upper = limits(parameters)
    return (values - lower) / (upper - lower)


def from_unit(parameters: Sequence[Parameter], shares: Array) -> Array:
    """Values of the parameters from shares of their ranges."""
    lower, upper = limits(parameters)
    return lower + shares * (upper - lower)


def limits(parameters: Sequence[Parameter]) -> tuple[Array, Array]:
    """The lower and the upper bounds."""
    return np.array([p.lower for p in parameters]), np.array([p.upper for p in parameters])


def published(parameters: Sequence[Parameter]) -> Array:
    """The built-in vehicle and bridge as shares of the ranges."""
    return to_unit(parameters, np.array([p.published for p in parameters]))


@dataclass(frozen=True)
class Choice:
    """One combination of what is either so or so."""

    static_load: str
    damping: float  # c of both beams, N s/m2
    convective: bool
    bogie_distance: float
    wheelbase: float

    @property
    def overrides(self) -> list[str]:
        """The same as options of a case."""
        return [
            f"contact.static_load={self.static_load}",
            f"contact.convective={str(self.convective).lower()}",
            f"bridge.right.damping={self.damping}",
            f"bridge.left.damping={self.damping}",
            f"train.geometry.bogie_distance={self.bogie_distance}",
            f"train.geometry.wheelbase={self.wheelbase}",
        ]

    def __str__(self) -> str:
        convective = "on" if self.convective else "off"
        return (
            f"load {self.static_load}, c = {self.damping / 1e3:g} kN s/m2, convective {convective}, "
            f"bogies {self.bogie_distance:g} m, wheelbase {self.wheelbase:g} m"
        )


PUBLISHED_CHOICE = Choice("paper", 10e3, False, 17.5, 2.5)
CHOICES: tuple[Choice, ...] = tuple(
    Choice(load, damping, convective, *geometry)
    for load, damping, convective, geometry in product(
        ("paper", "physical"), (10e3, 5e3, 1e3), (False, True), ((17.5, 2.5), (15.0, 5.0))
    )
)
