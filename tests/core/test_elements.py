"""The beams by their modes against the same beams in finite elements, which know of no mode."""

from __future__ import annotations

import numpy as np
import pytest

from tbi_cli.system.bridge import natural_frequencies
from tests.core.crossings import histories
from tests.core.elements import ElementBeam
from tests.core.random_cases import crossing, read


@pytest.mark.parametrize("seed", range(61, 65))
def test_frequencies_of_both_beams(seed: int) -> None:
    """Elements of 1/60 of the span are too stiff by (k h)^4/1440: 3.3e-6 for the fifth mode."""
    case = read(crossing(seed))
    for beam in (case.bridge.right, case.bridge.left):
        assert beam is not None
        stiffness = beam.youngs_modulus * beam.second_moment
        elements = ElementBeam(case.bridge.length, stiffness, beam.mass_per_length, 0.0)
        ours = natural_frequencies(case.bridge, beam)
        assert ours == pytest.approx(elements.frequencies(len(ours)), rel=4e-6)


@pytest.mark.parametrize(("seed", "most"), [(71, 4e4), (72, 4e4), (73, 4e5)])
def test_forces_on_elements(seed: int, most: float) -> None:
    """Deflection, bending moment and shear force of unequal forces, first and last off the beam as on it.

    Lightly damped, and so much (c in N s/m per m) that damping is a part of the shear force.

    Steps of 0.2 ms: the mean acceleration puts a mode off by (omega h)^2/12 of its phase, 1e-3 rad in a
    crossing for the first one, but a whole turn for the fifth, 25 times as fast: what vibrates freely of it
    is lost.  Of a deflection that is v/(v_c i^5), of a moment i^-3 and of a shear force i^-2: some 1e-5, 1e-3
    and, with all that are higher, 1e-2 of the largest value; times three at most, in single samples ten.
    """
    random = np.random.default_rng(seed)
    length, velocity, step = float(random.uniform(12, 30)), float(random.uniform(30, 80)), 2e-4
    EI, mu, c = random.uniform(2e9, 2e10), random.uniform(8e3, 2e4), random.uniform(most / 8, most)
    behind = np.concatenate([[0.0], np.cumsum(random.uniform(1.3, 0.6 * length, 4))])
    forces = random.uniform(4e4, 2e5, 5)
    node = int(random.integers(12, 49))
    place = node * length / 60
    right = {"youngs_modulus": 30e9, "second_moment": EI / 30e9, "mass_per_length": mu, "damping": c}
    bridge = {"length": length, "modes": 20, "stations": [place], "right": right}
    start = float(random.uniform(0, 9))
    case = {
        "train": {"model": "moving-load", "forces": forces.tolist(), "positions": (start + behind).tolist()},
        "bridge": {key: plain(value) for key, value in bridge.items()},
        "velocity": velocity,
        "solver": {"method": "exact", "sampling": step, "duration": 1.2},
        "output": {"histories": "all"},
    }
    h = histories(read(case))
    steps = len(h["time"]) - 1
    elements = ElementBeam(length, EI, mu, c)
    w, M, V = elements.crossing(forces, behind, velocity, step, steps, node)
    assert np.max(np.abs(h["right_station_1_deflection"] - w)) < 1e-3 * np.max(np.abs(w))
    assert np.max(np.abs(h["right_station_1_moment"] - M)) < 1e-2 * np.max(np.abs(M))
    # A force that passes within an element of the station stands on both of its sides in turn.
    away = np.min(np.abs(velocity * h["time"][:, None] - behind - place), axis=1) > length / 60
    off = (h["right_station_1_shear"] - V)[away]
    assert np.max(np.abs(off)) < 0.1 * np.max(np.abs(V))
    assert np.sqrt(np.mean(off**2)) < 0.02 * np.max(np.abs(V))


def plain(value: object) -> object:
    """Numbers as YAML has them."""
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    return float(value) if isinstance(value, np.floating) else value
