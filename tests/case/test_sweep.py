# ruff: noqa: E501 - messages are never wrapped, here neither.
"""The sweep of a case file: which values its axes have, and what is wrong with one."""

from __future__ import annotations

import itertools
import math

import pytest

from tbi_cli.case import Axis, Case, ExtraAxis, load_case

from .conftest import CASE, Loads, Says


def axis(case: Case) -> Axis:
    (only,) = case.axes
    return only


def sweep(text: str) -> str:
    return f"{CASE}sweep:\n  {text}\n"


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("velocity: [10, 20 m/s, 108 km/h]", (10.0, 20.0, 30.0)),
        ("velocity: {from: 1, to: 2, step: 0.25}", (1.0, 1.25, 1.5, 1.75, 2.0)),
        ("velocity: {from: 1, to: 2.1, step: 0.5}", (1.0, 1.5, 2.0)),
        ("velocity: {from: 3, to: 1, step: -1}", (3.0, 2.0, 1.0)),
        ("velocity: {from: 5, to: 5, step: 1}", (5.0,)),
        ("velocity: {from: 36 km/h, to: 72 km/h, step: 18 km/h}", (10.0, 15.0, 20.0)),
        ("velocity: {from: 1, to: 3, count: 5}", (1.0, 1.5, 2.0, 2.5, 3.0)),
        ("velocity: {from: 1, to: 3, count: 1}", (1.0,)),
        ("modes: {from: 1, to: 4, step: 1}", (1.0, 2.0, 3.0, 4.0)),
        ("modes: {from: 4, to: 1, step: -1}", (4.0, 3.0, 2.0, 1.0)),
        ("modes: [4, 8]", (4.0, 8.0)),
    ],
)
def test_values(loads: Loads, text: str, values: tuple[float, ...]) -> None:
    assert axis(loads(sweep(text))).values == values


def test_the_papers_velocities(loads: Loads) -> None:
    values = axis(loads(sweep("velocity: {from: 2, to: 200, step: 0.5}"))).values
    assert values == tuple(2 + 0.5 * i for i in range(397))
    assert values[-1] == 200


def test_logarithmic_values_have_one_ratio(loads: Loads) -> None:
    values = axis(loads(sweep("velocity: {log: {from: 1, to: 100, count: 5}}"))).values
    assert values[0] == 1
    assert values[-1] == 100
    # Each is rounded once, and their quotient once more.
    assert [b / a for a, b in itertools.pairwise(values)] == pytest.approx([math.sqrt(10)] * 4, rel=1e-14)


@pytest.mark.parametrize(
    ("key", "name", "paths", "units", "whole"),
    [
        ("velocity", "velocity", ("velocity",), "m/s", False),
        ("car_body_mass", "car_body_mass", ("train.car_body.mass",), "kg", False),
        ("span", "span", ("bridge.length",), "m", False),
        ("damping", "damping", ("bridge.right.damping", "bridge.left.damping"), "N s/m^2", False),
        ("modes", "modes", ("bridge.modes",), "1", True),
        ("sampling", "sampling", ("solver.sampling",), "s", False),
        ("train.car_body.mass", "train_car_body_mass", ("train.car_body.mass",), "kg", False),
        ("solver.substeps", "solver_substeps", ("solver.substeps",), "1", True),
        ("bridge.right.damping", "bridge_right_damping", ("bridge.right.damping",), "N s/m^2", False),
        ("train.front_bogie.mass", "train_front_bogie_mass", ("train.front_bogie.mass",), "kg", False),
    ],
)
def test_axes_are_named_as_in_the_file(
    loads: Loads, key: str, name: str, paths: tuple[str, ...], units: str, whole: bool
) -> None:
    found = axis(loads(sweep(f"{key}: [1]")))
    assert (found.key, found.name, found.paths, found.units, found.whole) == (key, name, paths, units, whole)


def test_axes_come_in_the_order_of_the_file(loads: Loads) -> None:
    case = loads(sweep("span: [30, 40]\n  velocity: [1, 2, 3]\n  modes: [1]"))
    assert [found.name for found in case.axes] == ["span", "velocity", "modes"]


