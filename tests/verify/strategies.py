"""Random physical vehicles, bridges and speeds, as mappings with the keys of the case file (SI)."""

from __future__ import annotations

import math
from typing import Any

from hypothesis import strategies as st

# Lengths are whole multiples of this, so that a sampling interval exists on which every entry and exit falls.
RASTER = 0.05
# Fastest motion times the sampling interval: small enough for energies to be integrated over the samples.
RESOLUTION = 0.1


def _between(low: float, high: float) -> st.SearchStrategy[float]:
    """Floats of even spread over decades."""
    return st.floats(math.log(low), math.log(high)).map(math.exp)


def _length(low: float, high: float) -> st.SearchStrategy[float]:
    return st.integers(round(low / RASTER), round(high / RASTER)).map(lambda n: n * RASTER)


def _spring(k: tuple[float, float], c: tuple[float, float]) -> st.SearchStrategy[dict[str, float]]:
    return st.fixed_dictionaries({"stiffness": _between(*k), "damping": st.just(0.0) | _between(*c)})


def _suspension(stage: str) -> st.SearchStrategy[dict[str, Any]]:
    if stage == "secondary":
        vertical = _spring((1e5, 1e6), (1e4, 1e5))
        plane = _spring((5e4, 1e6), (1e4, 8e4))
    else:
        vertical = _spring((5e5, 2.5e6), (5e3, 5e4))
        plane = _spring((5e5, 1e7), (1e3, 2e4))
    return st.fixed_dictionaries({"vertical": vertical, "lateral": plane, "longitudinal": plane})


def _end() -> st.SearchStrategy[dict[str, Any]]:
    return st.fixed_dictionaries(
        {
            "mass": _between(1500, 6000),
            "roll_inertia": _between(1000, 5000),
            "yaw_inertia": _between(1000, 8000),
            "pitch_inertia": _between(1000, 8000),
            "secondary": _suspension("secondary"),
            "primary": _suspension("primary"),
        }
    )


@st.composite
def full_trains(draw: st.DrawFn) -> dict[str, Any]:
    """The 31-degree-of-freedom train, both ends drawn apart."""
    rear, common = draw(_end()), draw(_end())
    front = {stage: common.pop(stage) for stage in ("secondary", "primary")} | {"bogie": common}
    return {
        "model": "full-31dof",
        "car_body": {
            "mass": draw(_between(15e3, 80e3)),
            "roll_inertia": draw(_between(4e4, 2e5)),
            "yaw_inertia": draw(_between(5e5, 3e6)),
            "pitch_inertia": draw(_between(5e5, 3e6)),
        },
        "wheelset": {
            "mass": draw(_between(1000, 2500)),
            "roll_inertia": draw(_between(500, 1500)),
            "yaw_inertia": draw(_between(500, 1500)),
        },
        **front,
        "rear_bogie": rear,
        "geometry": {
            "l_b1": draw(_length(5, 10)),
            "l_b2": draw(_length(5, 10)),
            "l_w1": draw(_length(0.9, 1.6)),
            "l_w2": draw(_length(0.9, 1.6)),
            "l_w3": draw(_length(0.9, 1.6)),
            "l_w4": draw(_length(0.9, 1.6)),
            "secondary_half_spacing": draw(st.floats(0.8, 1.4)),
            "primary_half_spacing": draw(st.floats(0.7, 1.2)),
            "car_body_to_secondary": draw(st.integers(-500, 1500)) / 1000,
            "secondary_to_bogie": draw(st.integers(-300, 500)) / 1000,
            "bogie_to_axle": draw(st.integers(-200, 300)) / 1000,
        },
    }


def sprung_masses() -> st.SearchStrategy[dict[str, Any]]:
    """A mass on one spring-damper."""
    values = {
        "model": st.just("sprung-mass"),
        "mass": _between(1e3, 1e5),
        "stiffness": _between(1e5, 5e6),
        "damping": st.just(0.0) | _between(1e3, 1e5),
    }
    return st.fixed_dictionaries(values)


def rigid_beams() -> st.SearchStrategy[dict[str, Any]]:
    """A rigid body on two spring-dampers."""
    values = {
        "model": st.just("rigid-beam"),
        "mass": _between(1e4, 3e5),
        "pitch_inertia": _between(1e5, 1e7),
        "support_distance": _length(5, 20),
        "stiffness": _between(5e5, 5e7),
        "damping": st.just(0.0) | _between(1e3, 1e5),
    }
    return st.fixed_dictionaries(values)


@st.composite
def moving_loads(draw: st.DrawFn) -> dict[str, Any]:
    """One to five forces; their positions begin anywhere."""
    gaps = [draw(st.just(0.0) | _length(1, 30)), *draw(st.lists(_length(1, 20), max_size=4))]
    positions = [math.fsum(gaps[: k + 1]) for k in range(len(gaps))]
    forces = draw(st.lists(_between(1e4, 2e5), min_size=len(positions), max_size=len(positions)))
    return {"model": "moving-load", "forces": forces, "positions": positions}


@st.composite
def cases(draw: st.DrawFn, trains: st.SearchStrategy[dict[str, Any]]) -> dict[str, Any]:
    """A train, its bridge, a speed, and a sampling interval on which entries and exits fall."""
    train = draw(trains)
    length, modes = draw(_length(10, 60)), draw(st.integers(1, 4))

    def beam() -> dict[str, Any]:
        mu = draw(_between(5e3, 40e3))
        # first frequencies of railway bridges lie about 100 Hz m / L
        f_1 = draw(st.floats(60, 150)) / length
        EI = mu * (2 * math.pi * f_1) ** 2 * (length / math.pi) ** 4
        ratio = draw(st.just(0.0) | st.floats(0.001, 0.05))
        return {
            "youngs_modulus": 30e9,
            "second_moment": EI / 30e9,
            "mass_per_length": mu,
            "damping": {"ratio": ratio},
        }

    bridge: dict[str, Any] = {"length": length, "modes": modes, "right": beam()}
    if train["model"] == "full-31dof":
        bridge["left"] = beam()
    velocity = draw(st.floats(15, 100))
    # 300 1/s is above the fastest motion of any of these vehicles
    fastest = max(300.0, modes**2 * 2 * math.pi * 150 / length)
    per_raster = math.ceil(RASTER / velocity * fastest / RESOLUTION)
    return {
        "train": train,
        "bridge": bridge,
        "contact": {"model": "paper", "convective": draw(st.booleans())},
        "velocity": velocity,
        "gravity": 9.81,
        "solver": {"sampling": RASTER / velocity / per_raster, "substeps": 2, "duration": 1.3},
        "output": {"histories": "all"},
    }
