"""The commands on real files, as a user calls them."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest

from tbi_cli.cli import app
from tests.cli.commands import everything_below, tbi

CASE = """\
title: A short crossing
train: trains/paper.yaml
bridge: bridges/paper.yaml
contact: {model: paper, static_load: paper}
velocity: 180 m/s
solver: {sampling: 0.001, substeps: 1, duration: 1}
output: {file: short.h5}
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with one case that is quickly solved."""
    (tmp_path / "case.yaml").write_text(CASE)
    return tmp_path


def test_run_writes_the_file_that_the_case_names(folder: Path) -> None:
    ended = tbi("run", "case.yaml", folder=folder)
    assert ended.code == 0
    assert "right_midspan" in ended.out
    assert str(folder / "short.h5") in ended.out
    with h5py.File(folder / "short.h5") as file:
        assert file["peak/right_midspan"].shape == (1,)
        assert file["status"][0] == 1
    assert sorted(everything_below(folder)) == ["case.yaml", "short.h5"]


def test_sweep_adds_an_axis_and_set_changes_a_key(folder: Path) -> None:
    ended = tbi(
        *("sweep", "velocity", "case.yaml", "--from", "150", "--to", "170", "--step", "10"),
        *(
            "--set",
            "sweep={train.car_body.mass: [20 t, 40 t]}",
            "--set",
            "bridge.modes=2",
            "-o",
            "out.h5",
            "-q",
        ),
        folder=folder,
    )
    assert (ended.code, ended.out, ended.err) == (0, "", "")
    with h5py.File(folder / "out.h5") as file:
        assert file["peak/car_body_y"].shape == (2, 3)
        assert file["peak/velocity"][()].tolist() == [150, 160, 170]
        assert file["peak/train_car_body_mass"][()].tolist() == [20e3, 40e3]
        assert np.isfinite(file["rms/left_midspan"][()]).all()


def test_the_sweep_of_nothing_else_is_the_paper_s(folder: Path) -> None:
    """397 speeds of the built-in case, all channels."""
    ended = tbi("sweep", "velocity", "-o", "v.h5", folder=folder)
    assert ended.code == 0
    assert "397 scenarios solved" in ended.out
    with h5py.File(folder / "v.h5") as file:
        assert file["peak/car_body_y"].shape == (397,)
        assert len(file["peak"]) == 78
        assert (file["status"][()] == 1).all()


def test_python_m_is_the_same_program() -> None:
    script = Path(sys.executable).with_name("tbi")
    ours = subprocess.run([script, "--help"], capture_output=True, text=True, check=True)
    module = subprocess.run(
        [sys.executable, "-m", "tbi_cli", "--help"], capture_output=True, text=True, check=True
    )
    assert ours.stdout == module.stdout


@pytest.mark.parametrize(
    "command", [c.name or c.callback.__name__ for c in app.registered_commands if c.callback]
)
def test_every_command_explains_itself(command: str, tmp_path: Path) -> None:
    ended = tbi(command.rstrip("_"), "--help", folder=tmp_path)
    assert ended.code == 0
    assert f"tbi {command}" in ended.out


def test_help_imports_nothing_heavy() -> None:
    """What makes `tbi --help` answer at once."""
    code = (
        "import sys, tbi_cli.cli;"
        "heavy = {'numpy', 'scipy', 'numba', 'h5py', 'pydantic', 'matplotlib', 'pint', 'joblib', 'plotly'};"
        "print(sorted(heavy & set(sys.modules)))"
    )
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert ended.stdout.strip() == "[]"


def test_a_run_imports_no_compiler(folder: Path) -> None:
    """With its kernels compiled, a run needs neither numba nor SciPy's solvers, whose imports take long."""
    code = (
        "import sys; from tbi_cli import load_case, run; from tbi_cli.runner import Options;"
        "run(load_case('case.yaml'), Options(output='r.h5', overwrite=True));"
        "print(sorted({'numba', 'scipy.linalg', 'matplotlib', 'pandas'} & set(sys.modules)))"
    )
    assert tbi("run", "case.yaml", folder=folder).code == 0
    ended = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=folder
    )
    assert ended.stdout.splitlines()[-1] == "[]"


def test_validate_solves_nothing(folder: Path) -> None:
    ended = tbi(
        "validate", "case.yaml", "--set", "sweep={span: [30, 40], velocity: [50, 60, 70]}", folder=folder
    )
    assert ended.code == 0
    assert "scenarios  6" in ended.out
    assert sorted(everything_below(folder)) == ["case.yaml"]