def test_one_point_of_the_grid(loads: Loads) -> None:
    case = loads(
        sweep("car_body_mass: [20 t, 40 t]\n  damping: [1e3]\n  modes: [2, 3]\n  sampling: [0.2, 0.1]")
    )
    point = case.at({"car_body_mass": 20e3, "damping": 1e3, "modes": 3.0, "sampling": 0.2})
    assert point.axes == ()
    assert point.train.car_body.mass == 20e3  # type: ignore[union-attr]
    assert (point.bridge.right.damping.value, point.bridge.left.damping.value) == (1e3, 1e3)  # type: ignore[union-attr]
    assert point.bridge.modes == 3
    assert type(point.bridge.modes) is int
    assert point.solver.sampling == 0.2
    assert case.train.car_body.mass == 40e3  # type: ignore[union-attr]


def test_a_point_is_the_case_with_its_values_written_in(loads: Loads) -> None:
    grid = loads(
        sweep(
            "span: [30, 40]\n  train.geometry.l_b1: [8, 9]\n  train.front_bogie.primary.vertical.damping: [1e3]"
        )
    )
    point = grid.at(
        {"span": 40.0, "train_geometry_l_b1": 9.0, "train_front_bogie_primary_vertical_damping": 1e3}
    )
    written = ["bridge.length=40", "train.geometry.l_b1=9", "train.front_bogie.primary.vertical.damping=1e3"]
    assert point == loads(CASE, overrides=written)
    assert point.train.front_bogie.primary.vertical.damping == 1e3  # type: ignore[union-attr]
    assert point.train.rear_bogie.primary.vertical.damping == 29.6e3  # type: ignore[union-attr]
    assert (point.train.geometry.l_b1, point.train.geometry.l_b2) == (9.0, 8.5)  # type: ignore[union-attr]


def test_an_unknown_axis_name_is_a_key_error(loads: Loads) -> None:
    with pytest.raises(KeyError):
        loads(sweep("span: [30]")).at({"velocity": 5.0})


def test_a_swept_key_may_be_left_out_of_the_file(loads: Loads) -> None:
    assert loads(sweep("velocity: [7, 8]").replace("velocity: 300 km/h\n", "")).velocity == 7


@pytest.mark.parametrize(
    ("form", "value", "units"),
    [("ratio", "1 %", "1"), ("first_mode_ratio", "2 %", "1"), ("coefficient", "5e3", "N s/m^2")],
)
def test_the_damping_axis_keeps_the_form_given(loads: Loads, form: str, value: str, units: str) -> None:
    text = sweep(f"damping: [{value}]").replace("damping: 10 kN*s/m^2", f"damping: {{{form}: {value}}}")
    case = loads(text)
    assert axis(case).units == units
    point = case.at({"damping": 0.125})
    for beam in (point.bridge.right, point.bridge.left):
        assert beam is not None
        assert (beam.damping.form, beam.damping.value) == (form, 0.125)


def test_the_damping_axis_of_a_single_beam(loads: Loads) -> None:
    text = "train: {model: moving-load, forces: [1 kN]}\nbridge: verification-1\nvelocity: 9\nsweep: {damping: [0, 1]}\n"
    assert axis(loads(text)).paths == ("bridge.right.damping",)


