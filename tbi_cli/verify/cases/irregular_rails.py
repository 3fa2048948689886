"""Group 11: vehicles on rails that are not level."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from tbi_cli.verify.cases.full_train import changed, text
from tbi_cli.verify.check import Curve, Line, Outcome, Tolerance, worst_channel
from tbi_cli.verify.references.parameters import Array, beam_from_mapping
from tbi_cli.verify.references.rail_shapes import rails_of
from tbi_cli.verify.references.rails import sprung_mass_on_rails
from tbi_cli.verify.references.rigid_track import over_a_ramp, steady_sine
from tbi_cli.verify.references.rough_crossing import rough_channels
from tbi_cli.verify.references.simple_vehicles import SprungMass
from tbi_cli.verify.solved import Solved, Verification

VELOCITY, SPAN, APPROACH, MODES = 25.0, 25.0, 100.0, 2
BEAM = {"youngs_modulus": 2.87e9, "second_moment": 2.9, "mass_per_length": 2303.0, "damping": 0.0}
UNDAMPED, DAMPED = SprungMass(5750.0, 1595e3), SprungMass(5750.0, 1595e3, 60e3)
RAMP = {"at": -60.0, "length": 10.0, "height": 5e-3}
DIP = {"at": -2.0, "length": 8.0, "depth": 4e-3}
SINE = {"wavelength": 12.5, "amplitude": 2e-3}
# Uneven points, the first and the last off level; the corners of the ramp fall on steps, the others inside.
MEASURED = {
    "x": [-31.7, -24.1, -21.9, -13.3, -4.6, 2.8, 6.1, 15.4, 19.9, 31.3],
    "right": [1.1e-3, -0.7e-3, 0.2e-3, 1.4e-3, -0.9e-3, 0.3e-3, 0.8e-3, -1.2e-3, 0.1e-3, 0.9e-3],
}
BUMPS = {
    "ramp": {"at": -20.0, "length": 5.0, "height": 3e-3},
    "half_sine": {"at": 3.3171, "length": 4.1, "height": 2e-3},
    "profile": MEASURED,
}


def _case(vehicle: SprungMass, irregularity: Mapping[str, Any], title: str) -> str:
    train = {"model": "sprung-mass", "mass": vehicle.mass, "stiffness": vehicle.stiffness}
    return text(
        {
            "train": {**train, "damping": vehicle.damping},
            "bridge": {"length": SPAN, "modes": MODES, "right": BEAM},
            "velocity": VELOCITY,
            "track": {"approach": APPROACH, "irregularity": irregularity},
            # Corners, entry and exit fall on samples.
            "solver": {"sampling": 5e-3, "substeps": 20, "duration": 1.5},
            "output": {"histories": {"channels": ["sprung_mass_y", "right_midspan"]}},
        },
        title,
    )


# Every kind of part at once, others on the right and on the left.
UNEQUAL = {
    "ramp": {"at": -17.3, "length": 6.1, "height": 1.3e-3, "rails": "right"},
    "dip": {"at": -3.37, "length": 7.7, "depth": 2.1e-3, "rails": "left"},
    "half_sine": {"at": 11.13, "length": 3.9, "height": 0.9e-3, "rails": "opposite"},
    "harmonic": {"wavelength": 8.0, "amplitude": 1e-3, "rails": "opposite"},
    "profile": MEASURED
    | {"left": [-0.4e-3, 0.9e-3, 0.6e-3, -0.8e-3, 0.5e-3, 1.2e-3, -0.6e-3, 0.2e-3, -1.1e-3, -0.7e-3]},
}
TRAIN = changed(
    {
        "track": {"approach": 35.0, "irregularity": UNEQUAL},
        "contact.static_load": "paper",
        "solver": {"sampling": 5e-3, "substeps": 32, "duration": 0.8},
    }
)
CASES = {
    "ramp": _case(UNDAMPED, {"ramp": RAMP}, "A sprung mass over a ramp"),
    "dip": _case(DAMPED, {"dip": DIP}, "A sprung mass over a dip at the end of a bridge"),
    "sine": _case(DAMPED, {"harmonic": SINE}, "A sprung mass over sine waves"),
    "bumps": _case(DAMPED, BUMPS, "A sprung mass over a ramp, a bump and measured rails at once"),
    "rolling-train": text(TRAIN, "The 31-DOF train over rails that have nothing in common"),
}
DOP853 = "the same equations, DOP853 to 1e-10"
STEP = Tolerance(
    2e-7,
    "Runge-Kutta's phase error at omega h = 0.03 (the second mode, 120 rad/s): omega T (omega h)^4/120 = "
    "1e-6 of that mode, which has a tenth of the peak",
)
CUBIC = Tolerance(
    2e-6,
    "the rail is a chain of 64 cubics in a wave: its level is good to (2 pi/64)^4/384 = 2.4e-7, its slope to "
    "1e-5, of which the damper passes on a tenth",
)
CORNER = Tolerance(
    2e-6,
    "a corner inside a step of 0.25 ms gives its impulse right, c J h/m = 1e-4 m/s of a jump J of the rate, "
    "but up to a third of the step too late or too soon: 8e-9 m of 3 mm",
)
STEADY = Tolerance(2e-6, "the same, and what is left of the beginning after 3 s, exp(-5.2 x 3) = 2e-7")
TRAIN_STEP = Tolerance(
    1e-4,
    "the rail as cubics: slopes are good to 1e-5; and each of 16 corners that fall inside steps: (c d^2 h/I) "
    "(omega h/3) = 7e-6 of what it makes a bogie roll, at 50 rad/s; a wheelset's acceleration, by 1e-3, is "
    "left out here",
)


def compare(solved: Mapping[str, Solved]) -> Outcome:
    """Histories against closed forms on the approach, and against independent solutions all along."""
    outcome = Outcome()
    beam = beam_from_mapping(BEAM, SPAN, MODES)
    corners = (RAMP["at"], RAMP["at"] + RAMP["length"])
    h = solved["ramp"].history()
    t, y = h["time"], h["sprung_mass_y"]
    before = t <= 0
    slope = RAMP["height"] / RAMP["length"]
    closed = over_a_ramp(UNDAMPED, VELOCITY * slope, corners[0] / VELOCITY, corners[1] / VELOCITY, t)
    quantity = "sprung_mass_y before the bridge"
    outcome.history("over a ramp", quantity, "m", y[before], closed[before], "closed form", STEP)
    (ramp, _), (dip, _), (sine, _), (bumps, _) = (
        rails_of(irregularity, APPROACH, SPAN)
        for irregularity in ({"ramp": RAMP}, {"dip": DIP}, {"harmonic": SINE}, BUMPS)
    )
    reference = sprung_mass_on_rails(beam, UNDAMPED, VELOCITY, t, ramp)
    _both(outcome, "over a ramp and the bridge", h, reference, STEP)

    h = solved["dip"].history()
    reference = sprung_mass_on_rails(beam, DAMPED, VELOCITY, h["time"], dip)
    _both(outcome, "over a dip on the bridge", h, reference, CUBIC)
    outcome.curves.append(_curve("Over a dip at the end of the bridge", h, reference))

    h = solved["sine"].history()
    t, y = h["time"], h["sprung_mass_y"]
    steady = (t <= 0) & (t >= -0.5)
    closed = steady_sine(DAMPED, SINE["amplitude"], 2 * math.pi * VELOCITY / SINE["wavelength"], t)
    quantity = "sprung_mass_y, steady, before the bridge"
    outcome.history("over sine waves", quantity, "m", y[steady], closed[steady], "transfer function", STEADY)
    reference = sprung_mass_on_rails(beam, DAMPED, VELOCITY, t, sine)
    _both(outcome, "over sine waves and the bridge", h, reference, CUBIC)
    outcome.curves.append(_curve("Over sine waves", h, reference))

    h = solved["bumps"].history()
    reference = sprung_mass_on_rails(beam, DAMPED, VELOCITY, h["time"], bumps)
    _both(outcome, "over a ramp, a bump and measured rails", h, reference, CORNER)
    outcome.curves.append(_curve("Over a ramp, a bump and measured rails", h, reference))
    _train(outcome, solved["rolling-train"])
    return outcome


def _both(
    outcome: Outcome, case: str, h: Mapping[str, Array], reference: Mapping[str, Array], tolerance: Tolerance
) -> None:
    for name in ("sprung_mass_y", "right_midspan"):
        outcome.history(case, name, "m", h[name], reference[name], DOP853, tolerance)


def _curve(title: str, h: Mapping[str, Array], reference: Mapping[str, Array]) -> Curve:
    x = h["time"] * VELOCITY
    return Curve(
        title,
        "place of the wheel (m)",
        "displacement of the mass (mm)",
        (
            Line("DOP853", x, reference["sprung_mass_y"] * 1e3, reference=True),
            Line("tbi", x, h["sprung_mass_y"] * 1e3),
        ),
    )


def _train(outcome: Outcome, solved: Solved) -> None:
    """Every channel of the full train but those that hold r'', away from samples at which an axle enters."""
    h = solved.history()
    t = h.pop("time")
    crossing = solved.crossing
    track = solved.case["track"]
    rails = rails_of(track["irregularity"], track["approach"], crossing.right.length)
    reference = rough_channels(solved.case, t, rails)
    entries = crossing.train.axle_distances / crossing.velocity
    events = np.concatenate([entries, entries + crossing.right.length / crossing.velocity])
    off = np.abs(t[:, None] - events).min(axis=1) > 1e-9
    pairs = {
        name: (h[name][off], reference[name][off])
        for name in h
        if not (name.startswith("wheelset") and name.endswith("y_acceleration")) and "wheel_" not in name
    }
    worst = worst_channel(pairs)
    quantity = f"all {len(pairs)} channels (worst: {worst})"
    outcome.history("31-DOF train, unequal rails", quantity, "SI", *pairs[worst], DOP853, TRAIN_STEP)
    forces = {name: (h[name][off], reference[name][off]) for name in h if "wheel_" in name}
    worst = worst_channel(forces)
    quantity = f"{len(forces)} wheel forces (worst: {worst})"
    outcome.history("31-DOF train, unequal rails", quantity, "N", *forces[worst], DOP853, TRAIN_STEP)


VERIFICATION = Verification(
    11,
    "Irregular rails",
    "A sprung mass over a ramp, a dip, sine waves and many at once, against closed forms before the bridge "
    "and DOP853 on it; the full train on rails that have nothing in common.",
    CASES,
    compare,
)
