"""Rails with nothing in common: random shapes, waves and measured points, others right than left."""

from __future__ import annotations

from typing import Any

import numpy as np


def unsymmetric(seed: int, first: float = -38.0, last: float = 45.0) -> dict[str, Any]:
    """`track.irregularity` of every kind but random, between two places (m).

    The measured points are unevenly far apart, and the first and the last of them are off level.
    """
    draw = np.random.default_rng(seed)

    def at() -> dict[str, Any]:
        length = float(draw.uniform(1.5, 9.0))
        return {"at": float(draw.uniform(first, last - length)), "length": length}

    sides = draw.permutation(["right", "left", "opposite", "right"])
    gaps = draw.uniform(2.0, 9.0, 40).cumsum()
    x = first + gaps[gaps < last - first]
    right, left = draw.uniform(-1.5e-3, 1.5e-3, (2, len(x)))
    return {
        "ramp": {**at(), "height": float(draw.uniform(1e-3, 3e-3)), "rails": str(sides[0])},
        "dip": {**at(), "depth": float(draw.uniform(1e-3, 3e-3)), "rails": str(sides[1])},
        "half_sine": {**at(), "height": float(draw.uniform(0.5e-3, 1e-3)), "rails": str(sides[2])},
        "harmonic": {
            "wavelength": float(draw.uniform(6.0, 20.0)),
            "amplitude": float(draw.uniform(0.2e-3, 1e-3)),
            "at": float(draw.uniform(-5.0, 5.0)),
            "rails": str(sides[3]),
        },
        "profile": {"x": x.tolist(), "right": right.tolist(), "left": left.tolist()},
    }