def test_a_force_of_a_moving_load_can_be_swept(loads: Loads) -> None:
    text = (
        "train: {model: moving-load, forces: [1 kN, 2 kN], positions: [0, 3]}\nbridge: verification-1\nvelocity: 9\n"
        "sweep: {train.forces.1: [5, 6]}\n"
    )
    assert loads(text).at({"train_forces_1": 6.0}).train.forces == (1e3, 6.0)  # type: ignore[union-attr]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("velocity: []", "case.yaml:13:3: sweep.velocity: expected at least one value, got an empty list"),
        (
            "velocity: 5",
            "case.yaml:13:3: sweep.velocity: expected a list of values, {from, to, step}, {from, to, count} or {log: {from, to, count}}, got 5",
        ),
        (
            "velocity: {}",
            "case.yaml:13:3: sweep.velocity: expected a list of values, {from, to, step}, {from, to, count} or {log: {from, to, count}}, got an empty mapping",
        ),
        (
            "velocity: {from: 1, to: 2}",
            "case.yaml:13:3: sweep.velocity: expected {from, to, step}, {from, to, count} or {log: {from, to, count}}, got {from, to}",
        ),
        (
            "velocity: {from: 1, to: 2, stop: 1}",
            "case.yaml:13:30: sweep.velocity.stop: unknown key; did you mean step?",
        ),
        (
            "velocity: [36 km/h, 10]",
            "case.yaml:13:23: sweep.velocity: 10 is given twice, as value 1 and value 2",
        ),
        (
            "car_body_mass: [20 t, -1]",
            'case.yaml:13:25: sweep.car_body_mass: expected a positive mass, e.g. "40 t" or 40000, got -1',
        ),
        (
            "sampling: [auto]",
            'case.yaml:13:14: sweep.sampling: expected a positive time, e.g. "0.001 s" or 0.001, got "auto"',
        ),
        (
            "velocity: {from: -1, to: 2, step: 1}",
            'case.yaml:13:14: sweep.velocity.from: expected a positive speed, e.g. "300 km/h" or 83.3333, got -1',
        ),
        (
            "velocity: {from: 1, to: 2, step: 0}",
            "case.yaml:13:30: sweep.velocity.step: expected a step other than 0",
        ),
        (
            "velocity: {from: 1, to: 2, step: -1}",
            "case.yaml:13:30: sweep.velocity.step: expected a positive step to go from 1 to 2, got -1",
        ),
        (
            "velocity: {from: 1, to: 2, step: 1 kg}",
            'case.yaml:13:30: sweep.velocity.step: expected a speed, e.g. "300 km/h" or 83.3333, got "1 kg" ("kg" is a mass)',
        ),
        (
            "velocity: {from: 1, to: 2, step: 1e-9}",
            "case.yaml:13:30: sweep.velocity.step: expected at most 500000 values in all axes together, got 1e+09",
        ),
        (
            "velocity: {from: 1, to: 2, step: 1e-15}",
            "case.yaml:13:30: sweep.velocity.step: expected at most 500000 values in all axes together, got 1e+15",
        ),
        (
            "velocity: {from: 1, to: 2, count: 0}",
            "case.yaml:13:30: sweep.velocity.count: expected a whole number from 1 to 500000, got 0",
        ),
        (
            "velocity: {from: 1, to: 2, count: 1e30}",
            "case.yaml:13:30: sweep.velocity.count: expected a whole number from 1 to 500000, got 1e30",
        ),
        (
            "velocity: {from: 1, to: 1, count: 2}",
            "case.yaml:13:30: sweep.velocity.count: the values are not all different",
        ),
        (
            "modes: {from: 1, to: 4, count: 3}",
            "case.yaml:13:27: sweep.modes.count: expected whole numbers only, got 2.5",
        ),
        ("modes: [1.5]", "case.yaml:13:11: sweep.modes: expected a whole number from 1 to 20, got 1.5"),
        (
            "train.geometry.bogie_to_axle: {log: {from: -1, to: 1, count: 3}}",
            "case.yaml:13:40: sweep.train.geometry.bogie_to_axle.log.from: expected a positive number, got -1",
        ),
        ("velocity: {log: 5}", "case.yaml:13:14: sweep.velocity.log: expected {from, to, count}"),
        ("spam: [1]", "case.yaml:13:3: sweep.spam: no such key; did you mean span?"),
        (
            "youngs_modulus: [1]",
            "case.yaml:13:3: sweep.youngs_modulus: no such key; did you mean bridge.right.youngs_modulus?",
        ),
        (
            "quux: [1]",
            "case.yaml:13:3: sweep.quux: no such key; expected one of velocity, car_body_mass, span, damping, modes, sampling, seed, or a key such as bridge.right.youngs_modulus",
        ),
        ("title: [1]", "case.yaml:13:3: sweep.title: not a key with a number, so it cannot be swept"),
        (
            "bridge.right: [1]",
            "case.yaml:13:3: sweep.bridge.right: not a key with a number, so it cannot be swept",
        ),
        (
            "solver.method: [1]",
            "case.yaml:13:3: sweep.solver.method: not a key with a number, so it cannot be swept",
        ),
        (
            "train.geometry.l_b1: [8, 18]",
            "case.yaml:13:3: sweep.train.geometry.l_b1: expected l_b1 smaller than bogie_distance = 17.5, got 18",
        ),
        (
            "span: [30]\n  bridge.length: [40]",
            "case.yaml:14:3: sweep.bridge.length: sets the same key as the axis span",
        ),
        (
            "velocity: {from: 1, to: 9, count: 400000}\n  span: {from: 30, to: 60, count: 200000}",
            "case.yaml:14:28: sweep.span.count: expected at most 500000 values in all axes together, got 200000 after the 400000 before",
        ),
    ],
)
def test_what_is_wrong_with_an_axis(says: Says, text: str, message: str) -> None:
    assert says(sweep(text)).splitlines()[0] == message


