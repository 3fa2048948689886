"""Where the repetition of axles can bring a bridge into resonance."""

from __future__ import annotations

import numpy as np

from tbi_cli.case import Case, Consist, FullTrain, HslmA, RigidBeam
from tbi_cli.system.bridge import natural_frequencies

# The largest i of v = f_j D/i: beyond it a mode swings so often between two bogies that nothing builds up.
_MOST_PARTS = 6


def repeats_after(case: Case) -> tuple[float, ...]:
    """The ways (m) after which the axles of a train repeat themselves; of one vehicle, first axle to last."""
    train = case.train
    if isinstance(train, Consist):
        return tuple({group.spacing for group in train.consist if group.count > 1})
    if isinstance(train, HslmA):
        return (train.coach_length,)
    if isinstance(train, FullTrain):
        arms = train.geometry
        return (arms.l_b1 + arms.l_w1 + arms.l_b2 + arms.l_w4,)
    return (train.support_distance,) if isinstance(train, RigidBeam) else ()


def resonant_speeds(case: Case) -> list[tuple[str, int, int, float]]:
    """Side of the beam, mode j, part i and speed (m/s) of every v = f_j D/i of a case, the fastest first."""
    found = []
    for side, beam in (("right", case.bridge.right), ("left", case.bridge.left)):
        if beam is None:
            continue
        for j, omega in enumerate(natural_frequencies(case.bridge, beam), 1):
            for way in repeats_after(case):
                for i in range(1, _MOST_PARTS + 1):
                    found.append((side, j, i, float(omega) * way / (2 * np.pi * i)))
    return sorted(found, key=lambda speed: -speed[3])
