"""Corners of the rails and uneven points under moving wheels: met just where they are, in any step."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from numpy.typing import NDArray

from tbi_cli.verify.references.parameters import beam_from_mapping
from tbi_cli.verify.references.rail_shapes import rails_of
from tbi_cli.verify.references.rails import sprung_mass_on_rails
from tbi_cli.verify.references.simple_vehicles import SprungMass
from tests.core.crossings import Histories, case_from, histories, paper, tables
from tests.track.unsymmetric import unsymmetric

Array = NDArray[np.float64]
BEAM = {"youngs_modulus": 2.87e9, "second_moment": 2.9, "mass_per_length": 2303.0, "damping": 0.0}
VEHICLE = SprungMass(5750.0, 1595e3, 60e3)
SPAN, APPROACH, VELOCITY, SAMPLING = 25.0, 60.0, 25.0, 4e-3


def sprung_mass(
    folder: Path,
    irregularity: dict[str, Any],
    substeps: int,
    damping: float = VEHICLE.damping,
    **solver: float,
) -> Histories:
    """A sprung mass over these rails."""
    train = {"mass": VEHICLE.mass, "stiffness": VEHICLE.stiffness, "damping": damping}
    case = {
        "train": {"model": "sprung-mass", **train},
        "bridge": {"length": SPAN, "modes": 2, "right": BEAM},
        "velocity": VELOCITY,
        "track": {"approach": APPROACH, "irregularity": irregularity},
        "solver": {"sampling": SAMPLING, "substeps": substeps, "duration": 2.5, **solver},
        "output": {"histories": "all"},
    }
    return histories(case_from(yaml.safe_dump(case), folder))


def before_the_bridge(t: Array, irregularity: dict[str, Any], damping: float) -> Array:
    """y'' of the mass on rigid rails at times before 0, by the reference."""
    rail, _ = rails_of(irregularity, APPROACH, SPAN)
    vehicle = SprungMass(VEHICLE.mass, VEHICLE.stiffness, damping)
    reference = sprung_mass_on_rails(beam_from_mapping(BEAM, SPAN, 2), vehicle, VELOCITY, t, rail)
    return reference["sprung_mass_y_acceleration"]


EQUAL = "{youngs_modulus: 210 GPa, second_moment: 0.05, mass_per_length: 10 t/m, damping: 1e4}"
BUMP = (
    f"bridge={{length: 30 m, right: {EQUAL}, left: {EQUAL}}}",
    "velocity=40",
    "track.irregularity.half_sine={at: 5 m, length: 4 m, height: 1 mm}",
    "solver={sampling: 1e-4, duration: 1}",
)


@pytest.mark.parametrize(
    ("contact", "largest", "smallest"), [("hertz", 99_848, 30_146), ("paper", 65_477, 62_006)]
)
def test_a_dip_of_one_nanometre_changes_nothing(contact: str, largest: float, smallest: float) -> None:
    """Forces of a wheel over a bump of half a sine, 35 m behind a dip of next to nothing.

    The dip has 1e-6 of the bump's height, is twice as steep and has died away to less than a hundredth: of
    the force on the bump, 5e4 N, this is 1e-3 N.  The numbers are those of the bump's corners alone.
    """
    contact = f"contact={{model: {contact}, static_load: physical}}"
    dip = "track.irregularity.dip={at: -30 m, length: 3 m, depth: 1e-9 m}"
    found = [tables(paper(*BUMP, contact, *more)) for more in ((), (dip,))]
    for table, expected in (("max", largest), ("min", smallest)):
        alone, beside = (t[table]["wheel_1_right_force"][0] for t in found)
        assert alone == pytest.approx(expected, abs=1.0)
        assert beside == pytest.approx(alone, abs=1e-3)


@pytest.mark.parametrize("seed", range(2))
def test_rails_of_many_parts_against_an_independent_solution(seed: int, tmp_path: Path) -> None:
    """Before and on the bridge, in coarse steps, into which corners and points fall anywhere.

    A corner's impulse is right but up to h/3 too late or too soon: c J h/m (J 0.06 m/s at most) times h/3 is
    2e-6 m in steps of 4 ms, of a motion of 5 mm and by 16 corners and points; a 16th of it in steps of 1 ms.
    """
    irregularity = unsymmetric(seed, -38.0, 55.0)
    rail, _ = rails_of(irregularity, APPROACH, SPAN)
    coarse, fine = (sprung_mass(tmp_path, irregularity, substeps) for substeps in (1, 4))
    beam = beam_from_mapping(BEAM, SPAN, 2)
    t = coarse["time"]
    reference = sprung_mass_on_rails(beam, VEHICLE, VELOCITY, t, rail)
    away = np.minimum(np.abs(t), np.abs(t - SPAN / VELOCITY)) > 1e-9
    for name, bound in (("sprung_mass_y", 4e-4), ("sprung_mass_y_acceleration", 2e-3)):
        size = np.max(np.abs(reference[name]))
        for h, tolerance in ((coarse, bound), (fine, bound / 16)):
            assert np.max(np.abs(h[name] - reference[name])[away]) < tolerance * size, name


@pytest.mark.parametrize(
    ("damping", "ahead", "order"),
    [(60e3, 0.0, 3.7), (60e3, 0.37, 1.8), (60e3, 0.9, 1.8), (0.0, 0.37, 2.8), (0.0, 0.9, 2.8)],
)
def test_the_order_of_steps_over_corners(damping: float, ahead: float, order: float, tmp_path: Path) -> None:
    """Error behind a ramp that begins and ends so far inside of the steps: fitted slope over their length.

    None is lost to corners on steps.  Inside, a right impulse is out of place by up to h/3: c J h of a damper
    leaves the second order, k J h^2/2 of a spring the third.  Left to Runge-Kutta, one less of each.
    """
    counts = np.array([1, 2, 4])
    ramp = {"at": -40.0, "length": 10.0, "height": 3e-3}
    errors = []
    for n in counts:
        # The same share of a step ahead of the corner, whatever the step.
        here = {**ramp, "at": ramp["at"] + ahead * VELOCITY * SAMPLING / float(n)}
        h = sprung_mass(tmp_path, {"ramp": here}, int(n), damping, duration=0.1)
        t = h["time"][h["time"] < 0]
        expected = before_the_bridge(t, {"ramp": here}, damping)
        behind = t > -38.0 / VELOCITY
        errors.append(np.max(np.abs(h["sprung_mass_y_acceleration"][: len(t)] - expected)[behind]))
    assert -np.polyfit(np.log(counts), np.log(errors), 1)[0] > order


def test_the_first_place_of_a_step_is_behind_a_corner_and_the_last_before_it(tmp_path: Path) -> None:
    """A sample just at a corner has the slope ahead, and a force that has jumped by c v times the slope."""
    ramp = {"at": -40.0, "length": 10.0, "height": 3e-3}
    h = sprung_mass(tmp_path, {"ramp": ramp}, 4, duration=0.1)
    at = int(np.argmin(np.abs(h["time"] + 40.0 / VELOCITY)))
    jump = VEHICLE.damping * VELOCITY * ramp["height"] / ramp["length"] / VEHICLE.mass
    assert h["sprung_mass_y_acceleration"][at - 1] == 0.0
    assert h["sprung_mass_y_acceleration"][at] == pytest.approx(jump, rel=1e-6)


@pytest.mark.parametrize("contact", ["{model: paper, static_load: physical}", "{model: hertz, damping: 5e4}"])
def test_corners_of_the_other_rail_are_those_of_a_mirror(contact: str) -> None:
    """A ramp on one rail and a bump on the other, inside of steps, on equal beams: forces change sides.

    Rounding enters in another order at the left wheels.
    """
    ramp, bump = "{at: -7.0317, length: 2, height: 1 mm", "{at: -6.1043, length: 3, height: 1 mm"
    found = []
    for sides in (("right", "left"), ("left", "right")):
        irregularity = f"{{ramp: {ramp}, rails: {sides[0]}}}, half_sine: {bump}, rails: {sides[1]}}}}}"
        track = f"track={{approach: 8, irregularity: {irregularity}}}"
        solver = "solver={sampling: 0.001, substeps: 8, duration: 0.4}"
        found.append(
            histories(
                paper(BUMP[0], "velocity=40", track, solver, f"contact={contact}", "output.histories=all")
            )
        )
    one, other = found
    assert np.ptp(one["wheel_1_right_force"] - one["wheel_1_left_force"]) > 1e3
    for axle in range(1, 5):
        for side, mirrored in (("right", "left"), ("left", "right")):
            force, twin = one[f"wheel_{axle}_{side}_force"], other[f"wheel_{axle}_{mirrored}_force"]
            assert np.max(np.abs(force - twin)) < 1e-8 * np.max(np.abs(force))