def test_every_wrong_value_of_an_axis_is_named(says: Says) -> None:
    message = says(sweep("velocity: [1, -2, 3, fast]\n  span: {from: -1, to: x, step: 1}"))
    assert [line.split(": ")[0] for line in message.splitlines() if "case.yaml" in line] == [
        "case.yaml:13:17",
        "case.yaml:13:24",
        "case.yaml:14:10",
        "case.yaml:14:20",
    ]


def test_a_sweep_that_is_no_mapping(says: Says) -> None:
    assert says(f"{CASE}sweep: [velocity]\n").splitlines()[0] == (
        "case.yaml:12:1: sweep: expected a mapping of axes such as {velocity: {from: 2, to: 200, step: 0.5}}, got a list"
    )


def test_a_grid_that_is_too_large(says: Says) -> None:
    keys = ("velocity", "span", "gravity", "solver.duration")
    text = "\n  ".join(f"{key}: {{from: 1, to: 9, count: 10000}}" for key in keys)
    assert (
        says(sweep(text)).splitlines()[0]
        == "case.yaml:12:1: sweep: expected a grid of at most 1e12 cases, got 1e+16"
    )


def test_beams_damped_in_different_forms_have_no_common_axis(says: Says) -> None:
    text = sweep("damping: [1e3]").replace("    damping: 10 kN*s/m^2\n", "    damping: {ratio: 1 %}\n")
    assert says(text).splitlines()[0] == (
        "case.yaml:13:3: sweep.damping: the two beams give their damping in different forms, so that one axis cannot set both"
    )


def test_a_simple_train_has_no_car_body(says: Says) -> None:
    text = (
        "train: {model: sprung-mass, mass: 5, stiffness: 1e6, damping: 0}\nbridge: verification-1\nvelocity: 9\n"
        "sweep: {car_body_mass: [5, 6]}\n"
    )
    assert (
        says(text).splitlines()[0]
        == "case.yaml:4:9: sweep.car_body_mass: a sprung-mass train has no train.car_body.mass"
    )


class TestExtraAxis:
    """The axis that `tbi sweep AXIS` adds."""

    def test_velocity_has_the_papers_range(self) -> None:
        values = axis(load_case(extra_axis=ExtraAxis("velocity"))).values
        assert (len(values), values[0], values[-1]) == (397, 2.0, 200.0)

    def test_it_comes_after_those_of_the_file(self) -> None:
        case = load_case("paper/masses", extra_axis=ExtraAxis("span", values="30 m, 40 m"))
        assert [(a.name, a.values) for a in case.axes][1:] == [("span", (30.0, 40.0))]

    def test_it_replaces_the_same_one_where_that_stood(self) -> None:
        extra = ExtraAxis("velocity", start="36 km/h", stop=20, step="5")
        case = load_case("paper/sampling", extra_axis=extra)
        assert [a.name for a in case.axes] == ["velocity", "sampling"]
        assert case.axes[0].values == (10.0, 15.0, 20.0)

    def test_it_replaces_the_same_key_under_another_name(self) -> None:
        case = load_case("paper/masses", extra_axis=ExtraAxis("train.car_body.mass", values=[1e4, 2e4]))
        assert [a.name for a in case.axes] == ["train_car_body_mass"]

    @pytest.mark.parametrize(
        ("extra", "message"),
        [
            (
                ExtraAxis("span"),
                "sweep span: missing --from, --to, --step; expected --from, --to and --step, or --values",
            ),
            (
                ExtraAxis("velocity", start=2),
                "sweep velocity: missing --to, --step; expected --from, --to and --step, or --values",
            ),
            (
                ExtraAxis("span", start=2, values="3"),
                "sweep span: expected --values or --from, --to and --step, got both",
            ),
            (
                ExtraAxis("span", values=""),
                "sweep span: sweep.span: expected at least one value, got an empty list",
            ),
            (
                ExtraAxis("span", values="30, x"),
                'sweep span: sweep.span: expected a positive length, e.g. "50 m" or 50, got "x"',
            ),
            (
                ExtraAxis("spam", values="30"),
                "sweep spam: sweep.spam: no such key; did you mean span?",
            ),
        ],
    )
    def test_what_is_wrong_with_it(self, says: Says, extra: ExtraAxis, message: str) -> None:
        assert says(CASE, extra_axis=extra) == message


