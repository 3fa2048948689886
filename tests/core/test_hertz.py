"""Hertz contact: wheelsets with mass on springs that may let go, through the code that users run."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tbi_cli.case import CaseError
from tbi_cli.case.messages import RunError
from tbi_cli.runner import plan_of
from tbi_cli.solve import Solver
from tbi_cli.timegrid import contact_rate
from tbi_cli.verify.references.rails import hertz_channels
from tbi_cli.verify.references.scaling import mirror_sign, mirrored
from tests.core.crossings import Histories, histories, paper, tables
from tests.core.random_cases import crossing, masses, merged, read

HERTZ = "contact={model: hertz}"
WHEELS = [f"wheel_{axle}_{side}" for axle in range(1, 5) for side in ("right", "left")]
# What lifts wheels off: a dip in one rail, a bump in the other, both ahead of the bridge.
BOUNCING = {
    "contact": {"model": "hertz"},
    "velocity": 60.0,
    "track": {
        "approach": 50.0,
        "irregularity": {
            "dip": {"at": -30.0, "length": 2.0, "depth": 6e-3, "rails": "right"},
            "half_sine": {"at": -21.3, "length": 3.1, "height": 2e-3, "rails": "left"},
        },
    },
    "solver": {"sampling": 5e-4, "substeps": "auto", "duration": 0.7},
}
ARM = "primary_half_spacing"
COARSE = {"sampling": 2e-3, "substeps": "auto", "duration": 1.5}


def limit(
    seed: int, stiffness: float, mass: float, alike: bool
) -> tuple[dict[str, Any], tuple[Histories, Histories]]:
    """A case, and the same crossing with Hertz contact and with the paper's, wheelsets of this mass (kg).

    alike: both beams are the right one.
    """
    wheelset = {"mass": mass, "roll_inertia": 0.36 * mass}
    case = crossing(seed, raster=0.1, velocity=50.0, train={"wheelset": wheelset}, solver=COARSE)
    if alike:
        case["bridge"] |= {"left": case["bridge"]["right"]}
    the_paper_s = {"model": "paper", "static_load": "physical", "convective": True}
    hertz = case | {"contact": {"model": "hertz", "stiffness": stiffness}}
    return case, (histories(read(hertz)), histories(read(case | {"contact": the_paper_s})))


def vertical(h: Histories) -> list[str]:
    """The channels that the limit is about."""
    return [n for n in h if n.endswith(("_y", "_pitch", "_midspan")) and np.any(h[n])]


def deviation(one: Histories, other: Histories, name: str) -> float:
    size: float = np.max(np.abs(other[name]))
    return float(np.max(np.abs(one[name] - other[name]))) / size


def test_the_paper_s_contact_is_the_limit() -> None:
    """k_H -> infinity, m_w and I_wx -> 0: y and pitch to 1e-3 of peak, and better ever after.

    What is left is proportional to the mass (of 40 kg, and of 20 kg) and to 1/k_H: half of it.  On equal
    beams, for roll has another limit; front and rear differ.
    """
    found = []
    for stiffness, mass in ((1e10, 40.0), (2e10, 20.0)):
        _, (hertz, the_paper_s) = limit(21, stiffness, mass, alike=True)
        names = vertical(the_paper_s)
        assert len(names) == 12
        found.append(max(deviation(hertz, the_paper_s, name) for name in names))
    assert found[0] < 1e-3
    assert found[1] == pytest.approx(found[0] / 2, rel=0.2)


def test_roll_and_lateral_motion_have_another_limit() -> None:
    """The paper's free theta_wx cancels the primary roll stiffness (docs, theory of the contact).

    With unequal beams the bogies roll with the wheelsets' rails in one, and hang free in the other.
    """
    case, (hertz, other) = limit(22, 2e10, 20.0, alike=False)
    assert deviation(hertz, other, "front_bogie_roll") > 0.3
    # Eq. (29): what the springs of a wheelset do not have in common turns it, and next to nothing is enough.
    inertia, arm = (case["train"][at][key] for at, key in (("wheelset", "roll_inertia"), ("geometry", ARM)))
    for axle in range(1, 5):
        right, left = (other[f"wheel_{axle}_{side}_force"] for side in ("right", "left"))
        turned = inertia * other[f"wheelset_{axle}_roll_acceleration"]
        assert np.max(np.abs((right - left) * arm - turned)) < 1e-10 * np.max(right) * arm
        assert np.max(np.abs(right - left)) < 0.1 * np.ptp(right)


@pytest.mark.parametrize(("seed", "velocity"), [(23, 37.3), (24, 77.7)])
def test_peaks_where_axles_enter_inside_steps(seed: int, velocity: float) -> None:
    """Automatic substeps at 0.5 ms against DOP853 with events, at the same samples.

    Displacements are good to 1e-5.  At 77.7 m/s the impact of the bridge's end lifts wheels off, and the
    kinks in their forces leave 3 % in the rolling of the wheelsets, which rings at 241 Hz; 0.5 % in forces.
    """
    case = crossing(
        seed,
        raster=1e-3,
        velocity=velocity,
        contact={"model": "hertz", "damping": 50e3},
        solver={"sampling": 5e-4, "substeps": "auto", "duration": 0.8},
    )
    ours = histories(read(case))
    theirs = hertz_channels(case, ours["time"])
    for name in theirs:
        peak, other = (np.max(np.abs(h[name])) for h in (ours, theirs))
        sharp = 5e-3 if name.endswith(("_force", "_unloading")) else 3e-2
        smooth = name.endswith(("_y", "_z", "_pitch", "_roll", "_yaw", "_midspan"))
        assert peak == pytest.approx(other, rel=1e-5 if smooth else sharp), name


def test_fourth_order_while_wheels_touch() -> None:
    """Fitted slope of the error of wheelsets over a dip on the approach; no wheel lifts off, ends on steps.

    They bounce at 1200 to 1700 rad/s: omega h is 0.4 to 0.1.
    """
    dip = {"dip": {"at": -25.0, "length": 10.0, "depth": 1e-3}, "half_sine": {"at": -20.0, "length": 10.0}}
    dip["half_sine"] |= {"height": 0.5e-3, "rails": "left"}
    case = crossing(
        25,
        velocity=50.0,
        contact={"model": "hertz"},
        track={"approach": 30.0, "irregularity": dip},
        solver={"sampling": 0.05, "duration": 0.1},
    )
    finest = histories(read(case, "solver.substeps=3200"))
    counts = (200, 400, 800)
    runs = [histories(read(case, f"solver.substeps={n}")) for n in counts]
    before = finest["time"] < 0
    assert all(finest[f"{wheel}_time_aloft"][before][-1] == 0 for wheel in WHEELS)
    for name in ("wheelset_1_y", "wheelset_4_y", "wheelset_2_roll"):
        errors = [np.max(np.abs(h[name] - finest[name])[before]) for h in runs]
        assert -np.polyfit(np.log(counts), np.log(errors), 1)[0] > 3.7, name


@pytest.fixture(scope="module")
def bouncing() -> tuple[dict[str, Any], Histories]:
    """A train whose wheels lift off, and its histories."""
    case = crossing(26, raster=1e-3, **BOUNCING)
    return case, histories(read(case))


def test_forces_of_all_wheels_carry_the_train(bouncing: tuple[dict[str, Any], Histories]) -> None:
    """Newton's law for the whole train at every sample, wheels in the air or not: to rounding."""
    case, h = bouncing
    carried = sum(m * (9.81 + h[f"{body}_y_acceleration"]) for body, m in masses(case).items())
    total = sum(h[f"{wheel}_force"] for wheel in WHEELS)
    assert np.max(np.abs(total - carried)) < 1e-11 * np.max(carried)


def test_a_wheel_lifts_off_and_comes_back(bouncing: tuple[dict[str, Any], Histories]) -> None:
    """Force, unloading ratio and time aloft tell the same story."""
    case, h = bouncing
    table = tables(read(case))
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
    case = read(
        crossing(
            27,
            velocity=0.5,
            contact={"model": "hertz"},
            bridge={"modes": 1},
            solver={"sampling": 0.05, "substeps": "auto", "duration": 1.0},
            output={"histories": "none"},
        )
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


def test_mirror_left_to_right(bouncing: tuple[dict[str, Any], Histories]) -> None:
    """Beams and rails exchanged: forces change sides, roll changes its sign.

    Rounding enters in another order at the left wheels; where wheels bounce it grows.
    """
    case, one = bouncing
    rails = {"dip": {"rails": "left"}, "half_sine": {"rails": "right"}}
    other = histories(read(merged(mirrored(case), {"track": {"irregularity": rails}})))
    for name in one.keys() - {"time"}:
        image, sign = mirror_sign(name)
        assert np.max(np.abs(other[image] - sign * one[name])) <= 1e-6 * np.max(np.abs(one[name])), name


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
