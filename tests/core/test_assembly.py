"""The assembled train against Eqs. (12a-f), written out here term by term."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tbi_cli.system.assembly import System, build_system
from tests.core.crossings import paper

Array = NDArray[np.float64]


def system_with(seed: int, *, heights: bool, static_load: str = "paper") -> tuple[System, dict[str, float]]:
    """A train with every symbol at random, front and rear apart, and the symbols' values."""
    rng = np.random.default_rng(seed)
    value = {name: float(rng.uniform(0.2, 5.0)) for name in SYMBOLS}
    if not heights:
        value |= {"h_c": 0.0, "h_b": 0.0, "h_w": 0.0}
    keys = [f"{SYMBOLS[name]}={value[name]!r}" for name in SYMBOLS]
    wheelbases = ["train.geometry.bogie_distance=null", "train.geometry.wheelbase=null"]
    return build_system(paper(*wheelbases, f"contact.static_load={static_load}", *keys)), value


def _bogie(end: str, b: str, k_b: str, k_w: str) -> dict[str, str]:
    at = f"train.{end}_bogie"
    symbols = {
        f"m_{b}": f"{at}.mass",
        f"I_{b}x": f"{at}.roll_inertia",
        f"I_{b}y": f"{at}.yaw_inertia",
        f"I_{b}z": f"{at}.pitch_inertia",
    }
    for name, stage in ((k_b, "secondary"), (k_w, "primary")):
        for axis, direction in (("y", "vertical"), ("z", "lateral"), ("x", "longitudinal")):
            symbols[f"k_{name}{axis}"] = f"{at}.{stage}.{direction}.stiffness"
            symbols[f"c_{name}{axis}"] = f"{at}.{stage}.{direction}.damping"
    return symbols


SYMBOLS = {
    "m_c": "train.car_body.mass",
    "I_cx": "train.car_body.roll_inertia",
    "I_cy": "train.car_body.yaw_inertia",
    "I_cz": "train.car_body.pitch_inertia",
    **_bogie("front", "b1", "b1", "w1"),
    **_bogie("rear", "b2", "b2", "w3"),
    "m_w": "train.wheelset.mass",
    "I_wx": "train.wheelset.roll_inertia",
    "I_wy": "train.wheelset.yaw_inertia",
    "a": "train.geometry.secondary_half_spacing",
    "d": "train.geometry.primary_half_spacing",
    "h_c": "train.geometry.car_body_to_secondary",
    "h_b": "train.geometry.secondary_to_bogie",
    "h_w": "train.geometry.bogie_to_axle",
    **{f"l_{name}": f"train.geometry.l_{name}" for name in ("b1", "b2", "w1", "w2", "w3", "w4")},
}


class Motion:
    """Random positions or velocities by the paper's names: r_cy, th_b1z, w_R1 .. (beam under wheel k)."""

    def __init__(self, system: System, seed: int) -> None:
        rng = np.random.default_rng(seed)
        self.vector = rng.normal(size=len(system.coordinates))
        names = {"car_body": "c", "front_bogie": "b1", "rear_bogie": "b2"}
        names |= {f"wheelset_{k}": f"w{k}" for k in range(1, 5)}
        kinds = {"y": "r_{}y", "z": "r_{}z", "roll": "th_{}x", "yaw": "th_{}y", "pitch": "th_{}z"}
        for (body, motion), x in zip(system.coordinates, self.vector, strict=True):
            setattr(self, kinds[motion].format(names[body]), x)
        for axle, beam in zip(system.wheel_axle, system.wheel_beam, strict=True):
            setattr(self, f"w_{'RL'[beam]}{axle + 1}", rng.normal())
        self.deflections = np.array(
            [
                getattr(self, f"w_{'RL'[b]}{k + 1}")
                for k, b in zip(system.wheel_axle, system.wheel_beam, strict=True)
            ]
        )


