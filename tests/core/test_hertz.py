"""Hertz contact: wheelsets with mass on springs that may let go, through the code that users run."""

from __future__ import annotations

import numpy as np
import pytest

from tbi_cli.case import CaseError
from tbi_cli.case.messages import RunError
from tbi_cli.runner import plan_of
from tbi_cli.solve import Solver
from tbi_cli.timegrid import contact_rate
from tbi_cli.verify.references.rails import hertz_channels
from tests.core.crossings import Histories, histories, paper, tables

ALL = "output.histories=all"
HERTZ = "contact={model: hertz}"
EQUAL = "bridge.left={youngs_modulus: 207e9, second_moment: 0.2, mass_per_length: 20e3, damping: 1e4}"
WHEELS = [f"wheel_{axle}_{side}" for axle in range(1, 5) for side in ("right", "left")]
BOUNCING = "track.irregularity.dip={at: -30, length: 2, depth: 6 mm, rails: right}"


def limit(stiffness: float, mass: float) -> tuple[Histories, Histories]:
    """The same crossing with Hertz contact and with the paper's, wheelsets of this mass (kg).

    The static load is held: the car body weighs what is missing of the wheelsets.
    """
    wheelset = (
        f"train.wheelset.mass={mass}",
        f"train.wheelset.roll_inertia={0.36 * mass}",
        f"train.car_body.mass={40e3 + 4 * (1901.8 - mass)}",
    )
    common = (EQUAL, *wheelset, "velocity=50", "solver={sampling: 0.002, substeps: auto, duration: 1.5}", ALL)
    return (
        histories(paper(f"contact={{model: hertz, stiffness: {stiffness}}}", *common)),
        histories(paper("contact={model: paper, static_load: physical, convective: true}", *common)),
    )


def vertical(h: Histories) -> list[str]:
    """The channels that the limit is about."""
    return [n for n in h if n.endswith(("_y", "_pitch", "_midspan")) and np.any(h[n])]


def deviation(one: Histories, other: Histories, name: str) -> float:
    size: float = np.max(np.abs(other[name]))
    return float(np.max(np.abs(one[name] - other[name]))) / size


def test_the_paper_s_contact_is_the_limit() -> None:
    """k_H -> infinity, m_w and I_wx -> 0 with f_g held: y and pitch to 1e-3 of peak, and better ever after.

    What is left is proportional to the mass (of 40 kg, and of 20 kg) and to 1/k_H: half of it.
    """
    found = []
    for stiffness, mass in ((1e10, 40.0), (2e10, 20.0)):
        hertz, the_paper_s = limit(stiffness, mass)
        names = vertical(the_paper_s)
        assert len(names) == 12
        found.append(max(deviation(hertz, the_paper_s, name) for name in names))
    assert found[0] < 1e-3
    assert found[1] == pytest.approx(found[0] / 2, rel=0.2)


def test_roll_and_lateral_motion_have_another_limit() -> None:
    """The paper's free theta_wx cancels the primary roll stiffness (docs, theory of the contact).

    With unequal beams the bogies roll with the wheelsets' rails in one, and hang free in the other.
    """
    common = ("velocity=50", "solver={sampling: 0.002, substeps: auto, duration: 1.5}", ALL)
    light = ("train.wheelset.mass=20", "train.wheelset.roll_inertia=7")
    hertz = histories(paper("contact={model: hertz, stiffness: 2e10}", *light, *common))
    other = histories(
        paper("contact={model: paper, static_load: physical, convective: true}", *light, *common)
    )
    assert deviation(hertz, other, "front_bogie_roll") > 0.3
    # The wheelset of no inertia that carries no moment: both of its springs are stretched alike.
    force = other["wheel_1_right_force"] - other["wheel_1_left_force"]
    assert np.max(np.abs(force)) < 1e-2 * np.ptp(other["wheel_1_right_force"])


