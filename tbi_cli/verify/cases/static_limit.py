"""Group 4: at crawling speed the bridge follows the influence line."""

from __future__ import annotations

import math
from collections.abc import Mapping

from tbi_cli.verify.cases.full_train import CASE, changed, text
from tbi_cli.verify.check import Curve, Line, Outcome, Tolerance
from tbi_cli.verify.references.influence import static_deflection
from tbi_cli.verify.references.moving_force import critical_speed
from tbi_cli.verify.references.parameters import Array, Beam, beam_from_mapping, crossing_from_case
from tbi_cli.verify.references.statics import static_wheel_loads
from tbi_cli.verify.solved import Solved, Verification

ALPHA = 5e-4
LENGTH, FORCE = 20.0, 100e3
MODES = (4, 20)
GIVEN = {"youngs_modulus": 30e9, "second_moment": 0.3, "mass_per_length": 10e3, "damping": {"ratio": 0.02}}
TRAIN_BRIDGE = beam_from_mapping(CASE["bridge"]["right"], CASE["bridge"]["length"], 4)
# The slower beam decides.
TRAIN_VELOCITY = ALPHA * critical_speed(TRAIN_BRIDGE)
SAMPLES = 1000


def _force_beam(n: int) -> Beam:
    return beam_from_mapping(GIVEN, LENGTH, n)


def _step(beam: Beam, vehicle_limit: float = 0.0) -> float:
    """A step [s] inside the stability region, |lambda| h = 2.4, of the fastest mode or of the vehicle."""
    return 2.4 / max(float(beam.omega[-1]), vehicle_limit)


def _force_case(n: int) -> str:
    beam = _force_beam(n)
    velocity = ALPHA * critical_speed(beam)
    sampling = LENGTH / velocity / SAMPLES
    return text(
        {
            "train": {"model": "moving-load", "forces": [FORCE], "positions": [0.0]},
            "bridge": {"length": LENGTH, "modes": n, "right": GIVEN},
            "velocity": velocity,
            "solver": {"sampling": sampling, "substeps": math.ceil(sampling / _step(beam)), "duration": 1.0},
            "output": {"histories": {"channels": ["right_midspan"]}},
        },
        f"A force at crawling speed, {n} modes",
    )


def _train_case(n: int) -> str:
    beam = beam_from_mapping(CASE["bridge"]["right"], CASE["bridge"]["length"], n)
    sampling = 0.5 / TRAIN_VELOCITY / 10
    # 150 rad/s is above every eigenvalue of the vehicle, overdamped ones included.
    substeps = math.ceil(sampling / _step(beam, 150.0))
    changes = {
        "bridge.modes": n,
        "velocity": TRAIN_VELOCITY,
        "solver": {"sampling": sampling, "substeps": substeps, "duration": 1.0},
        "output": {"histories": {"channels": ["right_midspan", "left_midspan"]}},
    }
    return text(changed(changes), f"The train at crawling speed, {n} modes")


CASES = {f"crawling-force-{n}": _force_case(n) for n in MODES} | {
    f"crawling-train-{n}": _train_case(n) for n in MODES
}
LINE = "influence line"
SAME = Tolerance(5e-4, "what is left of the dynamics is at most v/v_c = 5e-4 of the peak")
ROUNDING = Tolerance(1e-13, "rounding")
EXACT = Tolerance(5.2e-4, "the dynamics, 5e-4, and the modes above the 20th, 2e-5")


def compare(solved: Mapping[str, Solved]) -> Outcome:
    """All along the crossing: against the line with the same modes, and 20 modes against the exact one."""
    outcome = Outcome()
    for n in MODES:
        h, beam = solved[f"crawling-force-{n}"].history(), _force_beam(n)
        x = h["time"] * ALPHA * critical_speed(beam)
        _line(outcome, f"a force, {n} modes", "right", h["right_midspan"], beam, [FORCE], [0.0], x, n)
        h = solved[f"crawling-train-{n}"].history()
        crossing = crossing_from_case(changed({"bridge.modes": n}))
        x = h["time"] * TRAIN_VELOCITY
        loads = list(static_wheel_loads(crossing))
        distances = list(crossing.train.axle_distances)
        for side, beam in (("right", crossing.right), ("left", crossing.left)):
            w = h[f"{side}_midspan"]
            _line(outcome, f"31-DOF train, {n} modes, {side}", side, w, beam, loads, distances, x, n)
            _amplification(
                outcome, solved[f"crawling-train-{n}"], f"31-DOF train, {n} modes", side, beam, loads
            )
    return outcome


def _amplification(
    outcome: Outcome, solved: Solved, case: str, side: str, beam: Beam, loads: list[float]
) -> None:
    """Both dynamic amplification factors of a beam, section 3.6."""
    static = sum(loads) * beam.length**3 / (48 * beam.EI)
    paper = float(solved.table("peak", f"{side}_midspan").item()) / static
    ours = float(solved.table("daf", side).item())
    outcome.number(case, f"DAF of the {side} beam", "1", ours, paper, "peak over F L^3/48EI", ROUNDING)
    ours = float(solved.table("daf", f"{side}_static").item())
    quantity, source = (
        f"DAF of the {side} beam over its static crossing",
        "a crawling train amplifies nothing",
    )
    outcome.number(case, quantity, "1", ours, 1.0, source, SAME)


def _line(
    outcome: Outcome,
    case: str,
    side: str,
    w: Array,
    beam: Beam,
    loads: list[float],
    distances: list[float],
    x: Array,
    n: int,
) -> None:
    """Compare one mid-span history w over the first axle's position x with its influence lines."""
    same = static_deflection(beam, loads, distances, x)
    outcome.history(case, f"{side}_midspan", "m", w, same, f"{LINE}, {n} modes", SAME)
    if n != MODES[-1]:
        return
    exact = static_deflection(beam, loads, distances, x, exact=True)
    outcome.history(case, f"{side}_midspan", "m", w, exact, f"{LINE}, exact", EXACT)
    outcome.curves.append(
        Curve(
            f"At crawling speed: {case}",
            "first axle (m)",
            "mid-span deflection (mm)",
            (Line("influence line, exact", x, exact * 1e3, reference=True), Line("tbi", x, w * 1e3)),
        )
    )


VERIFICATION = Verification(
    4,
    "Static limit",
    "At v/v_c = 5e-4 the mid-span deflection is the influence line, for a force and for the axles of the "
    "full train.",
    CASES,
    compare,
)
