"""Zipped and sampled axes: the results file tells which values its cases have; models of several sizes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray

from tbi_cli.case import Case, load_case
from tbi_cli.runner import Options, run
from tbi_cli.solve import Solver
from tbi_cli.store import open_results, studies_of

QUICK = ["solver={sampling: 0.01, substeps: 10, duration: 1}"]


def zipped(*more: str) -> Case:
    together = "velocity: [50, 60, 70], modes: [2, 4, 1], zip: [velocity, modes]"
    sweep = f"sweep={{{together}, car_body_mass: [20 t, 40 t]}}"
    return load_case("paper", overrides=[sweep, *QUICK, *more])


def opened(path: Path, group: str) -> xarray.Dataset:
    """A group, read and closed again."""
    with xarray.open_dataset(path, group=group, engine="h5netcdf") as data:
        return data.load()


def test_members_are_coordinates(tmp_path: Path) -> None:
    case = zipped("output.histories={channels: [car_body_y]}")
    path = run(case, Options(output=tmp_path / "r.h5")).path
    peak = opened(path, "peak")
    assert dict(peak.sizes) == {"velocity_and_modes": 3, "car_body_mass": 2}
    assert set(peak.coords) == {"velocity_and_modes", "car_body_mass", "velocity", "modes"}
    assert peak.velocity.dims == peak.modes.dims == ("velocity_and_modes",)
    assert peak.velocity.values.tolist() == [50, 60, 70]
    assert peak.velocity.attrs["units"] == "m/s"
    with open_results(path) as results:
        (member, other), none = (dim.members for dim in results.dims)
        assert (member.name, other.name, none) == ("velocity", "modes", ())
        assert other.values.tolist() == [2, 4, 1]
    attributes = opened(path, "histories/3").attrs
    assert {key: attributes[key] for key in ("velocity", "modes", "car_body_mass")} == {
        "velocity": 60,
        "modes": 4,
        "car_body_mass": 40e3,
    }


def test_a_resumed_file_keeps_its_members(tmp_path: Path) -> None:
    path = run(zipped(), Options(output=tmp_path / "r.h5")).path
    before = path.read_bytes()
    assert run(zipped(), Options(output=path, resume=True)).before == 6
    assert path.read_bytes() == before
    assert studies_of(path) == ()


def test_a_sample_tells_what_was_drawn(tmp_path: Path) -> None:
    sample = "sweep={sample: {kind: sobol, count: 4, seed: 1, over: {velocity: {uniform: [50, 70]}}}}"
    case = load_case("paper", overrides=[sample, *QUICK])
    path = run(case, Options(output=tmp_path / "r.h5")).path
    peak = opened(path, "peak")
    (axis,) = case.axes
    np.testing.assert_array_equal(peak.velocity.values, axis.members[0].values)
    assert peak.velocity.dims == (axis.name,)


def test_the_most_modes_of_a_zipped_axis_give_the_channels() -> None:
    """As many modal coordinates as the scenario with the most modes has; histories of others lack some."""
    names = [channel.name for channel in Solver(zipped("output.histories=all")).histories]
    assert [name for name in names if name.startswith("right_mode_")] == [
        f"right_mode_{n}" for n in (1, 2, 3, 4)
    ]


def test_a_scenario_is_described_by_its_members() -> None:
    assert Solver(zipped()).describe(3) == "velocity = 60 m/s, modes = 4, car_body_mass = 40000 kg"
