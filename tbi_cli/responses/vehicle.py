"""The channels of one vehicle: motions of its bodies, and contact forces."""

from __future__ import annotations

from tbi_cli.case import FullTrain, Train
from tbi_cli.responses.channel import DERIVATIVES, Channel, Signal, derivatives
from tbi_cli.system.assembly import System
from tbi_cli.system.trains import BOGIES, SIDES, WHEELSETS, bogie_loads

MOTIONS = {
    "y": "vertical displacement",
    "z": "lateral displacement",
    "pitch": "pitch",
    "roll": "roll",
    "yaw": "yaw",
}


def motion_channels(train: Train, system: System) -> list[Channel]:
    """Displacements and rotations of every body of a vehicle, with their derivatives."""
    found = _body_channels(system)
    if isinstance(train, FullTrain):
        if not system.unilateral:
            found += _wheelset_channels(system)
        found = _by_body(found)
    return found


def _body_channels(system: System) -> list[Channel]:
    made: list[Channel] = []
    for i, (body, motion) in enumerate(system.coordinates):
        made += derivatives(
            f"{body}_{motion}",
            "m" if motion in ("y", "z") else "rad",
            f"{MOTIONS[motion]} of {_spoken(body)}",
            {kind: (((kind, i), 1.0),) for kind in DERIVATIVES},
        )
    return made


def _wheelset_channels(system: System) -> list[Channel]:
    """A wheelset's vertical motion is the mean of the beams under its two wheels (model.md, Contact)."""
    made: list[Channel] = []
    for axle, name in enumerate(WHEELSETS):
        pair = [wheel for wheel, k in enumerate(system.wheel_axle) if k == axle]
        made += derivatives(
            f"{name}_y",
            "m",
            f"vertical displacement of {_spoken(name)}",
            {
                kind: tuple(((signal, wheel), 0.5) for wheel in pair)
                for kind, signal in zip(DERIVATIVES, ("w", "dw", "ddw"), strict=True)
            },
        )
    return made


def _by_body(found: list[Channel]) -> list[Channel]:
    """Groups the wheelsets' vertical channels with the rest of their wheelset, in front."""
    bodies = ("car_body", *BOGIES, *WHEELSETS)

    def place(channel: Channel) -> tuple[int, bool]:
        body = next(body for body in bodies if channel.name.startswith(body))
        return bodies.index(body), not channel.name.startswith(f"{body}_y_") and channel.name != f"{body}_y"

    return sorted(found, key=place)


def force_channels(train: Train, system: System, g: float) -> list[Channel]:
    """Contact forces of a full train, compression positive (model.md, The paper's Appendix 2)."""
    if not isinstance(train, FullTrain):
        return []
    body_y = system.coordinates.index(("car_body", "y"))
    mass = train.car_body.mass
    made = [
        Channel("car_body_force", "N", "force on the car body", ((("a", body_y), mass),), offset=mass * g)
    ]
    loads = bogie_loads(train, g)
    for bogie, axles, load in zip(BOGIES, ((0, 1), (2, 3)), loads, strict=True):
        under = [wheel for wheel, axle in enumerate(system.wheel_axle) if axle in axles]
        terms = tuple((signal, -value) for wheel in under for signal, value in _primary_force(system, wheel))
        made.append(Channel(f"{bogie}_force", "N", f"force under {_spoken(bogie)}", terms, offset=load))
    half_inertia = 0.0 if system.unilateral else train.wheelset.mass / 4
    for wheel, (axle, beam) in enumerate(zip(system.wheel_axle, system.wheel_beam, strict=True)):
        pair = [other for other, k in enumerate(system.wheel_axle) if k == axle]
        side, static = SIDES[beam], float(system.wheel_load[wheel])
        name, spoken = f"wheel_{axle + 1}_{side}", f"the {side} wheel of axle {axle + 1}"
        inertia = tuple((("ddw", other), half_inertia) for other in pair if half_inertia)
        made.append(
            Channel(
                f"{name}_force",
                "N",
                f"force of {spoken} on its rail",
                ((("P", wheel), -1.0), *inertia),
                static,
            )
        )
        if system.unilateral:
            # Where nothing stands on a wheel, without gravity, nothing is taken off it: 0 throughout.
            relief = ((("P", wheel), 1 / static if static else 0.0),)
            made.append(Channel(f"{name}_unloading", "1", f"unloading ratio 1 - Q/Q0 of {spoken}", relief))
            aloft = ((("aloft", wheel), 1.0),)
            made.append(Channel(f"{name}_time_aloft", "s", f"time aloft of {spoken}", aloft))
    return made


def _primary_force(system: System, wheel: int) -> list[tuple[Signal, float]]:
    """The force of the primary suspension above a wheel, tension positive, as weighted signals."""
    primary = system.vehicle.wheels[wheel].primary
    if primary is None:
        return [(("P", wheel), 1.0)]
    place = {coordinate: i for i, coordinate in enumerate(system.coordinates)}
    row = {place[coordinate]: value for coordinate, value in primary.row.items() if value}
    return [(("x", i), primary.stiffness * g) for i, g in row.items()] + [
        (("v", i), primary.damping * g) for i, g in row.items()
    ]


def _spoken(body: str) -> str:
    """The name of a body in a sentence."""
    words = body.replace("_", " ")
    return words if words[-1].isdigit() else f"the {words}"
