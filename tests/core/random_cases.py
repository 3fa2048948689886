"""Full trains and bridges without any symmetry, drawn from a seed: mappings with the keys of the case file.

Nothing in them is like anything else: front and rear end, the six arms, right and left beam and how their
damping is given.  Numbers are SI.  A reference takes the mapping itself; the program reads the file made of
it.
"""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from tbi_cli.case import Case, load_case


class _Draw:
    """Numbers around typical ones, and lengths that are multiples of a raster (m)."""

    def __init__(self, seed: int, raster: float) -> None:
        self.random, self.raster = np.random.default_rng(seed), raster

    def near(self, typical: float) -> float:
        return float(typical * 2.0 ** self.random.uniform(-0.5, 0.5))

    def length(self, low: float, high: float) -> float:
        return round(float(self.random.integers(round(low / self.raster), round(high / self.raster) + 1))) * (
            self.raster
        )

    def spring(self, stiffness: float, damping: float) -> dict[str, float]:
        return {"stiffness": self.near(stiffness), "damping": self.near(damping)}

    def suspension(self, vertical: tuple[float, float], across: tuple[float, float]) -> dict[str, Any]:
        directions = {"vertical": vertical, "lateral": across, "longitudinal": across}
        return {direction: self.spring(*typical) for direction, typical in directions.items()}

    def end(self) -> dict[str, Any]:
        bogie = {"mass": 2500, "roll_inertia": 2000, "yaw_inertia": 2600, "pitch_inertia": 1500}
        return {
            **{key: self.near(value) for key, value in bogie.items()},
            "secondary": self.suspension((2.6e5, 3.5e4), (1.7e5, 2e4)),
            "primary": self.suspension((1.2e6, 2.5e4), (1e6, 4e3)),
        }

    def beam(self) -> dict[str, float]:
        return {
            "youngs_modulus": self.near(200e9),
            "second_moment": self.near(0.2),
            "mass_per_length": self.near(18e3),
        }


def full_train(seed: int, raster: float = 0.05) -> dict[str, Any]:
    """The train of 31 degrees of freedom, each end and each arm another."""
    draw = _Draw(seed, raster)
    common, rear = draw.end(), draw.end()
    # The front end is what holds for both but for what is said of the rear one; it says its mass itself.
    both = {key: common.pop(key) for key in ("secondary", "primary")}
    arms = {"l_b1": draw.length(7, 8.5), "l_b2": draw.length(9, 10.5)}
    arms |= {"l_w1": draw.length(1.3, 1.5), "l_w2": draw.length(0.9, 1.2)}
    arms |= {"l_w3": draw.length(1.0, 1.25), "l_w4": draw.length(1.35, 1.6)}
    geometry = {"secondary_half_spacing": 1.2, "primary_half_spacing": 0.95, "car_body_to_secondary": 0.6}
    geometry |= {"secondary_to_bogie": 0.25, "bogie_to_axle": 0.1}
    inertias = {"mass": 35e3, "roll_inertia": 9e4, "yaw_inertia": 1.5e6, "pitch_inertia": 1.6e6}
    wheelset = {"mass": 1800, "roll_inertia": 700, "yaw_inertia": 750}
    return {
        "model": "full-31dof",
        "car_body": {key: draw.near(value) for key, value in inertias.items()},
        "bogie": common,
        "front_bogie": {"mass": draw.near(3000)},
        "rear_bogie": rear,
        "wheelset": {key: draw.near(value) for key, value in wheelset.items()},
        **both,
        "geometry": arms | {key: draw.near(value) for key, value in geometry.items()},
    }


def crossing(seed: int, *, raster: float = 0.05, **changes: Any) -> dict[str, Any]:
    """A full train on two beams, every channel kept; lengths along the track are multiples of `raster` (m).

    changes: keys of the case in place of these; mappings among them change single keys.
    """
    draw = _Draw(seed + 1_000_000, raster)
    case = {
        "train": full_train(seed, raster),
        "bridge": {
            "length": draw.length(35, 55),
            "modes": int(draw.random.integers(3, 6)),
            "right": {**draw.beam(), "damping": draw.near(9e3)},
            "left": {**draw.beam(), "damping": {"ratio": draw.near(0.02)}},
        },
        "contact": {"model": "paper", "static_load": "physical"},
        "velocity": float(draw.random.uniform(40, 90)),
        "solver": {"method": "rk4", "sampling": 1e-3, "substeps": 1, "duration": 1.5},
        "output": {"histories": "all"},
    }
    return merged(case, changes)


def merged(case: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """The case with the changes in it, mappings key by key."""
    out = dict(case)
    for key, value in changes.items():
        inner = out.get(key)
        deeper = isinstance(value, Mapping) and isinstance(inner, Mapping)
        out[key] = merged(inner, value) if deeper else value
    return out


def read(case: Mapping[str, Any], *overrides: str) -> Case:
    """The case as the program reads it from a file."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "case.yaml")
        path.write_text(yaml.safe_dump(dict(case), sort_keys=False))
        return load_case(path, overrides=overrides)


def masses(case: Mapping[str, Any]) -> dict[str, float]:
    """The mass (kg) of each body of the train."""
    train = case["train"]
    bogies = {
        f"{end}_bogie": train.get(f"{end}_bogie", {}).get("mass", train["bogie"]["mass"])
        for end in ("front", "rear")
    }
    wheelsets = {f"wheelset_{k}": train["wheelset"]["mass"] for k in range(1, 5)}
    return {"car_body": train["car_body"]["mass"], **bogies, **wheelsets}
