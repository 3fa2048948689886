"""Group 10: the whole crossing of the 31-degree-of-freedom train against an independent integration."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tbi_cli.verify.cases.full_train import LOPSIDED, changed, text
from tbi_cli.verify.check import Curve, Line, Outcome, Tolerance, worst_channel
from tbi_cli.verify.references.crossing import crossing_channels
from tbi_cli.verify.solved import Solved, Verification

# Entries and exits fall on samples: multiples of 2.5 m at 50 m/s, of 0.25 m at the other speed.
KINDS: dict[str, dict[str, object]] = {
    "paper's static load": {"contact.static_load": "paper"},
    "physical, convective": {"contact.convective": True},
    "unequal ends": LOPSIDED,
}
CASES = {
    f"whole-{i}": text(
        changed({**changes, "solver": {"sampling": 2.5e-3, "substeps": 8, "duration": 2.0}}),
        f"Whole crossing, {kind}",
    )
    for i, (kind, changes) in enumerate(KINDS.items())
}
# 17.5, 2.5 and 50 m are no multiples of 77.7 m/s times 1 ms: axles enter and leave inside steps.
BETWEEN = {"velocity": 77.7, "solver": {"sampling": 1e-3, "substeps": 1, "duration": 2.0}}
CASES["whole-between"] = text(changed(BETWEEN), "Events between steps")
PAPER_SPEED = text(
    changed({"contact.static_load": "paper", "velocity": 300 / 3.6, "solver.duration": 5.0}), "300 km/h"
)
CASES["whole-300"] = PAPER_SPEED
ORACLE = "31-DOF crossing, DOP853 to 1e-10"
HISTORY = Tolerance(
    2e-6,
    "Runge-Kutta's phase error at omega h = 0.025 for the wheelsets' 80 rad/s: omega T (omega h)^4/120 = "
    "7e-7 of that motion, doubled for the accelerations",
)
INSIDE_PEAK = Tolerance(
    4e-5,
    "a step in which an axle enters or leaves has the right impulse, up to pi v h/(2 L) = 2.4e-3 of a "
    "wheel's force, but displaced by up to h/3: (omega h)^2/3 = 2e-3 of it at 80 rad/s, for each of "
    "eight events",
)
INSIDE = Tolerance(8e-5, INSIDE_PEAK.reason + "; doubled, for both sides differ in roll")
DIGITS = Tolerance(2e-3, "half of the last of three digits, 1.6e-3, and peaks at 1 ms, 2e-4")
STATED = (
    ("right_midspan", 0.0464, "m"),
    ("car_body_y", 0.0311, "m"),
    ("car_body_y_acceleration", 0.828, "m/s2"),
)
SHOWN = (
    ("right_midspan", "mid-span deflection, right beam (mm)", 1e3),
    ("car_body_y_acceleration", "car body, vertical acceleration (m/s²)", 1.0),
    ("rear_bogie_roll", "rear bogie, roll (mrad)", 1e3),
    ("wheel_1_right_force", "force of the first right wheel (kN)", 1e-3),
)


def compare(solved: Mapping[str, Solved]) -> Outcome:
    """Every channel, everywhere; the worst one is shown."""
    outcome = Outcome()
    for i, kind in enumerate(KINDS):
        h = solved[f"whole-{i}"].history()
        t = h.pop("time")
        reference = crossing_channels(solved[f"whole-{i}"].case, t)
        pairs = {c: (h[c], reference[c]) for c in h}
        worst = worst_channel(pairs)
        quantity = f"all {len(h)} channels (worst: {worst})"
        outcome.history(f"50 m/s, {kind}", quantity, "SI", *pairs[worst], ORACLE, HISTORY)
        if i == 0:
            outcome.curves += [
                Curve(
                    f"31-DOF train at 50 m/s: {channel}",
                    "time (s)",
                    label,
                    (
                        Line("DOP853", t, reference[channel] * factor, reference=True),
                        Line("tbi", t, h[channel] * factor),
                    ),
                )
                for channel, label, factor in SHOWN
            ]
    _between_steps(outcome, solved["whole-between"])
    for channel, value, units in STATED:
        ours_peak = float(solved["whole-300"].table("peak", channel).max())
        case, source = "300 km/h, paper's static load", "an independent implementation"
        outcome.number(case, f"peak of {channel}", units, ours_peak, value, source, DIGITS)
    return outcome


def _between_steps(outcome: Outcome, solved: Solved) -> None:
    """Histories and peaks where events fall inside steps, which costs the method its fourth order."""
    h = solved.history()
    reference = crossing_channels(solved.case, h.pop("time"))
    case = "77.7 m/s, events inside steps"
    pairs = {c: (h[c], reference[c]) for c in h}
    worst = worst_channel(pairs)
    quantity = f"all {len(pairs)} channels (worst: {worst})"
    outcome.history(case, quantity, "SI", *pairs[worst], ORACLE, INSIDE)
    pairs = {
        c: (solved.table("peak", c).ravel(), np.abs(reference[c]).max(keepdims=True))
        for c in solved.table_channels
    }
    worst = worst_channel(pairs)
    quantity = f"peaks of {len(pairs)} channels (worst: {worst})"
    outcome.history(case, quantity, "SI", *pairs[worst], ORACLE, INSIDE_PEAK)


VERIFICATION = Verification(
    10,
    "Whole crossings",
    "All channels of the full train over two beams against the same equations assembled independently from "
    "Eqs. (1a-c) and integrated with DOP853 to 1e-10, restarted at every axle event.",
    CASES,
    compare,
)
