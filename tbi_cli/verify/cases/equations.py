"""Group 9: Eqs. (12a-f) as printed, and the state-space form of Appendix 1, for random parameters."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from typing import Any

import numpy as np

from tbi_cli.verify.assembled import accelerations, assembled
from tbi_cli.verify.cases.full_train import CASE, text
from tbi_cli.verify.check import Outcome, Tolerance
from tbi_cli.verify.references.crossing import CoupledSystem
from tbi_cli.verify.references.parameters import Array, crossing_from_case
from tbi_cli.verify.references.printed_motion import printed_accelerations
from tbi_cli.verify.references.state_space import state_names, state_space
from tbi_cli.verify.solved import Solved, Verification

TRAINS, TIMES = 10, 8
PRINTED = "as printed, typed by hand"
ASSEMBLED = "Appendix 1, assembled from Eqs. (1a-c)"
ROUNDING = Tolerance(1e-13, "rounding: sums of at most a hundred terms of 1e-16, some of them cancelling")


def random_case(rng: np.random.Generator, heights: bool) -> dict[str, Any]:
    """The full train with every number drawn within a factor of two, both ends apart."""
    case = copy.deepcopy({key: CASE[key] for key in ("train", "bridge", "contact", "velocity", "gravity")})

    def draw(value: Any) -> Any:
        if isinstance(value, dict):
            return {key: draw(item) for key, item in value.items()}
        if not isinstance(value, float):
            return value
        return float(value * 2.0 ** rng.uniform(-1, 1)) if value else float(rng.uniform(0, 1e5))

    train = case["train"]
    for end in ("front_bogie", "rear_bogie"):
        train[end] = draw({**train["bogie"], "secondary": train["secondary"], "primary": train["primary"]})
    geometry = draw({k: v for k, v in train["geometry"].items() if k not in ("bogie_distance", "wheelbase")})
    geometry |= draw({"l_b1": 8.75, "l_b2": 8.75, "l_w1": 1.25, "l_w2": 1.25, "l_w3": 1.25, "l_w4": 1.25})
    for key in ("car_body_to_secondary", "secondary_to_bogie", "bogie_to_axle"):
        geometry[key] = geometry[key] if heights else 0.0
    train["geometry"] = geometry
    train["car_body"], train["wheelset"] = draw(train["car_body"]), draw(train["wheelset"])
    case["bridge"] = draw(case["bridge"])
    case["velocity"] = draw(case["velocity"])
    case["contact"] = {"model": "paper", "convective": bool(rng.integers(2)) if heights else False}
    return case


def compare(solved: Mapping[str, Solved]) -> Outcome:
    """The largest deviation over random trains, states and times, over the largest acceleration."""
    del solved
    outcome = Outcome()
    rng = np.random.default_rng(31)
    printed: dict[str, float] = {}
    form: dict[str, float] = {"A(t) X + f(t)": 0.0}
    wheels_on: set[int] = set()
    for _ in range(TRAINS):
        _printed(rng, printed)
        wheels_on |= _state_space(rng, form)
    states = f"{TRAINS * TIMES} random states"
    for equation, worst in printed.items():
        outcome.zero(states, f"{equation} / its largest acceleration", "1", worst, 1.0, PRINTED, ROUNDING)
    states += f", {min(wheels_on)} to {max(wheels_on)} axles on"
    quantity = "A(t) X + f(t), Eq. (21) / its largest term"
    outcome.zero(states, quantity, "1", form["A(t) X + f(t)"], 1.0, ASSEMBLED, ROUNDING)
    return outcome


EQUATIONS = {
    "Eq. (12a)": ("car_body_y",),
    "Eq. (12b)": ("right_mode_", "left_mode_"),
    "Eq. (12c)": ("wheelset_",),
    "Eq. (12d)": ("front_bogie_roll", "rear_bogie_roll"),
    "Eq. (12e)": ("front_bogie_y", "rear_bogie_y"),
    "Eq. (12f)": ("car_body_pitch",),
}


def _draw(
    rng: np.random.Generator, heights: bool
) -> tuple[CoupledSystem, list[tuple[float, Array, Array]], list[str]]:
    """A random system; at random times the state X in the paper's order and our derivative of it."""
    case = random_case(rng, heights)
    reference = CoupledSystem(crossing_from_case(case))
    ours = assembled(text(case, "random"))
    names = state_names(reference)[0::2]
    nv, n, L = len(ours.coordinates), reference.n, ours.length
    # the package's modal amplitudes are sqrt(2/L) times the paper's coordinates
    ratio = np.concatenate([np.ones(nv), np.full(2 * n, np.sqrt(2 / L))])
    to_ours = np.array([names.index(f"{body}_{motion}") for body, motion in ours.coordinates])
    order = np.concatenate([to_ours, np.arange(nv, nv + 2 * n)])
    drawn = []
    v = case["velocity"]
    for time in rng.uniform(0.0, 1.1 * (L + ours.axle_distance) / v, TIMES):
        X = rng.normal(size=2 * len(names))
        x, x_t = X[0::2][order] * ratio, X[1::2][order] * ratio
        x_tt = accelerations(ours, v, time, x, x_t) / ratio
        derivative = np.empty_like(X)
        derivative[0::2] = X[1::2]
        derivative[1::2][order] = x_tt
        drawn.append((float(time), X, derivative))
    return reference, drawn, names


def _printed(rng: np.random.Generator, worst: dict[str, float]) -> None:
    reference, drawn, names = _draw(rng, heights=False)
    for time, X, derivative in drawn:
        values = {
            f"{name}{s}": X[2 * i + j]
            for i, name in enumerate(names)
            for j, s in enumerate(("", "_velocity"))
        }
        values |= {f"wheelset_{k}_y{s}": 0.0 for k in (1, 2, 3, 4) for s in ("", "_velocity")}
        expected = printed_accelerations(reference.crossing, time, values)
        for equation, channels in EQUATIONS.items():
            chosen = [name for name in expected if name.startswith(channels)]
            ours = np.array([derivative[2 * names.index(name) + 1] for name in chosen])
            theirs = np.array([expected[name] for name in chosen])
            difference = float(np.abs(ours - theirs).max() / np.abs(theirs).max())
            worst[equation] = max(worst.get(equation, 0.0), difference)


def _state_space(rng: np.random.Generator, worst: dict[str, float]) -> set[int]:
    reference, drawn, _ = _draw(rng, heights=True)
    counts = set()
    for time, X, derivative in drawn:
        A, f = state_space(reference, time)
        counts.add(int(reference.axles_on(time).sum()))
        expected = A @ X + f
        difference = float(np.abs(derivative - expected).max() / np.abs(expected).max())
        worst["A(t) X + f(t)"] = max(worst["A(t) X + f(t)"], difference)
    return counts


VERIFICATION = Verification(
    9,
    "The printed equations",
    "Eqs. (12a-f) typed as printed, and the state-space form of Appendix 1, against the assembled matrices "
    "for random trains, bridges, states and times.",
    {},
    compare,
)
