"""Trains of several vehicles: one car is that car, and many cost no more than each its share."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tbi_cli.batch import build_batch
from tbi_cli.case import Consist, load_case
from tbi_cli.solve import Solver
from tbi_cli.system.assembly import System, build_system, equal_coaches
from tbi_cli.timegrid import fastest_rate
from tbi_cli.verify.assembled import accelerations
from tbi_cli.verify.references.consist import consist_channels
from tests.core.crossings import case_from, histories, paper, tables
from tests.core.random_cases import crossing, full_train, read

ALL, EACH = "output.histories=all", "output.coaches=each"
OTHER = """{consist: [
  {vehicle: trains/paper.yaml, count: %s, spacing: 25 m},
  {vehicle: trains/zhai-passenger.yaml, count: 1, spacing: 24.6 m},
]}"""
SIMPLE = """
train: {consist: [%s]}
bridge:
  length: 30 m
  modes: 4
  right: {youngs_modulus: 30 GPa, second_moment: 2, mass_per_length: 12 t/m, damping: {ratio: 2 %%}}
velocity: 40
"""
SPRUNG = "{vehicle: {model: sprung-mass, mass: 8 t, stiffness: 2e6, damping: 2e4}, count: %d, spacing: %s}"
RIGID = (
    "{vehicle: {model: rigid-beam, mass: 30 t, pitch_inertia: 0.8e6, support_distance: 12, stiffness: 4e6,"
    " damping: 1e5}, spacing: 18}"
)
FORCES = "{vehicle: {model: moving-load, forces: [90 kN, 60 kN], positions: [0, 2]}, count: 2, spacing: 5}"


def train(text: str, *overrides: str) -> tuple[str, ...]:
    """What makes the paper's case that of another train."""
    return (f"train={text}", "contact.static_load=physical", *overrides)


WAVES = "track={approach: 20 m, irregularity: {harmonic: {amplitude: 1 mm, wavelength: 7 m}}}"


@pytest.mark.parametrize("contact", ["paper", "hertz"])
@pytest.mark.parametrize("track", ["track=null", WAVES], ids=["level", "waves"])
def test_a_train_of_one_car_has_the_bits_of_the_car(track: str, contact: str) -> None:
    one = "{consist: [{vehicle: trains/paper.yaml, spacing: 25 m}]}"
    common = (f"contact={{model: {contact}, static_load: physical}}", "solver.duration=1", track)
    alone, coupled = tables(paper(*common)), tables(paper(*train(one, EACH, *common)))
    for table, channels in alone.items():
        for name, values in channels.items():
            of_coach = name if name.startswith(("right_", "left_")) else f"coach_1_{name}"
            assert coupled[table][name].tobytes() == values.tobytes(), (table, name)
            assert coupled[table][of_coach].tobytes() == values.tobytes(), (table, name)


@pytest.mark.parametrize("convective", [False, True])
def test_cars_of_two_kinds_against_an_independent_solution(convective: bool) -> None:
    """Three cars at a speed at which axles enter and leave inside steps: limits as for one car's peaks.

    With the convective term a damper's force jumps there: a bogie's pitch is wrong by 2e-4 at steps of 1 ms,
    less by the square of the step, hence 8 of them.
    """
    cars = [{"vehicle": full_train(91), "count": 2, "front_overhang": 3.9, "rear_overhang": 1.7}]
    cars += [{"vehicle": full_train(92), "count": 1, "spacing": 26.1, "rear_overhang": 2.3}]
    case = crossing(
        93,
        raster=1e-3,
        velocity=77.7,
        contact={"convective": convective},
        solver={"substeps": 8, "duration": 1.0},
        output={"coaches": "each"},
    ) | {"train": {"consist": cars}}
    ours, peaks = histories(read(case)), tables(read(case))["peak"]
    theirs = consist_channels(case, ours["time"])
    checked = 0
    for name, values in theirs.items():
        if name in peaks and "wheelset" not in name and "wheel_" not in name:
            limit = 2e-4 if "acceleration" in name else 4e-5
            assert peaks[name][0] == pytest.approx(np.abs(values).max(), rel=limit), name
            checked += 1
    assert checked > 3 * 30
    for name in ("right_midspan", "coach_1_car_body_y", "coach_2_front_bogie_pitch", "coach_3_car_body_y"):
        size = np.abs(theirs[name]).max()
        assert np.abs(ours[name] - theirs[name]).max() < 1e-4 * size, name