class TestZip:
    """Axes that move together."""

    def test_members_share_one_axis_in_the_place_of_the_first(self, loads: Loads) -> None:
        case = loads(
            sweep("velocity: [10, 20, 10]\n  modes: [1, 2]\n  span: [30, 40, 50]\n  zip: [velocity, span]")
        )
        assert [(a.name, a.values, a.units) for a in case.axes] == [
            ("velocity_and_span", (0.0, 1.0, 2.0), "1"),
            ("modes", (1.0, 2.0), "1"),
        ]
        point = case.at({"velocity_and_span": 2.0, "modes": 1.0})
        assert (point.velocity, point.bridge.length, point.bridge.modes) == (10.0, 50.0, 1)

    def test_several_groups(self, loads: Loads) -> None:
        text = "velocity: [1, 2]\n  span: [3, 4]\n  modes: [5, 6]\n  gravity: [9, 10]\n  zip: [[velocity, modes], [span, gravity]]"
        assert [a.name for a in loads(sweep(text)).axes] == ["velocity_and_modes", "span_and_gravity"]

    @pytest.mark.parametrize(
        ("text", "message"),
        [
            (
                "zip: [velocity, span]",
                'case.yaml:13:3: sweep.zip: "velocity" is not an axis of this sweep; nothing is known here',
            ),
            (
                "velocity: [1, 2]\n  span: [3]\n  zip: [velocity, span]",
                "case.yaml:15:3: sweep.zip: expected axes with the same number of values, but velocity has 2, span has 1",
            ),
            (
                "velocity: [1, 1]\n  span: [3, 3]\n  zip: [velocity, span]",
                "case.yaml:15:3: sweep.zip: the values of velocity, span are together not all different",
            ),
            (
                "velocity: [1, 2]\n  zip: [velocity, velocity]",
                'case.yaml:14:3: sweep.zip: "velocity" stands there twice',
            ),
            (
                "velocity: [1, 2]\n  zip: velocity",
                'case.yaml:14:3: sweep.zip: expected a list of two or more axes that move together, or a list of such lists, got "velocity"',
            ),
            (
                "velocity: [1, 2]\n  span: [3, 4]\n  zip: [velocity, spam]",
                'case.yaml:15:3: sweep.zip: "spam" is not an axis of this sweep; did you mean span?',
            ),
        ],
    )
    def test_what_is_wrong_with_it(self, says: Says, text: str, message: str) -> None:
        assert says(sweep(text)).splitlines()[0] == message


SAMPLE = """\
sample:
    kind: {kind}
    count: 100
    seed: {seed}
    over:
      velocity: {{normal: [80, 10], within: [70, 95]}}
      car_body_mass: {{uniform: [30 t, 50 t]}}
      damping: {{loguniform: [1e3, 1e4]}}
      span: {{triangular: [30, 40, 60]}}
"""


