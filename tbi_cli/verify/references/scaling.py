"""Dimensional scaling and the left-right mirror: cases whose responses follow from another's.

A geometrically and dynamically similar system, every length times lambda, mass times m, time times tau,
moves alike: displacements scale by lambda, rotations not at all, forces by m lambda / tau^2.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

# Exponents of (length, mass, time) of every number of a case file, by its key.
DIMENSIONS: dict[str, tuple[int, int, int]] = {
    "mass": (0, 1, 0),
    "roll_inertia": (2, 1, 0),
    "yaw_inertia": (2, 1, 0),
    "pitch_inertia": (2, 1, 0),
    "stiffness": (0, 1, -2),
    "damping": (0, 1, -1),
    "length": (1, 0, 0),
    "youngs_modulus": (-1, 1, -2),
    "second_moment": (4, 0, 0),
    "mass_per_length": (-1, 1, 0),
    "coefficient": (-1, 1, -1),
    "velocity": (1, 0, -1),
    "gravity": (1, 0, -2),
    "sampling": (0, 0, 1),
    "support_distance": (1, 0, 0),
    "forces": (1, 1, -2),
    "positions": (1, 0, 0),
}
# A beam's own damping c is per metre of beam.
BEAM_DAMPING = (-1, 1, -1)
_PURE = {"modes", "first_mode_ratio", "ratio", "duration", "substeps", "value"}


def scaled(case: Mapping[str, Any], length: float, mass: float, time: float) -> dict[str, Any]:
    """The similar case: a mapping with the keys of the case file and SI numbers, every number scaled."""

    def walk(value: Any, path: tuple[str, ...]) -> Any:
        if isinstance(value, Mapping):
            return {key: walk(item, (*path, key)) for key, item in value.items()}
        if isinstance(value, list | tuple):
            return [walk(item, path) for item in value]
        if isinstance(value, bool) or not isinstance(value, int | float) or path[-1] in _PURE:
            return value
        if path[0] == "bridge" and path[-1] == "damping":
            exponents = BEAM_DAMPING
        elif "geometry" in path:
            exponents = (1, 0, 0)
        else:
            exponents = DIMENSIONS[path[-1]]
        return value * length ** exponents[0] * mass ** exponents[1] * time ** exponents[2]

    out: dict[str, Any] = walk(case, ())
    return out


def response_scale(units: str, length: float, mass: float, time: float) -> float:
    """What a channel with these SI units is multiplied by in the similar system."""
    exponents = {
        "m": (1, 0, 0),
        "m/s": (1, 0, -1),
        "m/s2": (1, 0, -2),
        "rad": (0, 0, 0),
        "rad/s": (0, 0, -1),
        "rad/s2": (0, 0, -2),
        "N": (1, 1, -2),
        "m1.5": (1.5, 0, 0),
    }[units]
    return float(length ** exponents[0] * mass ** exponents[1] * time ** exponents[2])


def mirrored(case: Mapping[str, Any]) -> dict[str, Any]:
    """The same crossing seen in a mirror: right and left beams exchanged."""
    bridge = dict(case["bridge"])
    bridge["right"], bridge["left"] = bridge["left"], bridge["right"]
    return {**case, "bridge": bridge}


def mirror_sign(channel: str) -> tuple[str, float]:
    """The channel's name in the mirror, and its sign: roll, yaw and lateral motions change sign."""
    motion = channel.removesuffix("_velocity").removesuffix("_acceleration")
    sign = -1.0 if motion.endswith(("_z", "_roll", "_yaw")) else 1.0
    if "right" in channel:
        return channel.replace("right", "left"), sign
    return channel.replace("left", "right"), sign