def test_extremes_over_all_coaches() -> None:
    """What has no number is the largest peak with its time, maximum and RMS, the smallest minimum."""
    case = paper(*train(OTHER % 2, EACH, "solver.duration=1"))
    found = tables(case)
    names = [name.removeprefix("coach_1_") for name in found["peak"] if name.startswith("coach_1_")]
    assert len(names) > 60
    for name in names:
        own = {table: [values[f"coach_{k}_{name}"][0] for k in (1, 2, 3)] for table, values in found.items()}
        assert found["peak"][name][0] == max(own["peak"])
        assert found["max"][name][0] == max(own["max"])
        assert found["rms"][name][0] == max(own["rms"])
        assert found["min"][name][0] == min(own["min"])
        assert found["time_of_peak"][name][0] == own["time_of_peak"][int(np.argmax(own["peak"]))]


def test_tables_stay_small_unless_asked_for() -> None:
    """Without `coaches: each` the same numbers, less the coaches' own; a history of one may be kept."""
    kept = "output.histories={channels: [coach_3_car_body_y, right_midspan]}"
    few = Solver(paper(*train(OTHER % 2, kept)))
    assert not [channel.name for channel in few.tables if channel.name.startswith("coach_")]
    assert [channel.name for channel in few.histories] == ["coach_3_car_body_y", "right_midspan"]
    one, other = (tables(paper(*train(OTHER % 2, "solver.duration=1", *more))) for more in ((), (EACH,)))
    for table, channels in one.items():
        for name, values in channels.items():
            assert values.tobytes() == other[table][name].tobytes(), (table, name)


def test_the_number_of_coaches_as_an_axis() -> None:
    """Each point is the train of so many coaches, to the bit; coaches that it lacks are NaN."""
    swept = paper(*train(OTHER % 1, EACH, "solver.duration=1", "sweep={train.consist.0.count: [1, 3]}"))
    solver = Solver(swept)
    names = [channel.name for channel in solver.tables]
    assert "coach_4_car_body_y" in names and "coach_5_car_body_y" not in names
    for index, count in enumerate((1, 3)):
        result = solver.solve([index])
        assert result is not None
        alone = tables(paper(*train(OTHER % count, EACH, "solver.duration=1")))
        for table, values in result.tables.items():
            for k, name in enumerate(names):
                expected = alone[table].get(name, np.array([np.nan]))
                np.testing.assert_array_equal(values[0, k : k + 1], expected, (table, name))


def _counts(coaches: int) -> tuple[int, int, int, int]:
    """Terms of A, different numbers among them, terms of the wheels' rows and axles of a train."""
    text = f"{{consist: [{{vehicle: trains/paper.yaml, count: {coaches}, spacing: 25 m}}]}}"
    crosser = Solver(paper(*train(text))).scenarios.crosser(0)
    batch = build_batch([crosser], (), ())
    axles, different = len(batch.topology.axle_wheel_begin), len(batch.crossing.term)
    return len(batch.topology.term), different, len(batch.topology.wheel_col), axles


def test_cost_grows_with_the_number_of_coaches() -> None:
    """What a step goes through: so many times one car's terms, and those of the beams once."""
    beams = 2 * 2 * 4
    one, sixteen = _counts(1), _counts(16)
    assert sixteen[0] - beams == 16 * (one[0] - beams)
    assert sixteen[1] == one[1]
    assert sixteen[2:] == (16 * one[2], 16 * one[3])


