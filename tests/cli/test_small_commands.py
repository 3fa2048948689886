"""init, list, schema, export, info --diff, and the Python interface."""

from __future__ import annotations

import csv
import json
import shutil
from pathlib import Path

import h5py
import numpy as np
import pyarrow.parquet as pq
import pytest

import tbi_cli
from tests.cli.commands import everything_below, tbi

SHORT = ("--set", "solver.duration=1", "--set", "velocity=180", "-q")


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A small grid, solved."""
    folder = tmp_path_factory.mktemp("results")
    grid = "sweep={train.car_body.mass: [20 t, 40 t], velocity: [150, 160, 170]}"
    assert tbi("run", "paper", *SHORT, "--set", grid, "-o", "grid.h5", folder=folder).code == 0
    return folder / "grid.h5"


def test_a_starter_case_runs_as_it_is(tmp_path: Path) -> None:
    assert tbi("init", "new", "--train", "crh380a", "--bridge", "simply-supported", folder=tmp_path).code == 0
    assert tbi("validate", "case.yaml", folder=tmp_path / "new").code == 0
    assert tbi("run", "case.yaml", *SHORT, folder=tmp_path / "new").code == 0
    before = everything_below(tmp_path)
    again = tbi("init", "new", folder=tmp_path)
    assert again.code == 2
    assert "exists already" in again.err
    assert everything_below(tmp_path) == before


@pytest.mark.parametrize("option", ["--train", "--bridge"])
def test_a_starter_of_nothing(option: str, tmp_path: Path) -> None:
    ended = tbi("init", "new", option, "nothing", folder=tmp_path)
    assert ended.code == 2
    assert "nothing" in ended.err
    assert not everything_below(tmp_path)


def test_list_names_what_is_built_in(tmp_path: Path) -> None:
    everything = tbi("list", folder=tmp_path).out
    trains = tbi("list", "trains", folder=tmp_path).out
    assert "crh380a" in trains and "paper/velocity" not in trains
    assert trains in everything and "paper/velocity" in everything


def test_schema_is_json(tmp_path: Path) -> None:
    schema = json.loads(tbi("schema", folder=tmp_path).out)
    assert schema["$schema"] == "https://json-schema.org/draft/2020-12/schema"
    assert "velocity" in schema["properties"]


def test_exported_tables_are_those_of_the_file(results: Path, tmp_path: Path) -> None:
    """Bit for bit, in CSV and in Parquet; a second export needs --overwrite."""
    for form in ("csv", "parquet"):
        ended = tbi("export", str(results), "--format", form, "-o", "tables", folder=tmp_path)
        assert ended.code == 0, ended.err
    with tbi_cli.open_results(results) as opened:
        peak = opened.table("peak", "right_midspan").ravel()
        masses = np.repeat([20e3, 40e3], 3)
    with (tmp_path / "tables/peak.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [float(row["right_midspan [m]"]) for row in rows] == peak.tolist()
    assert [float(row["train_car_body_mass [kg]"]) for row in rows] == masses.tolist()
    table = pq.read_table(tmp_path / "tables/peak.parquet")
    assert table["right_midspan [m]"].to_numpy().tolist() == peak.tolist()
    before = everything_below(tmp_path)
    again = tbi("export", str(results), "-o", "tables", folder=tmp_path)
    assert again.code == 2
    assert "--overwrite" in again.err
    assert everything_below(tmp_path) == before


def test_what_differs_between_two_files(results: Path, tmp_path: Path) -> None:
    same = tbi("info", str(results), "--diff", str(results), folder=tmp_path)
    assert same.out == "the same case, axes, channels and tables\n"
    grid = "sweep={train.car_body.mass: [20 t, 40 t], velocity: [150, 160, 170]}"
    change = ("--set", grid, "--set", "bridge.right.damping=9e3", "-o", "other.h5")
    assert tbi("run", "paper", *SHORT, *change, folder=tmp_path).code == 0
    differs = tbi("info", str(results), "--diff", "other.h5", folder=tmp_path)
    assert "case bridge.right.damping: 10000.0 and 9000.0" in differs.out
    assert "table peak:" in differs.out


def test_what_one_of_two_files_has_not_computed(results: Path, tmp_path: Path) -> None:
    """A number that is missing is a difference, however alike the others are."""
    path = Path(shutil.copy(results, tmp_path / "gap.h5"))
    with h5py.File(path, "a") as file:
        file["rms/left_midspan"][1, 2] = np.nan
    for pair in ((results, path), (path, results)):
        differs = tbi("info", str(pair[0]), "--diff", str(pair[1]), folder=tmp_path)
        assert differs.out == "table rms: 1 channel differs, left_midspan most, in what is not computed\n"


def test_a_stranger_s_case_does_no_harm(results: Path, tmp_path: Path) -> None:
    """Aliases that explode end in a line, and what a terminal would obey is not printed."""
    path = Path(shutil.copy(results, tmp_path / "theirs.h5"))
    aliases = (f"a{i}: &a{i} {{x: *a{i - 1}, y: *a{i - 1}}}" for i in range(1, 40))
    with h5py.File(path, "a") as file:
        file.attrs["case"] = "\n".join(["a0: &a0 {x: 1, y: 2}", *aliases])
        file.attrs["title"] = "\x1b[31mred\nhost  elsewhere"
        file["daf/right"][0, 0] += 1.0
    differs = tbi("info", str(results), "--diff", "theirs.h5", folder=tmp_path)
    assert differs.code == 0
    assert differs.out.startswith(
        "case: not the same, and not to be compared key by key\ntable daf: 1 channel"
    )
    shown = tbi("info", "theirs.h5", folder=tmp_path)
    assert "title          [31mred host elsewhere\n" in shown.out


def test_the_python_interface_is_the_same_path(results: Path, tmp_path: Path) -> None:
    overrides = ("solver.duration=1", "sweep={train.car_body.mass: [20 t, 40 t], velocity: [150, 160, 170]}")
    case = tbi_cli.load_case("paper", overrides=overrides)
    summary = tbi_cli.run(case, tbi_cli.Options(output=tmp_path / "mine.h5"))
    assert (summary.solved, summary.failed, summary.left) == (6, 0, 0)
    with tbi_cli.open_results(summary.path) as mine, tbi_cli.open_results(results) as theirs:
        for name in ("right_midspan", "car_body_y_acceleration"):
            assert mine.table("rms", name).tobytes() == theirs.table("rms", name).tobytes()
    with pytest.raises(AttributeError):
        tbi_cli.nothing  # noqa: B018


def test_what_is_only_rounding_is_shown_as_nothing(tmp_path: Path) -> None:
    """The starter's beams are alike: the train does not sway, and no 1e-10 nm of it is printed."""
    assert tbi("init", folder=tmp_path).code == 0
    ended = tbi("run", "case.yaml", "--set", "sweep.velocity=[20, 90]", "-v", folder=tmp_path)
    rows = {line.split()[0]: line.split()[1:] for line in ended.out.splitlines() if " m" in line}
    assert rows["car_body_z"] == ["0", "m"]
    assert rows["wheelset_4_z_acceleration"] == ["0", "m/s2"]
    assert len(rows["car_body_y"]) == 6


def test_help_says_every_command_in_a_whole_line(tmp_path: Path) -> None:
    """On a terminal of 80 columns no summary is cut, and no argument has two pairs of brackets."""
    everything = tbi("--help", folder=tmp_path).out
    assert "Draw figures and tables" in everything
    assert "..." not in everything.partition("Commands:")[2]
    for command in ("sweep", "report", "list"):
        usage = tbi(command, "--help", folder=tmp_path).out.splitlines()[0]
        assert "[[" not in usage and "......" not in usage