def test_an_existing_file_needs_a_word(folder: Path) -> None:
    assert tbi("run", "case.yaml", folder=folder).code == 0
    before = everything_below(folder)
    again = tbi("run", "case.yaml", folder=folder)
    assert again.code == 2
    assert "--resume" in again.err and "--overwrite" in again.err
    assert everything_below(folder) == before
    assert tbi("run", "case.yaml", "--resume", folder=folder).code == 0
    assert tbi("run", "case.yaml", "--overwrite", folder=folder).code == 0


BAD = {
    "missing key": ("velocity: 180 m/s\n", "", "velocity"),
    "unknown key": ("velocity: 180 m/s", "velocity: 180 m/s\nvelocty: 3", "case.yaml:6:1: velocty"),
    "wrong unit": ("180 m/s", "180 kg", "case.yaml:5:1: velocity"),
    "wrong type": ("180 m/s", "[180]", "case.yaml:5:1: velocity"),
    "zero velocity": ("180 m/s", "0", "case.yaml:5:1: velocity"),
    "negative velocity": ("180 m/s", "-3 m/s", "case.yaml:5:1: velocity"),
    "bad YAML": ("{model: paper, static_load: paper}", "{model: paper", "case.yaml:"),
    "empty axis": ("output:", "sweep: {velocity: []}\noutput:", "sweep.velocity"),
    "duplicate value": ("output:", "sweep: {velocity: [50, 60, 50]}\noutput:", "sweep.velocity"),
    "zero span": ("bridges/paper.yaml", "{length: 0, right: {}, left: {}}", "bridge.length"),
    "unstable step": ("sampling: 0.001", "sampling: 0.2", "solver.substeps"),
    "no end": ("180 m/s", "1e-9", "solver: expected at most 1e+12 steps in one scenario, got "),
    "no end of a sweep": (
        "output:",
        "sweep: {velocity: [50, 1e-15]}\noutput:",
        "solver at velocity = 1e-15 m/s",
    ),
    "too large a grid": (
        "output:",
        "sweep: {velocity: {from: 1, to: 9, count: 9000}, gravity: {from: 1, to: 20, count: 9000}}\noutput:",
        "sweep",
    ),
    "unknown channel": ("file: short.h5", "histories: {channels: [car_body_x]}", "car_body_x"),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_input_is_one_message_and_changes_nothing(name: str, folder: Path) -> None:
    old, new, expected = BAD[name]
    assert old in CASE
    (folder / "case.yaml").write_text(CASE.replace(old, new))
    before = everything_below(folder)
    ended = tbi("run", "case.yaml", folder=folder)
    assert ended.code == 2
    assert expected in ended.err
    assert ended.out == ""
    assert everything_below(folder) == before


def test_all_errors_of_a_file_at_once(folder: Path) -> None:
    bad = CASE.replace("180 m/s", "-1").replace("duration: 1", "duration: 0").replace("title", "tittle")
    (folder / "case.yaml").write_text(bad)
    ended = tbi("run", "case.yaml", folder=folder)
    assert ended.code == 2
    assert [key in ended.err for key in ("velocity", "solver.duration", "tittle")] == [True] * 3


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (("run", "nowhere.yaml"), "nowhere.yaml"),
        (("run", "."), "."),
        (("run", "case.yaml", "-o", "nowhere/out.h5"), "nowhere"),
        (("run", "case.yaml", "-o", "."), "folder"),
        (("run", "case.yaml", "-o", "/proc/out.h5"), "/proc"),
        (("run", "case.yaml", "--set", "train.car_body.mass=-40 t"), "train.car_body.mass"),
        (("run", "case.yaml", "--set", "nothing"), "nothing"),
        (("sweep", "span", "case.yaml"), "span"),
        (("sweep", "nonsense", "case.yaml", "--values", "1, 2"), "nonsense"),
        (("sweep", "velocity", "case.yaml", "--values", "10, x"), "x"),
        (("info", "case.yaml"), "case.yaml"),
        (("info", "nothing.h5"), "nothing.h5"),
    ],
)
def test_wrong_arguments(arguments: tuple[str, ...], expected: str, folder: Path) -> None:
    before = everything_below(folder)
    ended = tbi(*arguments, folder=folder)
    assert ended.code == 2
    assert expected in ended.err
    assert everything_below(folder) == before


def test_resuming_what_is_finished_solves_nothing(folder: Path) -> None:
    assert tbi("run", "case.yaml", folder=folder).code == 0
    again = tbi("run", "case.yaml", "--resume", folder=folder)
    assert again.code == 0
    assert "1 of them before" in again.out
