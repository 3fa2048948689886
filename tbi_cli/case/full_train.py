"""The 31-DOF train, as written in a case file; every number in SI.

Its keys are the symbols of the paper's nomenclature. Stiffness and damping of `secondary` are for one side
of one bogie, of `primary` for one wheel.
"""

from __future__ import annotations

from functools import cached_property
from typing import Annotated, Literal, TypeVar

from pydantic import Field

from tbi_cli.case.fields import DAMPING, INERTIA, MASS, STIFFNESS, Quantity
from tbi_cli.case.geometry import Geometry
from tbi_cli.case.part import Part


def _inertia(text: str, example: str, usual: tuple[float, float]) -> Quantity:
    return Quantity(text, INERTIA, example, usual=usual)


_BODY_INERTIA = (1e3, 1e8)
_BOGIE_INERTIA = (50.0, 1e5)
_WHEELSET_INERTIA = (10.0, 1e4)
_BOGIE_MASS = Quantity("bogie mass m_b, frame without wheelsets", MASS, "2280 kg", usual=(200, 20e3))
_BOGIE_ROLL = _inertia("bogie roll inertia I_bx, about x", "1847 kg*m^2", _BOGIE_INERTIA)
_BOGIE_YAW = _inertia("bogie yaw inertia I_by, about y", "2280 kg*m^2", _BOGIE_INERTIA)
_BOGIE_PITCH = _inertia("bogie pitch inertia I_bz, about z", "1249 kg*m^2", _BOGIE_INERTIA)


class CarBody(Part):
    """The car body, a rigid body."""

    mass: Annotated[float, Quantity("car body mass m_c", MASS, "40 t", usual=(2e3, 200e3))]
    roll_inertia: Annotated[
        float, _inertia("car body roll inertia I_cx, about x", "110.2 t*m^2", _BODY_INERTIA)
    ]
    yaw_inertia: Annotated[
        float, _inertia("car body yaw inertia I_cy, about y", "1572.2 t*m^2", _BODY_INERTIA)
    ]
    pitch_inertia: Annotated[
        float, _inertia("car body pitch inertia I_cz, about z", "1666 t*m^2", _BODY_INERTIA)
    ]


class Bogie(Part):
    """One bogie frame, a rigid body."""

    mass: Annotated[float, _BOGIE_MASS]
    roll_inertia: Annotated[float, _BOGIE_ROLL]
    yaw_inertia: Annotated[float, _BOGIE_YAW]
    pitch_inertia: Annotated[float, _BOGIE_PITCH]


class Wheelset(Part):
    """One wheelset: two wheels and their axle."""

    mass: Annotated[float, Quantity("wheelset mass m_w", MASS, "1901.8 kg", usual=(200, 10e3))]
    roll_inertia: Annotated[float, _inertia("wheelset roll inertia I_wx", "685 kg*m^2", _WHEELSET_INERTIA)]
    yaw_inertia: Annotated[float, _inertia("wheelset yaw inertia I_wy", "685 kg*m^2", _WHEELSET_INERTIA)]


_K = Quantity("stiffness k", STIFFNESS, "260 kN/m", usual=(1e3, 1e9))
_K_OR_NONE = Quantity("stiffness k; 0 for none", STIFFNESS, "168.9 kN/m", "not negative", usual=(1e3, 1e9))
_C = Quantity("damping c; 0 for none", DAMPING, "40 kN*s/m", "not negative", usual=(1.0, 1e7))


class CarryingSpring(Part):
    """A spring-damper that carries weight: its stiffness is positive."""

    stiffness: Annotated[float, _K]
    damping: Annotated[float, _C]


class SpringDamper(Part):
    """A spring-damper that may be absent (both zero)."""

    stiffness: Annotated[float, _K_OR_NONE]
    damping: Annotated[float, _C]


class Suspension(Part):
    """Three spring-dampers at one place, along y, z and x."""

    vertical: CarryingSpring
    lateral: SpringDamper
    longitudinal: SpringDamper


class SpringDamperOverride(Part):
    """What of a spring-damper is different at one end."""

    stiffness: Annotated[float, _K_OR_NONE] | None = None
    damping: Annotated[float, _C] | None = None


class CarryingSpringOverride(Part):
    """What of a weight-carrying spring-damper is different at one end."""

    stiffness: Annotated[float, _K] | None = None
    damping: Annotated[float, _C] | None = None


class SuspensionOverride(Part):
    """What of a suspension is different at one end."""

    vertical: CarryingSpringOverride | None = None
    lateral: SpringDamperOverride | None = None
    longitudinal: SpringDamperOverride | None = None


class BogieOverride(Part):
    """What is different at one end of the train: keys of `bogie`, and of `secondary` and `primary` there."""

    mass: Annotated[float, _BOGIE_MASS] | None = None
    roll_inertia: Annotated[float, _BOGIE_ROLL] | None = None
    yaw_inertia: Annotated[float, _BOGIE_YAW] | None = None
    pitch_inertia: Annotated[float, _BOGIE_PITCH] | None = None
    secondary: SuspensionOverride | None = None
    primary: SuspensionOverride | None = None


class BogieEnd(Bogie):
    """One end of the train with nothing left open: its bogie, the suspension above it and the one below."""

    secondary: Suspension
    primary: Suspension


_Same = TypeVar("_Same", bound=Part)


def _overridden(base: _Same, override: Part | None) -> _Same:
    """`base` with whatever `override` gives in its place."""
    if override is None:
        return base
    values = {name: getattr(base, name) for name in type(base).model_fields}
    for name in type(override).model_fields:
        given = getattr(override, name)
        if given is not None:
            values[name] = _overridden(values[name], given) if isinstance(given, Part) else given
    return base.model_construct(**values)


class FullTrain(Part):
    """The paper's 31-DOF train: car body, two bogies, four wheelsets, two stages of suspension.

    `front_bogie` and `rear_bogie` are the two ends with nothing left open.
    """

    model: Literal["full-31dof"]
    car_body: CarBody
    bogie: Bogie
    wheelset: Wheelset
    secondary: Suspension
    primary: Suspension
    geometry: Geometry
    front_override: BogieOverride | None = Field(None, alias="front_bogie")
    rear_override: BogieOverride | None = Field(None, alias="rear_bogie")

    @cached_property
    def front_bogie(self) -> BogieEnd:
        """The front bogie with its suspensions."""
        return _overridden(self._both_ends(), self.front_override)

    @cached_property
    def rear_bogie(self) -> BogieEnd:
        """The rear bogie with its suspensions."""
        return _overridden(self._both_ends(), self.rear_override)

    def _both_ends(self) -> BogieEnd:
        bogie = self.bogie
        return BogieEnd.model_construct(
            mass=bogie.mass,
            roll_inertia=bogie.roll_inertia,
            yaw_inertia=bogie.yaw_inertia,
            pitch_inertia=bogie.pitch_inertia,
            secondary=self.secondary,
            primary=self.primary,
        )
