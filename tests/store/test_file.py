"""The results file as the programs see it that people read it with."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray as xr

from tbi_cli.store import DAF, TABLES, ResultsStore
from tests.store.example import batch, batches, history, layout


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A finished run of 15 cases with histories; case 7 failed, cases 12 to 14 were never solved."""
    of = layout(histories=3, command="tbi run über.yaml", host="node7")
    with ResultsStore(tmp_path_factory.mktemp("run") / "results.h5", of) as store:
        for indices in batches(of)[:3]:
            store.write(batch(of, indices, failed=[7]))
        return store.finish()


def test_h5py_finds_groups_units_and_scales(written: Path) -> None:
    of = layout(histories=3)
    with h5py.File(written, "r") as file:
        assert set(file) == {
            *TABLES,
            "daf",
            "histories",
            "status",
            "message",
            "train_car_body_mass",
            "velocity",
        }
        for name in (*TABLES, "daf"):
            group = file[name]
            expected = {v.name for v in of.columns(name)} | {"train_car_body_mass", "velocity"}
            assert set(group) == expected
            for variable in of.columns(name):
                data = group[variable.name]
                assert data.dtype == np.float64
                assert data.shape == (3, 5)
                assert (data.attrs["units"], data.attrs["long_name"]) == (variable.units, variable.long_name)
                scales = [data.dims[axis][0] for axis in range(2)]
                assert [s.name for s in scales] == [f"/{name}/train_car_body_mass", f"/{name}/velocity"]
        assert file["time_of_peak/body_0_y"].attrs["units"] == "s"
        assert file["peak/velocity"].attrs["units"] == "m/s"
        assert np.isnan(file["rms/body_1_y"][...].ravel()[[7, 12, 13, 14]]).all()


def test_every_dataset_has_units_and_a_long_name(written: Path) -> None:
    def check(name: str, item: h5py.HLObject) -> None:
        if isinstance(item, h5py.Dataset):
            assert isinstance(item.attrs["units"], str), name
            assert isinstance(item.attrs["long_name"], str), name

    with h5py.File(written, "r") as file:
        file.visititems(check)


def test_status_and_message(written: Path) -> None:
    with h5py.File(written, "r") as file:
        assert file["status"].dtype == np.int8
        assert file["status"][...].tolist() == [[1, 1, 1, 1, 1], [1, 1, 2, 1, 1], [1, 1, 0, 0, 0]]
        texts = file["message"].asstr()[...]
        assert texts[1, 2] == "case 7: the motion grew without bound"
        assert (texts != "").sum() == 1


def test_root_attributes(written: Path) -> None:
    with h5py.File(written, "r") as file:
        found = dict(file.attrs)
    assert (found["format"], found["format_version"]) == ("tbi-results", 1)
    assert found["case"].startswith("title: an example")
    assert found["case_sha256"] == "1" * 64
    assert found["command"] == "tbi run über.yaml"
    assert (found["solve_seconds"], found["case_steps"]) == (12 * 0.25, 1200)


def test_histories(written: Path) -> None:
    of = layout(histories=3)
    with h5py.File(written, "r") as file:
        assert set(file["histories"]) == {str(i) for i in range(12) if i != 7}
        group = file["histories/11"]
        assert set(group) == {"time", "body_0_y", "body_1_y", "body_2_y"}
        assert group.attrs["velocity"] == of.dims[1].values[1]
        assert group.attrs["train_car_body_mass"] == of.dims[0].values[2]
        assert group["time"].attrs["units"] == "s"
        assert group["body_2_y"].dims[0][0].name == "/histories/11/time"
        np.testing.assert_array_equal(group["body_2_y"][...], history(of, 11).values[2])


def test_no_histories_group_without_histories(tmp_path: Path) -> None:
    of = layout()
    with ResultsStore(tmp_path / "results.h5", of) as store:
        store.write(batch(of, range(15)))
        with h5py.File(store.finish(), "r") as file:
            assert "histories" not in file