def _largest_rate(system: System, velocity: float, time: float) -> float:
    """Largest |lambda| of the coupled equations with the train where it is at a time."""
    size = len(system.coordinates) + sum(len(beam.omega) for beam in system.beams)
    zero = np.zeros(size)
    free = accelerations(system, velocity, time, zero, zero)
    columns = [accelerations(system, velocity, time, unit, zero) - free for unit in np.eye(size)]
    rates = [accelerations(system, velocity, time, zero, unit) - free for unit in np.eye(size)]
    K, C = np.array(columns).T, np.array(rates).T
    return float(np.abs(np.linalg.eigvals(np.block([[zero[:, None] * K, np.eye(size)], [K, C]]))).max())


@pytest.mark.parametrize(
    "groups",
    [SPRUNG % (30, "0.3 m"), f"{SPRUNG % (3, '4 m')}, {RIGID}, {FORCES}", f"{RIGID}, {RIGID}, {RIGID}"],
)
def test_the_step_is_by_the_fastest_that_a_train_can_be(groups: str, tmp_path: Path) -> None:
    """An upper bound wherever the train is, however close its vehicles stand, by a factor of 1.5 at most."""
    system = build_system(case_from(SIMPLE % groups, tmp_path))
    way = system.length + system.axle_distance
    found = [_largest_rate(system, 40.0, t) for t in np.linspace(0.0, way / 40.0, 60)]
    assert max(found) <= fastest_rate(system) * (1 + 1e-9)
    assert fastest_rate(system) <= 1.5 * max(found)


def test_vehicles_that_stand_close_stiffen_a_soft_beam(tmp_path: Path) -> None:
    """A hundred sprung masses weigh on one mode more than its own stiffness does."""
    row = case_from(SIMPLE % (SPRUNG % (120, "0.3 m")), tmp_path, "bridge.modes=1")
    system = build_system(row)
    found = _largest_rate(system, 40.0, 33.0 / 40.0)
    assert found > 1.3 * float(system.beams[0].omega[0])
    assert found <= fastest_rate(system) * (1 + 1e-9)


def test_equal_vehicles_share_their_matrices(tmp_path: Path) -> None:
    """Also those of different groups; as many of them count as the bridge has room for at once."""
    case = load_case("paper", overrides=train("trains/crh380al-16.yaml"))
    system = build_system(case)
    assert len(system.coaches) == 16
    ((car, count),) = equal_coaches(system)
    assert all(coach.system is car for coach in system.coaches)
    # 50 m of bridge and 20 m of car: three cars 25 m apart stand there at a time; on 24 m two, not one.
    assert count == 3
    ((_, on_short),) = equal_coaches(
        build_system(load_case("paper", overrides=train("trains/crh380al-16.yaml", "bridge.length=24")))
    )
    assert on_short == 2
    ((_, close),) = equal_coaches(build_system(case_from(SIMPLE % (SPRUNG % (200, "0.3 m")), tmp_path)))
    assert close == 101


@pytest.mark.parametrize(
    ("name", "car", "pitch", "count", "noses"),
    [
        ("velaro-e-8", (0, 2.5, 17.375, 19.875), 24.775, 8, (3.51, 200.32)),
        ("crh380al-16", (0, 2.5, 17.5, 20), 25.0, 16, (4.0, 403.0)),
    ],
)
def test_the_shipped_trains(
    name: str, car: tuple[float, ...], pitch: float, count: int, noses: tuple[float, float]
) -> None:
    """The public axle lists: every car a pitch behind the one before, end cars too; noses stand out."""
    case = paper(*train(f"trains/{name}.yaml"))
    offsets = [pitch * k + x for k in range(count) for x in car]
    assert build_system(case).axle_offsets == pytest.approx(offsets, abs=1e-9)
    assert isinstance(case.train, Consist)
    first, last = case.train.consist[0], case.train.consist[-1]
    nose, length = noses
    assert (first.front_overhang, last.rear_overhang) == (nose, nose)
    assert offsets[-1] + 2 * nose == pytest.approx(length)
    assert sum(group.count * group.spacing for group in case.train.consist) == pytest.approx(length)


