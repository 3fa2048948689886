"""Group 13: trains of several vehicles, each with channels of its own, on the beams that join them."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tbi_cli.verify.cases.full_train import CASE, LOPSIDED, changed, text
from tbi_cli.verify.check import Curve, Line, Outcome, Tolerance, worst_channel
from tbi_cli.verify.references.consist import coach_fronts, consist_channels
from tbi_cli.verify.references.mixed_row import mixed_row_crossing
from tbi_cli.verify.references.parameters import Array, beam_from_mapping
from tbi_cli.verify.references.simple_vehicles import RigidBeam, SprungMass
from tbi_cli.verify.solved import Solved, Verification

CAR, OTHER = CASE["train"], changed(LOPSIDED)["train"]
# Every entry and exit falls on a sample: axles stand at multiples of 0.125 m at 50 m/s.
SOLVER = {"method": "rk4", "sampling": 2.5e-3, "substeps": 8, "duration": 1.1}
TWO = {
    "consist": [
        {"vehicle": CAR, "front_overhang": 3.5, "rear_overhang": 1.5},
        {"vehicle": OTHER, "spacing": 26.0, "rear_overhang": 2.5},
    ]
}
ONE = {"consist": [{"vehicle": CAR, "spacing": 25.0}]}
EACH = {"histories": "all", "coaches": "each"}

LENGTH, VELOCITY = 30.0, 40.0
BEAM = {"youngs_modulus": 30e9, "second_moment": 2.0, "mass_per_length": 12e3, "damping": {"ratio": 0.02}}
SPRUNG = SprungMass(8e3, 2e6, 2e4)
RIGID = RigidBeam(30e3, 0.8e6, 12.0, 4e6, 1e5)
FORCE = 150e3
GROUPS: tuple[tuple[SprungMass | RigidBeam | float, int, dict[str, float]], ...] = (
    (SPRUNG, 2, {"spacing": 4.0}),
    (RIGID, 1, {"front_overhang": 4.5, "rear_overhang": 1.5}),
    (FORCE, 2, {"front_overhang": 1.0, "spacing": 6.0}),
    (SPRUNG, 1, {"spacing": 4.0}),
)


def _mapping(vehicle: SprungMass | RigidBeam | float) -> dict[str, object]:
    """A simple vehicle as a case file has it."""
    if isinstance(vehicle, float):
        return {"model": "moving-load", "forces": [vehicle], "positions": [0.0]}
    common = {"mass": vehicle.mass, "stiffness": vehicle.stiffness, "damping": vehicle.damping}
    if isinstance(vehicle, SprungMass):
        return {"model": "sprung-mass", **common}
    distance, pitch = vehicle.distance, vehicle.pitch_inertia
    return {"model": "rigid-beam", "support_distance": distance, "pitch_inertia": pitch, **common}


MIXED = {
    "train": {
        "consist": [{"vehicle": _mapping(v), "count": count, **place} for v, count, place in GROUPS],
    },
    "bridge": {"length": LENGTH, "modes": 4, "right": BEAM},
    "velocity": VELOCITY,
    "solver": {"method": "rk4", "sampling": 2.5e-3, "substeps": 8, "duration": 1.5},
    "output": {"histories": "all"},
}
CASES = {
    "train-of-two": text(changed({"train": TWO, "solver": SOLVER, "output": EACH}), "Two cars of two kinds"),
    "train-of-one": text(changed({"train": ONE, "solver": SOLVER}), "A train of one car"),
    "train-alone": text(changed({"solver": SOLVER}), "The car alone"),
    "train-of-simple-vehicles": text(MIXED, "Sprung masses, a rigid beam and forces in one train"),
}
ORACLE = "the same equations, DOP853 to 1e-10"
HISTORY = Tolerance(
    2e-6,
    "as for one car: the phase error of the wheelsets' 80 rad/s, 7e-7 of that motion, doubled for the "
    "accelerations",
)
SIMPLE = Tolerance(
    5e-8,
    "Runge-Kutta's phase error: (omega h)^4/120 = 2e-6 a radian for the fourth mode's 390 rad/s over the 50 "
    "rad in which it dies away, of a free vibration that is alpha/i^5 = 1e-4 of the peak; times 5",
)
SAME = Tolerance(1e-14, "the same operations in the same order")
EXACT = Tolerance(0.0, "one number taken from several")


def compare(solved: Mapping[str, Solved]) -> Outcome:
    """Every coach against the reference; one coach against the car alone; extremes over all coaches."""
    outcome = Outcome()
    _two(outcome, solved["train-of-two"])
    _extremes(outcome, solved["train-of-two"])
    one, alone = solved["train-of-one"].history(), solved["train-alone"].history()
    pairs = {c: (one[c if c in one else f"coach_1_{c}"], alone[c]) for c in alone if c != "time"}
    worst = worst_channel(pairs)
    quantity = f"all {len(pairs)} channels (worst: {worst})"
    outcome.history("a train of one car", quantity, "SI", *pairs[worst], "the car alone", SAME)
    _simple(outcome, solved["train-of-simple-vehicles"].history())
    return outcome


def _two(outcome: Outcome, solved: Solved) -> None:
    h = solved.history()
    t = h.pop("time")
    reference = consist_channels(solved.case, t)
    pairs = {c: (h[c], reference[c]) for c in h}
    worst = worst_channel(pairs)
    case, quantity = "two cars of two kinds", f"all {len(pairs)} channels (worst: {worst})"
    outcome.history(case, quantity, "SI", *pairs[worst], ORACLE, HISTORY)
    outcome.curves += [
        Curve(
            f"Train of two cars at 50 m/s: {channel}",
            "time (s)",
            label,
            (Line("DOP853", t, reference[channel] * 1e3, reference=True), Line("tbi", t, h[channel] * 1e3)),
        )
        for channel, label in (
            ("right_midspan", "mid-span deflection, right beam (mm)"),
            ("coach_2_car_body_y", "second car body, vertical displacement (mm)"),
        )
    ]


def _extremes(outcome: Outcome, solved: Solved) -> None:
    """What a table calls `car_body_y` is the largest, of the minima the smallest, of the coaches' own."""
    own = {c for c in solved.table_channels if c.startswith("coach_")}
    names = sorted({c.split("_", 2)[2] for c in own})
    for group in ("peak", "max", "min", "rms"):
        ours, theirs = [], []
        for name in names:
            values = [float(solved.table(group, c).item()) for c in own if c.split("_", 2)[2] == name]
            ours.append(float(solved.table(group, name).item()))
            theirs.append(min(values) if group == "min" else max(values))
        quantity = f"{group} of {len(names)} channels over all coaches"
        pair = np.array(ours), np.array(theirs)
        outcome.history("two cars of two kinds", quantity, "SI", *pair, "the coaches' own", EXACT)


def _simple(outcome: Outcome, h: dict[str, Array]) -> None:
    vehicles = [vehicle for vehicle, count, _ in GROUPS for _ in range(count)]
    places = [place for _, count, place in GROUPS for _ in range(count)]
    wheelbases = [v.distance if isinstance(v, RigidBeam) else 0.0 for v in vehicles]
    fronts = coach_fronts(places, wheelbases)
    beam = beam_from_mapping(BEAM, LENGTH, 4)
    reference = mixed_row_crossing(beam, vehicles, fronts, VELOCITY, h["time"])
    for name in ("right_midspan", "coach_2_sprung_mass_y", "coach_3_beam_pitch", "coach_6_sprung_mass_y"):
        units = "rad" if name.endswith("pitch") else "m"
        case = "sprung masses, a rigid beam, forces"
        outcome.history(case, name, units, h[name], reference[name], ORACLE, SIMPLE)


VERIFICATION = Verification(
    13,
    "Trains of several vehicles",
    "Cars of two kinds in one train, and simple vehicles of three, against the same equations written out "
    "for all of them and integrated with DOP853. A train of one car is that car; train-wide extremes are "
    "those of the coaches.",
    CASES,
    compare,
)
