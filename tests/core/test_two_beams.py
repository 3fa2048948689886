"""Two beams that differ in everything: what belongs to one is never that of the other."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from tbi_cli.case import Case
from tbi_cli.solve import Solver
from tbi_cli.system.bridge import BeamModes
from tbi_cli.system.resonance import resonant_speeds
from tests.core.crossings import histories, paper, tables

Array = NDArray[np.float64]
LENGTH, MODES, VELOCITY = 31.0, 3, 47.0
# E (Pa), I (m4), mu (kg/m), damping ratio of every mode.
BEAMS = {"right": (207e9, 0.31, 20e3, 0.03), "left": (33e9, 1.3, 13e3, 0.008)}
PLACES = (0.0, 4.3, 11.0, 22.7, LENGTH)
TRAIN = (
    "train.geometry.bogie_distance=null",
    "train.geometry.wheelbase=null",
    *(
        f"train.geometry.l_{arm}={value}"
        for arm, value in (("b1", 9.1), ("b2", 7.6), ("w1", 1.1), ("w2", 1.4), ("w3", 1.6), ("w4", 0.9))
    ),
)
AXLES = np.array([0.0, 2.5, 16.2, 18.7])


def unequal(*overrides: str) -> Case:
    """The paper's train with arms of its own front and rear, on these beams."""
    beams = [
        f"bridge.{side}={{youngs_modulus: {E}, second_moment: {inertia}, mass_per_length: {mu}, "
        f"damping: {{ratio: {ratio}}}}}"
        for side, (E, inertia, mu, ratio) in BEAMS.items()
    ]
    span = (f"bridge.length={LENGTH}", f"bridge.modes={MODES}", f"bridge.stations={list(PLACES)}")
    return paper(*TRAIN, *beams, *span, f"velocity={VELOCITY}", *overrides)


def frequencies(side: str) -> Array:
    """Circular frequencies (rad/s) of the modes of a beam."""
    E, inertia, mu, _ = BEAMS[side]
    found: Array = (np.arange(1, MODES + 1) * np.pi / LENGTH) ** 2 * np.sqrt(E * inertia / mu)
    return found


def test_moment_and_shear_balance_the_forces_on_each_beam() -> None:
    """Newton's law for each beam, and for its part before each station, at every sample: to rounding.

    The forces are those of the wheels on their rails, which Hertz contact gives as they act on the beam, and
    mu (w'' + c/mu w') all along, of which three stations give the three modes.
    """
    irregular = "track={approach: 30, irregularity: {dip: {at: -5, length: 9, depth: 2 mm, rails: left}}}"
    solver = "solver={sampling: 0.001, substeps: auto, duration: 1}"
    h = histories(unequal("contact={model: hertz}", irregular, solver, "output.histories=all"))
    t = h["time"]
    xi = VELOCITY * t[None, :] - AXLES[:, None]
    on = (xi > 0) & (xi < LENGTH)
    order = np.arange(1, MODES + 1)
    middle = np.array(PLACES[1:-1])
    to_modes = np.linalg.inv(np.sin(np.outer(middle, order) * np.pi / LENGTH))
    for side, (_, _, mu, ratio) in BEAMS.items():
        rates, accelerations = (
            to_modes @ np.array([h[f"{side}_station_{k}_{what}"] for k in (2, 3, 4)])
            for what in ("velocity", "acceleration")
        )
        inertia = mu * (accelerations + 2 * ratio * frequencies(side)[:, None] * rates)
        forces = np.array([h[f"wheel_{axle}_{side}_force"] for axle in (1, 2, 3, 4)]) * on
        shear = {k: h[f"{side}_station_{k}_shear"] for k in range(1, 6)}
        away = np.min(np.abs(np.stack([xi, xi - LENGTH])), axis=(0, 1)) > 1e-6
        size = np.max(forces)
        whole = np.where(order % 2 == 1, 2 * LENGTH / (order * np.pi), 0.0)
        rest = shear[1] - shear[5] - forces.sum(axis=0) - whole @ inertia
        assert np.max(np.abs(rest)[away]) < 1e-10 * size, side
        for k, x in enumerate(middle, 2):
            wave = order * np.pi / LENGTH
            before, arm = (1 - np.cos(wave * x)) / wave, x / wave - np.sin(wave * x) / wave**2
            passed = (xi > 0) & (xi < x)
            clear = away & (np.min(np.abs(xi - x), axis=0) > 1e-6)
            pushed = (forces * passed).sum(axis=0) + before @ inertia
            assert np.max(np.abs(shear[1] - shear[k] - pushed)[clear]) < 1e-10 * size, (side, k)
            turned = (forces * passed * (x - xi)).sum(axis=0) + arm @ inertia
            moment = h[f"{side}_station_{k}_moment"]
            assert np.max(np.abs(shear[1] * x - moment - turned)[clear]) < 1e-10 * size * LENGTH, (side, k)


def test_amplification_of_each_beam_is_over_its_own_deflection() -> None:
    """F L^3/(48 EI) of the weight on one beam, section 3.6."""
    case = unequal("contact.static_load=physical", "solver.duration=1")
    result, peak = Solver(case).solve([0]), tables(case)["peak"]
    assert result is not None
    half = (40000 + 2 * 2280 + 4 * 1901.8) * 9.81 / 2
    for side, (E, inertia, _, _) in BEAMS.items():
        static = half * LENGTH**3 / (48 * E * inertia)
        assert result.daf[side][0] == pytest.approx(peak[f"{side}_midspan"][0] / static, rel=1e-12)


def test_each_beam_resonates_at_its_own_speeds() -> None:
    """v = f_j D/i of both beams, D from the first axle of an unsymmetric vehicle to its last."""
    found = {(side, j, i): speed for side, j, i, speed in resonant_speeds(unequal())}
    for side in BEAMS:
        for j, omega in enumerate(frequencies(side), 1):
            for i in (1, 2, 5):
                assert found[side, j, i] == pytest.approx(omega / (2 * np.pi) * AXLES[-1] / i, rel=1e-12)


def test_crawling_deflection_is_found_to_the_last_digits() -> None:
    """Unequal loads at uneven places, against a minimiser started from a scan of its own.

    At a maximum a place that is off by the root of rounding costs nothing.
    """
    random = np.random.default_rng(11)
    omega = frequencies("left")
    beam = BeamModes(LENGTH, 33e9 * 1.3, 13e3, omega, 0 * omega)
    for _ in range(12):
        offsets = np.append(0.0, np.cumsum(random.uniform(1.0, 9.0, 4)))
        loads = random.uniform(3e4, 2e5, 5)

        def upward(x: float, offsets: Array = offsets, loads: Array = loads) -> float:
            total = 0.0
            for load, at in zip(loads, x - offsets, strict=True):
                if 0 <= at <= LENGTH:
                    for j in (1, 3):
                        shape = np.sin(j * np.pi * at / LENGTH) * np.sin(j * np.pi / 2)
                        total += 2 * load * shape / (13e3 * LENGTH * omega[j - 1] ** 2)
            return -abs(total)

        scan = np.linspace(0.0, LENGTH + offsets[-1], 400)
        best = float(scan[int(np.argmin([upward(x) for x in scan]))])
        step = float(scan[1])
        found = minimize_scalar(
            upward, bounds=(best - step, best + step), method="bounded", options={"xatol": 1e-10}
        )
        assert beam.crawling_deflection(loads, offsets) == pytest.approx(-found.fun, rel=1e-12)