class TestSample:
    """Random designs."""

    @pytest.mark.parametrize("kind", ["latin-hypercube", "sobol", "random"])
    def test_draws_are_the_same_every_time_and_other_with_another_seed(self, loads: Loads, kind: str) -> None:
        first, again, other = (loads(sweep(SAMPLE.format(kind=kind, seed=seed))) for seed in (1, 1, 2))
        assert first.axes == again.axes
        assert first.sha256 == again.sha256
        assert first.axes != other.axes
        assert first.sha256 != other.sha256

    @pytest.mark.parametrize("kind", ["latin-hypercube", "sobol", "random"])
    def test_draws_follow_their_distributions(self, loads: Loads, kind: str) -> None:
        found = axis(loads(sweep(SAMPLE.format(kind=kind, seed=1))))
        assert (found.name, len(found), found.values[-1]) == ("sample", 100, 99.0)
        velocity, mass, damping, span = (member.values for member in found.members)
        assert all(70 <= value <= 95 for value in velocity)
        assert all(30e3 <= value <= 50e3 for value in mass)
        assert all(1e3 <= value <= 1e4 for value in damping)
        assert all(30 <= value <= 60 for value in span)
        # Mean of 100 independent draws: six standard errors of each distribution.
        assert sum(mass) / 100 == pytest.approx(40e3, abs=6 * 20e3 / math.sqrt(12 * 100))
        assert sum(map(math.log10, damping)) / 100 == pytest.approx(3.5, abs=6 / math.sqrt(12 * 100))
        assert sum(span) / 100 == pytest.approx(130 / 3, abs=6 * 6.24 / 10)

    def test_a_latin_hypercube_has_one_draw_in_every_hundredth(self, loads: Loads) -> None:
        mass = axis(loads(sweep(SAMPLE.format(kind="latin-hypercube", seed=5)))).members[1].values
        assert sorted(int((value - 30e3) / 200) for value in mass) == list(range(100))

    def test_a_point_sets_every_key(self, loads: Loads) -> None:
        case = loads(sweep(SAMPLE.format(kind="sobol", seed=5)))
        point = case.at({"sample": 42.0})
        velocity, mass, damping, span = (member.values[42] for member in axis(case).members)
        assert point.velocity == velocity
        assert point.train.car_body.mass == mass  # type: ignore[union-attr]
        assert point.bridge.left is not None
        assert (point.bridge.right.damping.value, point.bridge.left.damping.value) == (damping, damping)
        assert point.bridge.length == span

    @pytest.mark.parametrize(
        ("old", "new", "message"),
        [
            (
                "kind: sobol",
                "kind: grid",
                'case.yaml:14:5: sweep.sample.kind: expected one of latin-hypercube, sobol, random, got "grid"',
            ),
            (
                "count: 100",
                "count: 0",
                "case.yaml:15:5: sweep.sample.count: expected a whole number from 1 to 125000, got 0",
            ),
            (
                "seed: 1",
                "seed: -1",
                "case.yaml:16:5: sweep.sample.seed: expected a whole number from 0 to 4294967295, got -1",
            ),
            ("seed: 1", "sed: 1", "case.yaml:16:5: sweep.sample.sed: unknown key; did you mean seed?"),
            (
                "[30 t, 50 t]",
                "[50 t, 30 t]",
                "case.yaml:19:23: sweep.sample.over.car_body_mass.uniform: expected rising numbers",
            ),
            (
                "[30 t, 50 t]",
                "[30 t]",
                "case.yaml:19:23: sweep.sample.over.car_body_mass.uniform: expected [low, high], got a list",
            ),
            (
                "{uniform: [30 t, 50 t]}",
                "{gamma: [30 t, 50 t]}",
                "case.yaml:19:7: sweep.sample.over.car_body_mass: expected one of {uniform: [low, high]}, {loguniform: [low, high]}, {normal: [mean, standard deviation]}, {triangular: [low, mode, high]}, got {gamma}",
            ),
            (
                "[30 t, 50 t]",
                "[-30 t, 50 t]",
                'case.yaml:19:33: sweep.sample.over.car_body_mass.uniform: expected a positive mass, e.g. "40 t" or 40000, got "-30 t"',
            ),
            ("span:", "spam:", "case.yaml:21:7: sweep.sample.over.spam: no such key; did you mean span?"),
            (
                "span:",
                "bridge.modes:",
                "case.yaml:21:7: sweep.sample.over.bridge.modes: a whole number cannot be drawn from a distribution",
            ),
        ],
    )
    def test_what_is_wrong_with_it(self, says: Says, old: str, new: str, message: str) -> None:
        text = SAMPLE.format(kind="sobol", seed=1)
        assert old in text
        assert says(sweep(text.replace(old, new))).splitlines()[0] == message

    def test_a_draw_that_its_key_does_not_allow(self, says: Says) -> None:
        text = sweep("sample: {kind: random, count: 50, over: {velocity: {normal: [1, 100]}}}")
        first = says(text).splitlines()[0]
        assert first.startswith("case.yaml:13:44: sweep.sample.over.velocity: draw ")
        assert first.endswith("; bound the distribution with within: [low, high]")