@pytest.mark.parametrize("velocity", [37.3, 77.7])
def test_peaks_where_axles_enter_inside_steps(velocity: float) -> None:
    """Automatic substeps at 0.5 ms against DOP853 with events, at the same samples.

    Displacements are good to 1e-5.  At 77.7 m/s the impact of the bridge's end lifts wheels off, and the
    kinks in their forces leave 3 % in the rolling of the wheelsets, which rings at 241 Hz; 0.5 % in forces.
    """
    case = paper(
        "contact={model: hertz, damping: 50e3}", f"velocity={velocity}",
        "solver={sampling: 0.0005, substeps: auto, duration: 0.8}", ALL,
    )  # fmt: skip
    ours = histories(case)
    theirs = hertz_channels(case.resolved(), ours["time"])
    for name in theirs:
        peak, other = (np.max(np.abs(h[name])) for h in (ours, theirs))
        sharp = 5e-3 if name.endswith(("_force", "_unloading")) else 3e-2
        smooth = name.endswith(("_y", "_z", "_pitch", "_roll", "_yaw", "_midspan"))
        assert peak == pytest.approx(other, rel=1e-5 if smooth else sharp), name


def test_fourth_order_while_wheels_touch() -> None:
    """Fitted slope of the error of a wheelset over a dip on the approach; no wheel lifts off, ends on steps.

    It bounces at 1213 rad/s: omega h is 0.6 to 0.15.
    """
    dip = "track={approach: 30, irregularity: {dip: {at: -25, length: 10, depth: 1 mm}}}"
    common = (HERTZ, dip, "velocity=50", "solver={sampling: 0.05, substeps: 100, duration: 0.1}", ALL)
    finest = histories(paper(*common, "solver.substeps=3200"))
    assert finest["wheel_1_right_time_aloft"][-1] == 0
    errors, counts = [], (100, 200, 400)
    for n in counts:
        h = histories(paper(*common, f"solver.substeps={n}"))
        before = h["time"] < 0
        errors.append(np.max(np.abs(h["wheelset_1_y"] - finest["wheelset_1_y"])[before]))
    assert -np.polyfit(np.log(counts), np.log(errors), 1)[0] > 3.7


def test_forces_of_all_wheels_carry_the_train() -> None:
    """Newton's law for the whole train at every sample, wheels in the air or not: to rounding."""
    h = histories(paper(HERTZ, BOUNCING, "velocity=60", "solver={sampling: 0.0005, duration: 0.7}", ALL))
    masses = {"car_body": 40e3, "front_bogie": 2280.0, "rear_bogie": 2280.0}
    masses |= {f"wheelset_{k}": 1901.8 for k in range(1, 5)}
    carried = sum(m * (9.81 + h[f"{body}_y_acceleration"]) for body, m in masses.items())
    total = sum(h[f"{wheel}_force"] for wheel in WHEELS)
    assert np.max(np.abs(total - carried)) < 1e-11 * np.max(carried)


def test_a_wheel_lifts_off_and_comes_back() -> None:
    """Force, unloading ratio and time aloft tell the same story."""
    case = paper(HERTZ, BOUNCING, "velocity=60", "solver={sampling: 0.0005, duration: 0.7}", ALL)
    h, table = histories(case), tables(case)
    for wheel in WHEELS:
        force, unloading, aloft = (h[f"{wheel}_{what}"] for what in ("force", "unloading", "time_aloft"))
        static = force[0]
        assert unloading == pytest.approx(1 - force / static, abs=1e-12)
        assert np.all(force >= 0)
        assert np.all(np.diff(aloft) >= 0)
        assert np.all(np.diff(aloft) <= 0.0005 * (1 + 1e-9))
        # Between two samples in the air, and hardly anywhere else, does the time aloft grow.
        steady = (force[:-1] == 0) & (force[1:] == 0)
        assert np.all(np.diff(aloft)[steady] > 0)
        assert aloft[-1] == pytest.approx(0.0005 * np.sum(force == 0), rel=0.2, abs=2e-3)
        assert table["min"][f"{wheel}_force"][0] == force.min()
        assert table["peak"][f"{wheel}_time_aloft"][0] == aloft[-1]
    assert h["wheel_1_right_time_aloft"][-1] > 0.01
    assert h["wheel_1_right_force"][-1] > 0


def test_a_train_at_rest_on_the_bridge() -> None:
    """At crawling speed the unsprung mass loads the beams too: the deflection is that of the axle loads.

    v/v_cr is 0.55 % at 0.5 m/s; what is left of the dynamics is at most that.  The wheelsets are 15 % of all.
    """
    case = paper(
        HERTZ,
        "velocity=0.5",
        "bridge.modes=1",
        "solver={sampling: 0.05, substeps: auto, duration: 1}",
    )
    result = Solver(case).solve([0])
    assert result is not None
    assert result.daf["right_static"][0] == pytest.approx(1.0, abs=5.5e-3)
    assert result.daf["left_static"][0] == pytest.approx(1.0, abs=5.5e-3)


