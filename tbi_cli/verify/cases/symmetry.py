"""Group 8: mirror, linearity, dimensional scaling, superposition."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tbi_cli.verify.cases.full_train import LOPSIDED, changed, text
from tbi_cli.verify.cases.moving_force import V_C
from tbi_cli.verify.check import Outcome, Tolerance, worst_channel
from tbi_cli.verify.references.parameters import Array
from tbi_cli.verify.references.scaling import mirror_sign, mirrored, response_scale, scaled
from tbi_cli.verify.solved import Solved, Verification

LENGTH_SCALE, MASS_SCALE, TIME_SCALE = 4.0, 8.0, 2.0
BASE = changed({**LOPSIDED, "velocity": 300 / 3.6, "solver.duration": 1.5})
FORCES, LAG_SAMPLES = (100e3, 60e3), 300
SAMPLING = 1e-3
SPEED = 0.4 * V_C

FORCE_CASE = """
title: {title}
train: {{model: moving-load, forces: [{forces}], positions: [{positions}]}}
bridge:
  length: 20 m
  modes: 5
  right: {{youngs_modulus: 30 GPa, second_moment: 0.3, mass_per_length: 10 t/m, damping: {{ratio: 1 %}}}}
velocity: {velocity!r}
solver: {{sampling: {sampling!r}, substeps: 4, duration: {duration!r}}}
output: {{histories: {{channels: [right_midspan]}}}}
"""


def _forces(title: str, forces: list[float], positions: list[float], duration: float) -> str:
    return FORCE_CASE.format(
        title=title,
        forces=", ".join(map(repr, forces)),
        positions=", ".join(map(repr, positions)),
        velocity=SPEED,
        sampling=20.0 / SPEED / 500,
        duration=duration,
    )


LAG = 20.0 * LAG_SAMPLES / 500
CASES = {
    "symmetry-base": text(BASE, "Symmetry and scaling"),
    "symmetry-mirrored": text(mirrored(BASE), "The same in a mirror"),
    "symmetry-halved": text(changed({"gravity": 9.81 / 2}, BASE), "Half the gravity"),
    "symmetry-scaled": text(
        scaled(BASE, LENGTH_SCALE, MASS_SCALE, TIME_SCALE),
        "A similar system: lengths x 4, masses x 8, times x 2",
    ),
    "superposition-first": _forces("First force", [FORCES[0]], [0.0], 2.0),
    "superposition-second": _forces("Second force", [FORCES[1]], [0.0], 2.0),
    "superposition-both": _forces("Both forces", list(FORCES), [0.0, LAG], 1.25),
}
BITS = Tolerance(1e-14, "none to speak of: the same operations on numbers scaled by powers of two")
MIRROR = Tolerance(
    1e-11,
    "rounding of 1e-16 in the deflections, of which lateral and roll motions are differences a thousand "
    "times smaller, over some thousand steps",
)
SUMMED = Tolerance(1e-13, "rounding: Runge-Kutta is linear in the load")
SYMMETRY = "symmetry of the equations"


def compare(solved: Mapping[str, Solved]) -> Outcome:
    """The largest deviation over all channels for each symmetry; two forces against their sum."""
    outcome = Outcome()
    base = solved["symmetry-base"].history()
    units = solved["symmetry-base"].history_units
    t = base.pop("time")

    mirror = solved["symmetry-mirrored"].history()
    pairs = {}
    for name in base:
        image, sign = mirror_sign(name)
        pairs[name] = (mirror[image], sign * base[name])
    _all_channels(outcome, "left-right mirror", pairs, MIRROR)

    halved = solved["symmetry-halved"].history()
    pairs = {name: (halved[name], 0.5 * base[name]) for name in base}
    _all_channels(outcome, "half the gravity", pairs, BITS)

    similar = solved["symmetry-scaled"].history()
    pairs = {"time": (similar["time"], TIME_SCALE * t)}
    for name in base:
        factor = response_scale(units[name], LENGTH_SCALE, MASS_SCALE, TIME_SCALE)
        pairs[name] = (similar[name], factor * base[name])
    _all_channels(outcome, "similar system", pairs, BITS)

    first, second, both = (
        solved[f"superposition-{x}"].history()["right_midspan"] for x in ("first", "second", "both")
    )
    summed = first[: len(both)] + np.concatenate([np.zeros(LAG_SAMPLES), second])[: len(both)]
    outcome.history("two forces", "right_midspan", "m", both, summed, "sum of the forces one by one", SUMMED)
    return outcome


def _all_channels(
    outcome: Outcome, case: str, pairs: Mapping[str, tuple[Array, Array]], tolerance: Tolerance
) -> None:
    """One check for all channels: that of the channel that differs most, over its largest value."""
    worst = worst_channel(pairs)
    quantity = f"all {len(pairs)} channels (worst: {worst})"
    outcome.history(case, quantity, "SI", *pairs[worst], SYMMETRY, tolerance)


VERIFICATION = Verification(
    8,
    "Symmetry, linearity and scaling",
    "The full train at 300 km/h seen in a mirror, under half the gravity, and with every length, mass and "
    "time scaled; two forces against each alone.",
    CASES,
    compare,
)