@pytest.mark.parametrize("group", [*TABLES, "daf"])
def test_xarray_opens_a_table_with_its_coordinates(written: Path, group: str) -> None:
    of = layout()
    with xr.open_dataset(written, group=group, engine="h5netcdf") as data:
        assert dict(data.sizes) == {"train_car_body_mass": 3, "velocity": 5}
        assert data["velocity"].attrs["units"] == "m/s"
        np.testing.assert_array_equal(data["velocity"], of.dims[1].values)
        name = "right_static" if group == "daf" else "body_3_y"
        assert data[name].dims == ("train_car_body_mass", "velocity")
        assert float(data[name][1, 1]) == float(data[name].values.ravel()[6])


def test_xarray_opens_the_root_and_a_history(written: Path) -> None:
    with xr.open_dataset(written, engine="h5netcdf") as data:
        assert data["status"].dims == data["message"].dims == ("train_car_body_mass", "velocity")
        assert data["message"].values[1, 2] == "case 7: the motion grew without bound"
        assert set(data.coords) == {"train_car_body_mass", "velocity"}
    with xr.open_dataset(written, group="histories/3", engine="h5netcdf") as data:
        np.testing.assert_array_equal(data["body_1_y"], history(layout(histories=3), 3).values[1])
        assert data["body_1_y"].dims == ("time",)


def run(program: str, *arguments: str) -> str:
    if shutil.which(program) is None:
        pytest.skip(f"{program} is not installed (apt-get install hdf5-tools netcdf-bin)")
    done = subprocess.run([program, *arguments], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    return done.stdout


def test_h5dump_reads_all_of_it(written: Path) -> None:
    whole = run("h5dump", str(written))
    assert 'GROUP "time_of_peak"' in whole
    value = layout().dims[0].values[0]
    assert run(
        "h5dump", "-y", "-m", "%.17g", "-d", "/peak/train_car_body_mass", "-s", "0", "-c", "1", str(written)
    ).count(f"{value:.17g}")


def test_h5dump_prints_the_numbers(written: Path) -> None:
    expected = batch(layout(histories=3), [6]).tables["peak"][0, 2]
    text = run("h5dump", "-y", "-m", "%.17g", "-d", "/peak/body_2_y", "-s", "1,1", "-c", "1,1", str(written))
    assert f"{expected:.17g}" in text


def test_ncdump_knows_the_dimensions(written: Path) -> None:
    header = run("ncdump", "-h", str(written))
    assert "double body_2_y(train_car_body_mass, velocity) ;" in header
    assert "double body_2_y(time) ;" in header
    assert 'body_2_y:units = "m/s^2"' in header
    run("ncdump", str(written))  # every number of it


def test_it_is_of_hdf5s_earliest_version(written: Path) -> None:
    assert written.read_bytes()[8] == 0  # the superblock's version: read by every HDF5 since 1.0


def test_the_order_of_batches_leaves_no_trace(tmp_path: Path) -> None:
    of = layout(histories=2)
    files = []
    for name, order in (("a", 1), ("b", -1)):
        with ResultsStore(tmp_path / f"{name}.h5", of) as store:
            for indices in batches(of, size=3 + order)[::order]:
                store.write(batch(of, indices[::order], failed=[4]))
            files.append(store.finish().read_bytes())
    assert files[0] == files[1]


def test_one_beam_and_one_case(tmp_path: Path) -> None:
    """A case with no sweep has the one dimension velocity, of length 1; a vehicle on one beam no left one."""
    of = layout(shape=(1,), daf=["right", "right_static"])
    with ResultsStore(tmp_path / "results.h5", of) as store:
        store.write(batch(of, [0]))
        path = store.finish()
    with xr.open_dataset(path, group="daf", engine="h5netcdf") as data:
        assert set(data.data_vars) == {"right", "right_static"} < set(DAF)
        assert dict(data.sizes) == {"velocity": 1}