def accelerations(system: System, q: Motion, dq: Motion) -> dict[str, float]:
    """x'' of every coordinate by the assembled matrices, the beams moving as given."""
    force = -system.K @ q.vector - system.C @ dq.vector
    for wheel, row in enumerate(system.wheel_rows):
        force += row * system.wheel_stiffness[wheel] * q.deflections[wheel]
        force += row * system.wheel_damping[wheel] * dq.deflections[wheel]
    return dict(zip(("_".join(c) for c in system.coordinates), force / system.M, strict=True))


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), heights=st.booleans())
def test_vertical_lateral_and_pitch_rows(seed: int, heights: bool) -> None:
    """Eqs. (12a), (12c), (12e), (12f): rounding only, so 1e-12 of the sum of the terms' sizes."""
    system, p = system_with(seed, heights=heights)
    q, v = Motion(system, seed + 1), Motion(system, seed + 2)
    x = accelerations(system, q, v)

    def k_c(k: float, c: float, spring: str) -> float:
        return k * eval(spring, {}, vars(q) | p) + c * eval(spring, {}, vars(v) | p)

    front, rear = "r_cy - r_b1y + th_cz*l_b1", "r_cy - r_b2y - th_cz*l_b2"
    s1 = k_c(p["k_b1y"], p["c_b1y"], front)
    s2 = k_c(p["k_b2y"], p["c_b2y"], rear)
    eq_12a = -2 / p["m_c"] * (s1 + s2)
    eq_12f = -2 / p["I_cz"] * (p["l_b1"] * s1 - p["l_b2"] * s2)
    # (12c), of the second wheelset; the yaw arm that print drops is X = -l_w2 (model.md).
    wheel = k_c(p["k_w1z"], p["c_w1z"], "r_b1z - r_w2z - th_b1x*h_w + th_b1y*l_w2")
    eq_12c = 2 / p["m_w"] * wheel
    eq_12e = 2 / p["m_b1"] * s1 - 1 / p["m_b1"] * (
        k_c(p["k_w1y"], p["c_w1y"], "2*r_b1y - w_R1 - w_L1 + 2*th_b1z*l_w1")
        + k_c(p["k_w1y"], p["c_w1y"], "2*r_b1y - w_R2 - w_L2 - 2*th_b1z*l_w2")
    )
    expected = {
        "car_body_y": eq_12a,
        "car_body_pitch": eq_12f,
        "wheelset_2_z": eq_12c,
        "front_bogie_y": eq_12e,
    }
    for name, value in expected.items():
        assert x[name] == pytest.approx(value, rel=1e-11, abs=1e-9)


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_roll_of_the_rear_bogie(seed: int) -> None:
    """Eq. (12d), which holds as printed where all heights are zero (model.md)."""
    system, p = system_with(seed, heights=False)
    q, v = Motion(system, seed + 1), Motion(system, seed + 2)
    x = accelerations(system, q, v)
    total = 0.0
    for k_b, k_w, m in ((p["k_b2y"], p["k_w3y"], q), (p["c_b2y"], p["c_w3y"], v)):
        total += 2 * k_b * p["a"] ** 2 * (m.th_cx - m.th_b2x)
        total += k_w * p["d"] * (2 * m.th_w3x * p["d"] - m.w_R3 + m.w_L3 - 2 * m.th_b2x * p["d"])
        total += k_w * p["d"] * (2 * m.th_w4x * p["d"] - m.w_R4 + m.w_L4 - 2 * m.th_b2x * p["d"])
    assert x["rear_bogie_roll"] == pytest.approx(total / p["I_b2x"], rel=1e-11, abs=1e-9)


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), heights=st.booleans())
def test_energy_is_that_of_equation_1b(seed: int, heights: bool) -> None:
    """1/2 q K q and 1/2 q' C q' against the brackets of Eqs. (1b), (1c), every spring of Fig. 2 by itself."""
    system, p = system_with(seed, heights=heights)
    q = Motion(system, seed + 3)
    for matrix, letter in ((system.K, "k"), (system.C, "c")):
        energy = 0.0
        for bogie, wheels, w, length in (
            ("b1", (1, 2), "w1", "l_b1"),
            ("b2", (3, 4), "w3", "-l_b2"),
        ):
            for side in ("a", "-a"):
                energy += p[f"{letter}_{bogie}y"] * _bracket(
                    f"r_cy - r_{bogie}y + th_cz*({length}) - th_cx*({side}) + th_{bogie}x*({side})", q, p
                )
                energy += p[f"{letter}_{bogie}z"] * _bracket(
                    f"r_cz - h_c*th_cx - ({length})*th_cy - r_{bogie}z - h_b*th_{bogie}x", q, p
                )
                energy += p[f"{letter}_{bogie}x"] * _bracket(f"({side})*(th_cy - th_{bogie}y)", q, p)
            for k, arm in zip(wheels, (f"l_w{wheels[0]}", f"-l_w{wheels[1]}"), strict=True):
                for side in ("d", "-d"):
                    energy += p[f"{letter}_{w}y"] * _bracket(
                        f"r_{bogie}y + th_{bogie}z*({arm}) - th_{bogie}x*({side}) + th_w{k}x*({side})", q, p
                    )
                    energy += p[f"{letter}_{w}z"] * _bracket(
                        f"r_{bogie}z - h_w*th_{bogie}x - ({arm})*th_{bogie}y - r_w{k}z", q, p
                    )
                    energy += p[f"{letter}_{w}x"] * _bracket(f"({side})*(th_{bogie}y - th_w{k}y)", q, p)
        assert q.vector @ matrix @ q.vector == pytest.approx(energy, rel=1e-11)


