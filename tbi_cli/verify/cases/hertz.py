"""Group 12: wheelsets with mass on contact springs that may let go."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from tbi_cli.verify.cases.full_train import CASE, LOPSIDED, changed, text
from tbi_cli.verify.check import Curve, Line, Outcome, Tolerance, worst_channel
from tbi_cli.verify.references.parameters import Array
from tbi_cli.verify.references.rail_shapes import rails_of
from tbi_cli.verify.references.rails import hertz_channels
from tbi_cli.verify.references.rigid_track import Flight
from tbi_cli.verify.references.statics import static_wheel_loads
from tbi_cli.verify.solved import Solved, Verification

HERTZ = {"model": "hertz"}
WHEELS = [f"wheel_{axle}_{side}" for axle in range(1, 5) for side in ("right", "left")]
SMOOTH = changed(
    {
        **LOPSIDED,
        "contact": {**HERTZ, "damping": 50e3},
        "solver": {"sampling": 2e-3, "substeps": 40, "duration": 0.7},
    }
)
BUMPS = {
    "dip": {"at": 2.0, "length": 2.0, "depth": 6e-3, "rails": "right"},
    "half_sine": {"at": 3.3171, "length": 1.7, "height": 0.4e-3, "rails": "left"},
}
LIFTING = changed(
    {
        **LOPSIDED,
        "contact": {**HERTZ, "damping": 50e3},
        "track": {"approach": 10.0, "irregularity": BUMPS},
        "solver": {"sampling": 5e-4, "substeps": 25, "duration": 0.3},
    }
)
# Equal beams, and wheelsets that are next to nothing on springs that are next to rigid; the car body, which
# weighs what is missing of the wheelsets, holds the static load.
LIGHT = {
    "bridge.left": CASE["bridge"]["right"],
    "train.wheelset.mass": 20.0,
    "train.wheelset.roll_inertia": 7.0,
    "train.car_body.mass": 40e3 + 4 * (1901.8 - 20.0),
    "solver": {"sampling": 2e-3, "substeps": "auto", "duration": 1.5},
}
STIFF = changed({**LIGHT, "contact": {**HERTZ, "stiffness": 2e10}})
PAPER = changed({**LIGHT, "contact": {"model": "paper", "static_load": "physical", "convective": True}})
# Wheels that leave a ramp: with a primary suspension that is next to nothing, the load on them is constant.
RISE_RATE, SLOPE = 0.2, 4e-3
RAMP_BEGIN, RAMP_END = -30.0, -10.0
TOP = SLOPE * (RAMP_END - RAMP_BEGIN)
RAMP = {"at": RAMP_BEGIN, "length": RAMP_END - RAMP_BEGIN, "height": TOP}
SPRING, DASHPOT = 1.4e9, 115e3
FLYING = changed(
    {
        "train.primary.vertical": {"stiffness": 1.0, "damping": 0.0},
        "contact": {**HERTZ, "damping": DASHPOT},
        "track": {"approach": 40.0, "irregularity": {"ramp": RAMP}},
        "solver": {"sampling": 2e-5, "substeps": 10, "duration": 0.1},
        "output": {
            "histories": {"channels": ["wheelset_1_y", "wheel_1_right_force", "wheel_1_right_time_aloft"]}
        },
    }
)
CASES = {
    "hertz-train": text(SMOOTH, "The 31-DOF train with Hertz contact"),
    "hertz-lift-off": text(LIFTING, "Wheels that lift off behind a dip"),
    "hertz-limit": text(STIFF, "Next to rigid contact, next to no wheelsets"),
    "hertz-limit-paper": text(PAPER, "The same with the paper's contact"),
    "hertz-flight": text(FLYING, "A wheelset that leaves a ramp"),
}
DOP853 = "31 equations, DOP853 to 1e-10"
HISTORY = Tolerance(
    1e-4,
    "Runge-Kutta's phase error at omega h = 0.076 for wheelsets that roll on their contact springs, 1516 "
    "rad/s: omega h^4 omega^4/120 = 4e-4 in a second, in which that motion dies away by half",
)
EVENTS = Tolerance(
    1e-3,
    "a wheel lifts off or comes down inside a step, where its force has a kink: its rate is wrong by up to "
    "(omega h)^2/12 = 8e-5 of that of the impact, ten times in a row",
)
LIMIT = Tolerance(1e-3, "what is left of m_w and 1/k_H: 20 kg of 1.9 t, and 64 kN/k_H = 3e-6 m of 16 mm")
BALANCE = Tolerance(1e-12, "rounding: forces and accelerations are of one and the same instant")
PARABOLA = Tolerance(
    2e-4,
    "the damper's force jumps at the end of the ramp, inside or at the end of a step: c h/(6 m) = 4e-5 "
    "of the rate, twice that of the height; and the kink at lift-off",
)
DURATION = Tolerance(2e-3, "two steps of 2 us, and 4e-5 of the rate")
Mask = NDArray[np.bool_]


def compare(solved: Mapping[str, Solved]) -> Outcome:
    """Histories against an independent solution, the limit, the balance of forces, and a closed form."""
    outcome = Outcome()
    _train(outcome, solved["hertz-train"])
    _lift_off(outcome, solved["hertz-lift-off"])
    _limit(outcome, solved["hertz-limit"], solved["hertz-limit-paper"])
    _flight(outcome, solved["hertz-flight"])
    return outcome


def _train(outcome: Outcome, solved: Solved) -> None:
    h = solved.history()
    t = h.pop("time")
    reference = hertz_channels(solved.case, t)
    off = _off_events(solved, t)
    pairs = {name: (h[name][off], reference[name][off]) for name in h if not _elsewhere(name)}
    worst = worst_channel(pairs)
    quantity = f"all {len(pairs)} channels (worst: {worst})"
    outcome.history("unequal ends, level rails", quantity, "SI", *pairs[worst], DOP853, HISTORY)


def _lift_off(outcome: Outcome, solved: Solved) -> None:
    h = solved.history()
    t = h.pop("time")
    rails = rails_of(BUMPS, 10.0, solved.crossing.right.length)
    reference = hertz_channels(solved.case, t, rails)
    off = _off_events(solved, t)
    case = "wheels lifting off behind a dip"
    for kinds, units in ((("_y", "_pitch", "_roll", "_midspan"), "SI"), (("_force",), "N")):
        pairs = {n: (h[n][off], reference[n][off]) for n in h if n.endswith(kinds)}
        worst = worst_channel(pairs)
        quantity = f"{len(pairs)} channels (worst: {worst})"
        outcome.history(case, quantity, units, *pairs[worst], DOP853, EVENTS)
    train, g = solved.crossing.train, solved.crossing.gravity
    masses = {"car_body": train.car_mass, "front_bogie": train.bogies[0].mass}
    masses |= {"rear_bogie": train.bogies[1].mass} | {
        f"wheelset_{i}": train.wheelset_mass for i in range(1, 5)
    }
    carried = sum(m * (g + h[f"{body}_y_acceleration"]) for body, m in masses.items())
    weight = sum(masses.values()) * g
    residual = sum(h[f"{wheel}_force"] for wheel in WHEELS) - carried
    quantity = "forces of all wheels less sum of m (g + y'') / weight"
    outcome.zero(case, quantity, "N", residual, weight, "Newton", BALANCE)
    lowest = min(float(solved.table("min", f"{wheel}_force").item()) for wheel in WHEELS)
    outcome.zero(case, "smallest force of a wheel / weight", "N", lowest, weight, "never below zero", BALANCE)
    force = "wheel_1_right_force"
    lines = (Line("DOP853", t, reference[force] / 1e3, reference=True), Line("tbi", t, h[force] / 1e3))
    outcome.curves.append(Curve(f"Behind a dip: {force}", "time (s)", "force (kN)", lines))


def _limit(outcome: Outcome, hertz: Solved, paper: Solved) -> None:
    ours, limit = hertz.history(), paper.history()
    pairs = {
        name: (ours[name], limit[name])
        for name in limit
        if name.endswith(("_y", "_pitch", "_midspan")) and np.abs(limit[name]).max() > 0
    }
    worst = worst_channel(pairs)
    quantity = f"{len(pairs)} histories of y and pitch (worst: {worst})"
    source = "the paper's contact, convective"
    outcome.history("k_H 2e10, m_w 20, I_wx 7", quantity, "SI", *pairs[worst], source, LIMIT)


def _flight(outcome: Outcome, solved: Solved) -> None:
    h, velocity = solved.history(), float(solved.case["velocity"])
    crossing = solved.crossing
    load = float(static_wheel_loads(crossing)[0])
    flight = Flight(crossing.train.wheelset_mass / 2, load, SPRING, DASHPOT, RISE_RATE)
    since = h["time"] - RAMP_END / velocity
    height = h["wheelset_1_y"] - TOP
    pressed, flying = (
        (since >= 0) & (since < flight.lift_off),
        (since >= flight.lift_off) & (since < flight.landing),
    )
    closed = np.where(pressed, flight.pressed(since)[0], flight.flying(since))
    kept = pressed | flying
    case = "a wheelset leaving a ramp"
    outcome.history(case, "height until it lands", "m", height[kept], closed[kept], "closed form", PARABOLA)
    aloft = h["wheel_1_right_time_aloft"]
    end = int(np.searchsorted(since, flight.landing)) + 2
    duration = float(aloft[end] - aloft[int(np.searchsorted(since, 0.0))])
    closed_duration = flight.landing - flight.lift_off
    outcome.number(case, "time in the air", "s", duration, closed_duration, "closed form", DURATION)
    shown = (since > -5e-4) & (since < flight.landing)
    lines = (
        Line("closed form", since[kept] * 1e3, closed[kept] * 1e3, reference=True),
        Line("tbi", since[shown] * 1e3, height[shown] * 1e3),
    )
    outcome.curves.append(Curve("A wheelset that leaves a ramp", "time (ms)", "height (mm)", lines))


def _elsewhere(name: str) -> bool:
    """Channels that this reference does not form: the time aloft has a closed form, modes are in group 10."""
    return name.endswith("_time_aloft") or "_mode_" in name


def _off_events(solved: Solved, t: Array) -> Mask:
    """Samples at which no axle enters or leaves: there the forces of the contact's dampers jump."""
    crossing = solved.crossing
    entries = crossing.train.axle_distances / crossing.velocity
    events = np.concatenate([entries, entries + crossing.right.length / crossing.velocity])
    off: Mask = np.abs(t[:, None] - events).min(axis=1) > 1e-9
    return off


VERIFICATION = Verification(
    12,
    "Hertz contact",
    "Wheelsets with mass on contact springs: against 31 equations assembled independently and integrated "
    "with lift-off and return as events; the paper's contact as the limit; Newton's law; a closed form of "
    "a flight.",
    CASES,
    compare,
)
