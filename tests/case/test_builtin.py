"""Everything in configs/ loads, says what it is, and means what the paper says."""

from __future__ import annotations

from math import pi, sqrt
from pathlib import Path

import pytest

from tbi_cli.case import Builtin, Case, FullTrain, list_builtin, load_case
from tbi_cli.case.builtin import configs_folder

ALL = list_builtin()


def loaded(builtin: Builtin) -> Case:
    """A case as it is; a train or a bridge in the paper's case, single beams under moving loads."""
    if builtin.kind == "case":
        return load_case(builtin.name)
    options = [f"{builtin.kind}={builtin.name}"]
    if builtin.name.startswith("verification") or builtin.name == "whole-deck":
        options += ["train={model: moving-load, forces: [100 kN]}", "contact.static_load=physical"]
    if builtin.kind == "train" and builtin.name != "paper":
        options += ["contact.static_load=physical"]
    if builtin.name.startswith("hslm"):
        options += ["bridge.left=null"]
    return load_case(overrides=options)


@pytest.mark.parametrize("builtin", ALL, ids=lambda builtin: f"{builtin.kind} {builtin.name}")
def test_it_loads_without_a_warning_and_survives_a_round_trip(builtin: Builtin, tmp_path: Path) -> None:
    case = loaded(builtin)
    assert case.warnings == ()
    written = tmp_path / "resolved.yaml"
    written.write_text(case.to_yaml(), encoding="utf-8")
    again = load_case(written)
    assert again == case
    assert again.axes == case.axes
    assert again.sha256 == case.sha256
    assert again.to_yaml() == case.to_yaml()


@pytest.mark.parametrize("builtin", ALL, ids=lambda builtin: f"{builtin.kind} {builtin.name}")
def test_it_says_what_it_is_and_where_its_values_come_from(builtin: Builtin) -> None:
    assert builtin.description
    assert builtin.source


def test_every_file_is_listed() -> None:
    files = {path for path in configs_folder().rglob("*.yaml") if "templates" not in path.parts}
    assert {builtin.path for builtin in ALL} == files
    assert {builtin.kind for builtin in ALL} == {"train", "bridge", "case"}


def test_the_default_case() -> None:
    case = load_case()
    assert case == load_case("paper")
    assert case.velocity == 300 / 3.6
    assert (case.contact.model, case.contact.static_load, case.contact.convective) == (
        "paper",
        "paper",
        False,
    )
    assert (case.solver.sampling, case.solver.substeps, case.solver.duration) == (0.001, 1, 5.0)
    assert not case.output.histories.stored
    assert case.axes == ()
    beams = (case.bridge.right, case.bridge.left)
    assert [beam and beam.damping.value for beam in beams] == [10e3, 10e3]


def test_the_papers_bridge_has_the_frequencies_of_its_table_2() -> None:
    bridge = load_case().bridge
    assert bridge.left is not None
    for beam, f4 in ((bridge.right, 14.464), (bridge.left, 14.986)):
        # Eq. (15), j = 4; the table has five digits.
        frequency = (
            16
            * pi
            / (2 * bridge.length**2)
            * sqrt(beam.youngs_modulus * beam.second_moment / beam.mass_per_length)
        )
        assert frequency == pytest.approx(f4, abs=5e-4)


def test_the_papers_train_is_20_m_long_and_its_car_body_has_40_t() -> None:
    train = load_case().train
    assert isinstance(train, FullTrain)
    geometry = train.geometry
    assert geometry.l_b1 + geometry.l_b2 + geometry.l_w1 + geometry.l_w4 == 20
    assert train.car_body.mass == 40e3


@pytest.mark.parametrize(
    ("name", "axes"),
    [
        ("modes", {"modes": tuple(range(1, 9))}),
        ("sampling", {"velocity": (50 / 3.6, 300 / 3.6), "sampling": (0.2, 0.1, 0.01, 0.001)}),
        ("constant-velocity", {}),
        ("masses", {"car_body_mass": (20e3, 40e3, 60e3, 80e3)}),
        ("velocity", {"velocity": tuple(2 + 0.5 * i for i in range(397))}),
        (
            "velocity-damping",
            {"damping": (1e3, 5e3, 10e3), "velocity": tuple(2 + 0.5 * i for i in range(397))},
        ),
        (
            "velocity-masses",
            {"car_body_mass": (20e3, 40e3, 60e3, 80e3), "velocity": tuple(2 + 0.5 * i for i in range(397))},
        ),
        ("velocity-spans", {"span": (30, 40, 50, 60), "velocity": tuple(2 + 0.5 * i for i in range(397))}),
        ("contact-forces", {}),
    ],
)
def test_the_papers_studies_have_the_papers_grids(name: str, axes: dict[str, tuple[float, ...]]) -> None:
    case = load_case(f"paper/{name}")
    assert {axis.name: axis.values for axis in case.axes} == axes
    assert case.contact.static_load == "paper"
    assert case.bridge.right.damping.value == 10e3
    # Steps of 0.1 and 0.2 s would be unstable: only the sampling interval can be that long.
    assert name != "sampling" or case.solver.substeps == "auto"


def test_names_may_carry_folder_and_suffix() -> None:
    assert load_case("paper/masses.yaml") == load_case("paper/masses")
    for name in ("crh380a", "crh380a.yaml", "trains/crh380a", "trains/crh380a.yaml"):
        assert load_case(overrides=[f"train={name}"]) == load_case(overrides=["train=crh380a"])


def test_a_file_beside_the_case_comes_before_a_built_in_one(tmp_path: Path) -> None:
    (tmp_path / "trains").mkdir()
    (tmp_path / "trains" / "paper.yaml").write_text("model: moving-load\nforces: [1 kN]\n")
    (tmp_path / "case.yaml").write_text("train: trains/paper.yaml\nbridge: verification-1\nvelocity: 5\n")
    assert load_case(tmp_path / "case.yaml").train.model == "moving-load"
    (tmp_path / "case.yaml").write_text("train: paper\nbridge: paper\nvelocity: 5\n")
    assert load_case(tmp_path / "case.yaml").train.model == "full-31dof"


def test_numbers_in_names_are_counted() -> None:
    names = [builtin.name for builtin in list_builtin("train") if builtin.name.startswith("hslm-a")]
    assert names == [f"hslm-a{number}" for number in range(1, 11)]
