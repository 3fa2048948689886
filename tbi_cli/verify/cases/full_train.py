"""The case of the 31-degree-of-freedom train that several groups share, as a mapping and as a case file."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from typing import Any

import yaml

# The paper's train and bridge as reconstructed: CRH380A data with the paper's car body mass, SI units.
CASE: dict[str, Any] = {
    "train": {
        "model": "full-31dof",
        "car_body": {
            "mass": 40e3,
            "roll_inertia": 110.2e3,
            "yaw_inertia": 1.5722e6,
            "pitch_inertia": 1.666e6,
        },
        "bogie": {"mass": 2280.0, "roll_inertia": 1847.0, "yaw_inertia": 2280.0, "pitch_inertia": 1249.0},
        "wheelset": {"mass": 1901.8, "roll_inertia": 685.0, "yaw_inertia": 685.0},
        "secondary": {
            "vertical": {"stiffness": 260e3, "damping": 40e3},
            "lateral": {"stiffness": 168.9e3, "damping": 58.8e3},
            "longitudinal": {"stiffness": 168.9e3, "damping": 0.0},
        },
        "primary": {
            "vertical": {"stiffness": 1.176e6, "damping": 29.6e3},
            "lateral": {"stiffness": 0.98e6, "damping": 0.0},
            "longitudinal": {"stiffness": 0.98e6, "damping": 0.0},
        },
        "geometry": {
            "bogie_distance": 17.5,
            "wheelbase": 2.5,
            "secondary_half_spacing": 1.23,
            "primary_half_spacing": 1.0,
            "car_body_to_secondary": 0.52,
            "secondary_to_bogie": 0.29,
            "bogie_to_axle": 0.08,
        },
    },
    "bridge": {
        "length": 50.0,
        "modes": 4,
        "right": {"youngs_modulus": 207e9, "second_moment": 0.2, "mass_per_length": 20e3, "damping": 10e3},
        "left": {"youngs_modulus": 200e9, "second_moment": 0.2, "mass_per_length": 18e3, "damping": 10e3},
    },
    "contact": {"model": "paper", "static_load": "physical"},
    "velocity": 50.0,
    "gravity": 9.81,
    "solver": {"method": "rk4", "sampling": 1e-3, "substeps": 2, "duration": 2.0},
    "output": {"histories": "all"},
}
# What makes its ends differ, so that no error can cancel by symmetry; axles at multiples of 0.25 m.
LOPSIDED = {
    "train.front_bogie": {"mass": 3000.0, "secondary": {"vertical": {"stiffness": 300e3, "damping": 25e3}}},
    "train.rear_bogie": {
        "roll_inertia": 2500.0,
        "primary": {"vertical": {"stiffness": 0.9e6, "damping": 12e3}},
    },
    "train.geometry.l_b1": 7.0,
    "train.geometry.l_w1": 1.5,
    "train.geometry.l_w4": 0.75,
}


def changed(changes: Mapping[str, Any], base: Mapping[str, Any] = CASE) -> dict[str, Any]:
    """The case with values replaced by dotted key, as `--set` does."""
    case: dict[str, Any] = copy.deepcopy(dict(base))
    for key, value in changes.items():
        *parents, last = key.split(".")
        mapping = case
        for parent in parents:
            mapping = mapping.setdefault(parent, {})
        mapping[last] = value
    return case


def text(case: Mapping[str, Any], title: str) -> str:
    """The case file of a mapping."""
    return yaml.safe_dump({"title": title, **case}, sort_keys=False)
