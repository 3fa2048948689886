"""The trains of the case file as bodies, spring-dampers and wheels (model.md, first section; Fig. 2)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from tbi_cli.case import Case, Contact, FullTrain, HslmA, MovingLoad, RigidBeam, SprungMass, Train
from tbi_cli.system.vehicle import (
    Body,
    Row,
    Side,
    SpringDamper,
    Vehicle,
    Wheel,
    between,
    lateral,
    longitudinal,
    vertical,
    with_loads,
    without,
)

SIDES: tuple[Side, Side] = ("right", "left")
BOGIES = ("front_bogie", "rear_bogie")
WHEELSETS = ("wheelset_1", "wheelset_2", "wheelset_3", "wheelset_4")


def build_vehicle(train: Train, case: Case) -> Vehicle:
    """One vehicle of a case with the static load of each of its wheels [Eq. (13a), model.md Contact]."""
    gravity = case.gravity
    if isinstance(train, FullTrain):
        vehicle = full_train(train, gravity, case.contact)
        return (
            with_loads(vehicle, paper_load(train, gravity))
            if case.contact.static_load == "paper"
            else vehicle
        )
    if isinstance(train, SprungMass):
        return sprung_mass(train, gravity)
    if isinstance(train, RigidBeam):
        return rigid_beam(train, gravity)
    assert isinstance(train, MovingLoad | HslmA)
    return constant_forces(train.forces, train.behind if isinstance(train, MovingLoad) else train.positions)


def full_train(train: FullTrain, gravity: float, contact: Contact) -> Vehicle:
    """The train of 31 degrees of freedom of Eqs. (1a-c), each axle loaded by static equilibrium.

    With the contact `paper` the wheelsets' own vertical motion follows the beams and is no coordinate: 27 are
    left, and the primary suspension stands on the beams.  With `hertz` it stands on the wheelsets, and each
    of their wheels on its rail through a contact spring.
    """
    touching = contact.spring
    geometry = train.geometry
    bogies = (train.front_bogie, train.rear_bogie)
    bogie_x = (geometry.l_b1, -geometry.l_b2)
    wheel_x = ((geometry.l_w1, -geometry.l_w2), (geometry.l_w3, -geometry.l_w4))

    bodies = [Body("car_body", _inertias(train.car_body))]
    bodies += [Body(name, _inertias(bogie)) for name, bogie in zip(BOGIES, bogies, strict=True)]
    wheelset = train.wheelset
    vertical_mass = {"y": wheelset.mass} if touching is not None else {}
    others = {"z": wheelset.mass, "roll": wheelset.roll_inertia, "yaw": wheelset.yaw_inertia}
    bodies += [Body(name, vertical_mass | others) for name in WHEELSETS]

    links: list[SpringDamper] = []
    wheels: list[Wheel] = []
    offsets: list[float] = []
    loads = axle_loads(train, gravity)
    for end, (name, bogie) in enumerate(zip(BOGIES, bogies, strict=True)):
        links += _secondary(train, end, name, bogie_x[end])
        for x in wheel_x[end]:
            axle = len(offsets)
            links += _primary_in_plane(train, end, name, WHEELSETS[axle], x)
            d = geometry.primary_half_spacing
            for side, sign in zip(SIDES, (1.0, -1.0), strict=True):
                spring = bogie.primary.vertical
                row = between(vertical(name, x, sign * d), _wheelset_point(WHEELSETS[axle], sign * d))
                primary = SpringDamper(row, spring.stiffness, spring.damping)
                if touching is not None:
                    links.append(primary)
                    circle = _wheelset_point(WHEELSETS[axle], sign * touching.running_circle)
                    touch = SpringDamper(circle, touching.stiffness, touching.damping)
                    wheels.append(Wheel(axle, side, loads[axle] / 2, touch, primary))
                else:
                    stood_on = without(row, (WHEELSETS[axle], "y"))
                    suspension = SpringDamper(stood_on, spring.stiffness, spring.damping)
                    wheels.append(Wheel(axle, side, loads[axle] / 2, suspension))
            offsets.append(geometry.l_b1 + geometry.l_w1 - (bogie_x[end] + x))
    return Vehicle(tuple(bodies), tuple(links), tuple(wheels), tuple(offsets))


def axle_loads(train: FullTrain, gravity: float) -> tuple[float, float, float, float]:
    """Static load (N) of each axle: the car body on two bogies, each bogie on two axles, by moments."""
    g = train.geometry
    front = train.car_body.mass * g.l_b2 / (g.l_b1 + g.l_b2) + train.front_bogie.mass
    rear = train.car_body.mass * g.l_b1 / (g.l_b1 + g.l_b2) + train.rear_bogie.mass
    wheelset = train.wheelset.mass
    return (
        gravity * (front * g.l_w2 / (g.l_w1 + g.l_w2) + wheelset),
        gravity * (front * g.l_w1 / (g.l_w1 + g.l_w2) + wheelset),
        gravity * (rear * g.l_w4 / (g.l_w3 + g.l_w4) + wheelset),
        gravity * (rear * g.l_w3 / (g.l_w3 + g.l_w4) + wheelset),
    )


def bogie_loads(train: FullTrain, gravity: float) -> tuple[float, float]:
    """Static force (N) under the front and the rear bogie: Eq. (13b), the car body shared out by moments.

    Half of the weight each, as printed, and half of what one carries more than the other: nothing where both
    ends are alike.
    """
    g = train.geometry
    bogies = train.front_bogie.mass, train.rear_bogie.mass
    total = train.car_body.mass + bogies[0] + bogies[1]
    more = train.car_body.mass * (g.l_b2 - g.l_b1) / (g.l_b1 + g.l_b2) + bogies[0] - bogies[1]
    return (total + more) * gravity / 2, (total - more) * gravity / 2


def paper_load(train: FullTrain, gravity: float) -> float:
    """Eq. (13a) to the letter (N): eight wheelset masses, and four wheels to carry it all."""
    bogies = train.front_bogie.mass + train.rear_bogie.mass
    return (train.car_body.mass + bogies + 8 * train.wheelset.mass) * gravity / 4


def sprung_mass(train: SprungMass, gravity: float) -> Vehicle:
    """Verification case 1: a mass on one spring, loaded by gravity through its contact."""
    suspension = SpringDamper({("sprung_mass", "y"): 1.0}, train.stiffness, train.damping)
    wheel = Wheel(0, "right", train.mass * gravity, suspension)
    return Vehicle((Body("sprung_mass", {"y": train.mass}),), (), (wheel,), (0.0,))


def rigid_beam(train: RigidBeam, gravity: float) -> Vehicle:
    """Verification case 2: a rigid beam on two springs, half of its weight on each."""
    half = train.support_distance / 2
    wheels = tuple(
        Wheel(
            axle,
            "right",
            train.mass * gravity / 2,
            SpringDamper({("beam", "y"): 1.0, ("beam", "pitch"): x}, train.stiffness, train.damping),
        )
        for axle, x in enumerate((half, -half))
    )
    body = Body("beam", {"y": train.mass, "pitch": train.pitch_inertia})
    return Vehicle((body,), (), wheels, (0.0, train.support_distance))


def constant_forces(forces: Sequence[float], positions: Sequence[float]) -> Vehicle:
    """Forces (N) of constant size at fixed distances (m) behind the first."""
    nothing = SpringDamper({}, 0.0, 0.0)
    wheels = tuple(Wheel(axle, "right", force, nothing) for axle, force in enumerate(forces))
    return Vehicle((), (), wheels, tuple(positions))


def _wheelset_point(wheelset: str, z: float) -> Row:
    """Vertical displacement of a point on the axle of a wheelset, which pitches (rolls on) freely."""
    return without(vertical(wheelset, z=z), (wheelset, "pitch"))


def _inertias(body: object) -> dict[str, float]:
    """The five inertias of a body in the order of Eq. (9)."""
    values = {
        "y": "mass",
        "z": "mass",
        "pitch": "pitch_inertia",
        "roll": "roll_inertia",
        "yaw": "yaw_inertia",
    }
    return {motion: getattr(body, key) for motion, key in values.items()}


def _secondary(train: FullTrain, end: int, bogie: str, x: float) -> Iterator[SpringDamper]:
    """The secondary suspension of one bogie: vertical, lateral and longitudinal, one of each on a side."""
    geometry = train.geometry
    springs = (train.front_bogie, train.rear_bogie)[end].secondary
    a = geometry.secondary_half_spacing
    for z in (a, -a):
        rows = (
            (between(vertical("car_body", x, z), vertical(bogie, z=z)), springs.vertical),
            (
                between(
                    lateral("car_body", x, -geometry.car_body_to_secondary),
                    lateral(bogie, y=geometry.secondary_to_bogie),
                ),
                springs.lateral,
            ),
            (between(longitudinal("car_body", z), longitudinal(bogie, z)), springs.longitudinal),
        )
        for row, spring in rows:
            yield SpringDamper(row, spring.stiffness, spring.damping)


def _primary_in_plane(
    train: FullTrain, end: int, bogie: str, wheelset: str, x: float
) -> Iterator[SpringDamper]:
    """The lateral and longitudinal primary suspension of one axle, one of each at a wheel [Eq. (12c)]."""
    geometry = train.geometry
    springs = (train.front_bogie, train.rear_bogie)[end].primary
    d = geometry.primary_half_spacing
    for z in (d, -d):
        sideways = between(lateral(bogie, x, -geometry.bogie_to_axle), lateral(wheelset))
        yield SpringDamper(sideways, springs.lateral.stiffness, springs.lateral.damping)
        lengthways = between(longitudinal(bogie, z), longitudinal(wheelset, z))
        yield SpringDamper(lengthways, springs.longitudinal.stiffness, springs.longitudinal.damping)