def _bracket(text: str, q: Motion, p: dict[str, float]) -> float:
    return float(eval(text, {}, vars(q) | p)) ** 2


def test_springs_between_bodies_that_turn() -> None:
    """Twice the energy of small motions from the places of the springs' ends, by matrices of rotation.

    Bodies are moved and turned by eps and by -eps, without any formula for small rotations: the mean of both
    energies over eps^2 is exact to eps^2.  Longitudinal springs lie at the height of both centres (model.md).
    """
    eps = 1e-4
    for seed in range(3):
        system, p = system_with(seed, heights=True)
        q = Motion(system, seed + 5)
        for matrix, letter in ((system.K, "k"), (system.C, "c")):
            mean = (_turned_energy(q, p, letter, eps) + _turned_energy(q, p, letter, -eps)) / (2 * eps**2)
            assert q.vector @ matrix @ q.vector == pytest.approx(mean, rel=1e-5)


def _turned_energy(q: Motion, p: dict[str, float], letter: str, eps: float) -> float:
    """Sum of k stretch^2 over all springs on level track, the bodies where eps q puts them."""

    def place(body: str, x: float, y: float, z: float) -> Array:
        turn = eps * np.array([getattr(q, f"th_{body}{axis}", 0.0) for axis in "xyz"])
        moved = eps * np.array([getattr(q, f"r_{body}{axis}", 0.0) for axis in "xyz"])
        return Rotation.from_rotvec(turn).apply([x, y, z]) - [x, y, z] + moved

    def spring(axis: str, name: str, upper: Array, lower: Array) -> float:
        stretch = (upper - lower)["xyz".index(axis)]
        return p[f"{letter}_{name}{axis}"] * float(stretch) ** 2

    total = 0.0
    ends = (("b1", p["l_b1"], "w1", (("w1", p["l_w1"]), ("w2", -p["l_w2"]))),)
    ends += (("b2", -p["l_b2"], "w3", (("w3", p["l_w3"]), ("w4", -p["l_w4"]))),)
    for bogie, x, primary, axles in ends:
        for a in (p["a"], -p["a"]):
            total += spring("y", bogie, place("c", x, 0, a), place(bogie, 0, 0, a))
            total += spring("z", bogie, place("c", x, -p["h_c"], 0), place(bogie, 0, p["h_b"], 0))
            total += spring("x", bogie, place("c", 0, 0, a), place(bogie, 0, 0, a))
        for wheelset, arm in axles:
            for d in (p["d"], -p["d"]):
                total += spring("y", primary, place(bogie, arm, 0, d), place(wheelset, 0, 0, d))
                total += spring("z", primary, place(bogie, arm, -p["h_w"], 0), place(wheelset, 0, 0, 0))
                total += spring("x", primary, place(bogie, 0, 0, d), place(wheelset, 0, 0, d))
    return total


def test_a_train_has_31_coordinates_in_the_order_of_equation_9() -> None:
    """27 of them here: the wheelsets' own y follow the beams."""
    system = build_system(paper())
    bodies = ("car_body", "front_bogie", "rear_bogie")
    expected = [(body, motion) for body in bodies for motion in ("y", "z", "pitch", "roll", "yaw")]
    expected += [(f"wheelset_{k}", motion) for k in range(1, 5) for motion in ("z", "roll", "yaw")]
    assert list(system.coordinates) == expected


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_physical_loads_carry_the_weight_and_its_moment(seed: int) -> None:
    """The eight wheels of an unsymmetric train balance its weight, and its moment about the first axle."""
    system, p = system_with(seed, heights=True, static_load="physical")
    first = p["l_b1"] + p["l_w1"]
    weights = {first: p["m_c"], p["l_w1"]: p["m_b1"], first + p["l_b2"]: p["m_b2"]}
    offsets = system.axle_offsets[system.wheel_axle]
    weight = sum(weights.values()) + 4 * p["m_w"]
    moment = sum(x * m for x, m in weights.items()) + p["m_w"] * float(system.axle_offsets.sum())
    assert system.wheel_load.sum() == pytest.approx(9.81 * weight, rel=1e-13)
    assert system.wheel_load @ offsets == pytest.approx(9.81 * moment, rel=1e-13)


def test_loads_of_the_paper_s_train() -> None:
    """Both readings of Eq. (13a), model.md Contact."""
    eight = np.full(8, (40000 + 2 * 2280 + 4 * 1901.8) * 9.81 / 8)
    assert build_system(paper("contact.static_load=physical")).wheel_load == pytest.approx(eight, rel=1e-14)
    doubled = np.full(8, (40000 + 2 * 2280 + 8 * 1901.8) * 9.81 / 4)
    assert build_system(paper()).wheel_load == pytest.approx(doubled, rel=1e-14)