def test_steps_follow_the_contact_springs() -> None:
    """The fastest motion is a wheelset's roll, sqrt(2 k b^2/I); 60 samples in its period, 0.15 rad a step."""
    omega = np.sqrt(2 * 1.4e9 * 0.75**2 / 685)
    solver = Solver(paper(HERTZ, "solver={sampling: auto, duration: 1}"))
    assert contact_rate(solver.scenarios.model(0).system) == pytest.approx(omega, rel=1e-12)
    assert solver.scenarios.crosser(0).grid.sampling == pytest.approx(2 * np.pi / omega / 60, rel=1e-12)
    coarse = Solver(paper(HERTZ, "solver={sampling: 0.01, duration: 1}")).scenarios.crosser(0).grid
    assert coarse.h * omega <= 0.15
    # Bounce, where the inertia is that of two wheels.
    heavy = Solver(paper(HERTZ, "train.wheelset.roll_inertia=2000"))
    expected = max(2 * 1.4e9 / 1901.8, 2 * 1.4e9 * 0.75**2 / 2000)
    assert contact_rate(heavy.scenarios.model(0).system) == pytest.approx(np.sqrt(expected), rel=1e-12)


def test_an_unstable_step_is_refused_before_the_run() -> None:
    """A wheelset rolls at 1516 rad/s on its contacts: stable up to 2.83/1516 = 1.87 ms, or a little more.

    The primary dampers make the little more.
    """
    with pytest.raises(RunError) as caught:
        plan_of(Solver(paper(HERTZ, "solver={sampling: 0.002, substeps: 1}")), np.ones(1, dtype=bool))
    assert str(caught.value) == (
        "--set solver={sampling: 0.002, substeps: 1}: solver.substeps: "
        "expected a stable step: at most 0.001893 s for this train and bridge, "
        "got 0.002 s (sampling 0.002 s in 1 substeps); use at least 2 substeps, or auto"
    )
    stable = paper(HERTZ, "solver={sampling: 0.0018, substeps: 1, duration: 1}")
    assert np.isfinite(tables(stable)["peak"]["car_body_y"]).all()


def test_mirror_left_to_right() -> None:
    """Beams and rails exchanged: forces change sides, roll changes its sign.

    Rounding enters in another order at the left wheels; where wheels bounce it grows.
    """
    right, left = (
        "{youngs_modulus: 207e9, second_moment: 0.2, mass_per_length: 20e3, damping: 1e4}",
        "{youngs_modulus: 200e9, second_moment: 0.2, mass_per_length: 18e3, damping: 1e4}",
    )
    common = (HERTZ, "velocity=60", "solver={sampling: 0.0005, duration: 0.7}", ALL)
    one = histories(paper(*common, BOUNCING))
    other = histories(
        paper(*common, BOUNCING.replace("right", "left"), f"bridge.right={left}", f"bridge.left={right}")
    )
    sides = {"right": "left", "left": "right"}
    for name, values in one.items():
        twin = other["_".join(sides.get(word, word) for word in name.split("_"))]
        odd = any(word in name.split("_") for word in ("z", "roll", "yaw"))
        assert np.max(np.abs(values - (-twin if odd else twin))) <= 1e-6 * np.max(np.abs(values)), name


def test_channels_are_those_of_thirty_one_coordinates() -> None:
    """Unloading and time aloft belong to this contact alone; everything else is there in both."""
    ours, paper_s = ({c.name: c for c in Solver(paper(*o)).channels} for o in ((HERTZ,), ()))
    extra = {f"{wheel}_{what}" for wheel in WHEELS for what in ("unloading", "time_aloft")}
    assert set(ours) == set(paper_s) | extra
    for name in extra:
        assert ours[name].in_tables
        assert ours[name].units == ("1" if name.endswith("unloading") else "s")
    assert len(Solver(paper(HERTZ)).scenarios.model(0).system.coordinates) == 31


@pytest.mark.parametrize(
    ("contact", "message"),
    [
        ("{model: hertz, static_load: paper}", "contact.static_load: expected physical, got paper"),
        ("{model: paper, stiffness: 1e9}", "contact.stiffness: only for the contact model hertz"),
        ("{model: hertz, stiffness: 0}", "contact.stiffness: expected a positive stiffness"),
    ],
)
def test_what_does_not_go_together(contact: str, message: str) -> None:
    with pytest.raises(CaseError, match=message):
        paper(f"contact={contact}")
