"""What is found out after a case was read names file, line and key, as what is found while reading does."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tbi_cli.case import Case, RunError, load_case
from tbi_cli.cli import run_command_line
from tbi_cli.cluster.submission import case_text
from tbi_cli.estimate import estimate
from tbi_cli.report.stored_case import stored_case
from tbi_cli.runner import run

# Of unequal lines and columns, so that no place is right by chance.
FILE = """\
# a comment
train: crh380a
bridge:
    length: 32 m
    right: {youngs_modulus: 34 GPa, second_moment: 1.1, mass_per_length: 9 t/m, damping: {ratio: 1 %}}
    left: {youngs_modulus: 34 GPa, second_moment: 1.2, mass_per_length: 9 t/m, damping: {ratio: 2 %}}
    modes: 3
velocity: 50 m/s
solver:
      duration: 2
      MORE
"""
# Each: lines for the file (those of solver:, and at its end), the key, where in the grid, and what of the
# file the caret of the message stands under: the key, or the axis that sets it.
CHECKS = {
    "unstable step": ("substeps: 1, sampling: 0.2", "", "solver.substeps", "", "substeps"),
    "unstable step of an axis": (
        "sampling: 0.2",
        "sweep: {velocity: [40, 50], solver.substeps: [1, 90]}",
        "solver.substeps",
        "velocity = 40 m/s, solver_substeps = 1",
        "solver.substeps",
    ),
    "too few samples of a filter": (
        "sampling: 0.02",
        "sweep: {modes: [2, 19]}\nbridge.low_pass: 20 Hz",
        "solver.sampling",
        "modes = 2",
        "sampling",
    ),
    "a sampling axis": (
        "substeps: 1",
        "sweep: {zip: [velocity, sampling], velocity: [40, 50], sampling: [0.001, 0.3]}",
        "solver.substeps",
        "velocity = 50 m/s, sampling = 0.3 s",
        "substeps",
    ),
    "no end": ("sampling: 1e-13", "", "solver", "", "solver"),
    "unknown channel of histories": (
        "",
        "output: {histories: {every: 0.01, channels: [nonsense]}}",
        "output.histories.channels",
        "",
        "channels",
    ),
    "unknown channel of a refinement": (
        "",
        "sweep:\n  velocity: {from: 20, to: 30, step: 5, refine: resonance, channels: [nonsense]}",
        "sweep.velocity.channels",
        "",
        "channels",
    ),
    "too large a grid": (
        "",
        "sweep: {velocity: {from: 1, to: 9, count: 9000}, gravity: {from: 1, to: 20, count: 9000}}",
        "sweep",
        "",
        "sweep",
    ),
    "train of a large design": (
        "",
        "sweep:\n  sample: {kind: random, count: 40, seed: 3, over: {train.geometry.l_b1: "
        "{uniform: [7, 30]}}}",
        "sweep.sample",
        "train_geometry_l_b1 = .* m",
        "sample",
    ),
}


def written(solver: str, more: str) -> str:
    """A case file; a solver key is a line, and a dotted key of the bridge goes there."""
    text = (
        FILE.replace("MORE", solver.replace(", ", "\n      ")) if solver else FILE.replace("      MORE\n", "")
    )
    *lines, last = more.split("\n")
    if last.startswith("bridge."):
        text = text.replace("    modes: 3", f"    {last.removeprefix('bridge.')}\n    modes: 3")
        return text + "\n".join(lines) + "\n"
    return f"{text}{more}\n"


def refusal(case: Case) -> str:
    """The message of a case that cannot be run: the same before a run and from an estimate."""
    told = []
    for refused in (estimate, run):
        with pytest.raises(RunError) as caught:
            refused(case)
        told.append(str(caught.value))
    # The estimate of a large grid is by lot, and the free memory changes.
    first, other = (re.split("expected|got", text)[0] for text in told)
    assert first == other
    return told[0]


@pytest.mark.parametrize("name", CHECKS)
def test_a_check_after_reading_has_the_place_of_its_key(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("tbi_cli.case.checks._MOST_CORNERS", 10)
    solver, more, key, at, under = CHECKS[name]
    Path("case.yaml").write_text(text := written(solver, more))
    case = load_case("case.yaml")
    message = refusal(case)
    where = rf"case.yaml:(\d+):(\d+): {re.escape(key)}" + (f" at {at}" if at else "") + ": expected "
    found = re.match(where, message)
    assert found, message
    line = text.splitlines()[int(found[1]) - 1]
    assert re.match(rf"{re.escape(under)}:", line[int(found[2]) - 1 :])
    assert message.splitlines()[1].endswith(f" | {line}")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["case.yaml"]
    # The places are no part of the case, and are forgotten where the file is.
    again = stored_case(case.to_yaml())
    assert again is not None and again == case and again.sha256 == case.sha256
    assert re.match(where.removeprefix(r"case.yaml:(\d+):(\d+): "), refusal(again))


def test_of_options_built_in_cases_and_studies(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    coarse = "solver.sampling=0.2"
    assert refusal(load_case("paper", overrides=[coarse])).startswith(
        "paper.yaml (built-in):8:42: solver.substeps: expected a stable step"
    )
    assert refusal(load_case("paper", overrides=[coarse, "solver.substeps=2"])).startswith(
        "--set solver.substeps=2: solver.substeps: expected a stable step"
    )
    Path("case.yaml").write_text(
        written("sampling: 0.2", "studies:\n  fine: {}\n  coarse: {solver.substeps: 1}\n")
    )
    message = refusal(load_case("case.yaml"))
    assert message.startswith("case.yaml:14:12: studies.coarse.solver.substeps: expected a stable step")
    stored = stored_case(load_case("case.yaml").to_yaml())
    assert stored is not None
    assert refusal(stored).startswith("studies.coarse.solver.substeps: expected a stable step")
    Path("sent.yaml").write_text(case_text(load_case("case.yaml"), "r.h5"))
    assert refusal(load_case("sent.yaml")).startswith("sent.yaml:")


def test_a_case_made_of_a_mapping_has_the_key_alone() -> None:
    values = load_case("paper").resolved()
    values["solver"] |= {"sampling": 0.2}
    assert refusal(Case.model_validate(values)).startswith("solver.substeps: expected a stable step")


def test_a_results_file_that_cannot_be_where_the_case_wants_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("case.yaml").write_text(written("", "output:\n  file: nowhere/r.h5"))
    assert run_command_line(["run", "case.yaml"]) == 2
    reason = f"{tmp_path}/nowhere/r.h5: the folder {tmp_path}/nowhere does not exist"
    assert capsys.readouterr().err.splitlines()[0] == f"case.yaml:12:3: output.file: {reason}"
    assert run_command_line(["run", "case.yaml", "-o", "nowhere/r.h5"]) == 2
    assert capsys.readouterr().err == f"{reason}\n"