@pytest.mark.parametrize("seed", range(6))
def test_couplers_meet(seed: int) -> None:
    """Random cars, their places given in each of the ways: what is between axles is two overhangs."""
    draw = np.random.default_rng(seed)
    groups, axle, expected, behind = [], 0.0, [], 0.0
    for number in range(int(draw.integers(2, 6))):
        distance, count = round(draw.uniform(4, 18), 3), int(draw.integers(1, 4))
        front, rear = round(draw.uniform(0, 6), 3), round(draw.uniform(0.1, 6), 3)
        whole = f"spacing: {front + distance + rear!r}"
        ways = {
            "overhangs": f"front_overhang: {front}, rear_overhang: {rear}",
            "front": f"front_overhang: {front}, {whole}",
            "rear": f"rear_overhang: {rear}, {whole}",
            "all": f"front_overhang: {front}, rear_overhang: {rear}, {whole}",
            "middle": f"spacing: {distance + 2 * rear!r}",
        }
        way = str(draw.choice(list(ways)))
        front = rear if way == "middle" else front
        rigid = f"model: rigid-beam, mass: 30 t, pitch_inertia: 1e6, support_distance: {distance}"
        vehicle = f"{{{rigid}, stiffness: 4e6, damping: 0}}"
        groups.append(f"{{vehicle: {vehicle}, count: {count}, {ways[way]}}}")
        for k in range(count):
            axle = behind + front if number or k else 0.0
            expected += [axle, axle + distance]
            behind = axle + distance + rear
    case = load_case(
        "paper/verification-2",
        overrides=(f"train={{model: consist, consist: [{', '.join(groups)}]}}", "contact={model: paper}"),
    )
    assert build_system(case).axle_offsets == pytest.approx(expected, abs=1e-9)


def test_a_train_far_from_resonance_is_no_more_than_its_cars(tmp_path: Path) -> None:
    """A car that enters when the bridge has come to rest again, exp(-0.3 * 5.7 * 9), is like the first."""
    text = "{consist: [{vehicle: trains/paper.yaml, count: 2, spacing: 500 m}]}"
    damped = [f"bridge.{side}.damping={{ratio: 30 %}}" for side in ("right", "left")]
    found = tables(paper(*train(text, EACH, "velocity=50", "solver.duration=1", *damped)))["peak"]
    for name in ("car_body_y", "front_bogie_pitch", "wheelset_3_roll_acceleration", "wheel_2_left_force"):
        first, second = found[f"coach_1_{name}"][0], found[f"coach_2_{name}"][0]
        assert second == pytest.approx(first, rel=1e-5), name


def test_coaches_feel_the_rails_one_after_the_other() -> None:
    """On the approach the second car does what the first one did half a second before: 25 m at 50 m/s."""
    text = "{consist: [{vehicle: trains/paper.yaml, count: 2, spacing: 25 m}]}"
    waves = WAVES.replace("approach: 20 m", "approach: 120 m")
    h = histories(paper(*train(text, ALL, "velocity=50", "solver.duration=1", waves)))
    assert h["time"][0] == -2.4
    before = h["time"] < -1e-9
    for name in ("car_body_y", "front_bogie_pitch", "rear_bogie_y_acceleration", "rear_bogie_force"):
        first, second = h[f"coach_1_{name}"][before], h[f"coach_2_{name}"][before]
        # From the start the second stands on what the waves begin with, 1e-12 m; bodies move 3e-5 m.
        assert np.abs(second[500:] - first[:-500]).max() < 1e-7 * np.ptp(first), name
        assert np.ptp(first) > 0
