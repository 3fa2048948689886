"""`tbi verify` from the command line, and what it says when something is wrong."""

from __future__ import annotations

import math
import re
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

from tbi_cli.errors import UserError
from tbi_cli.verify.cases import VERIFICATIONS
from tbi_cli.verify.check import Check, Curve, Line, Outcome, Tolerance, worst_channel
from tbi_cli.verify.page import check_page_path, figure, page, thinned, write_page
from tbi_cli.verify.run import Group, case_folder, run_verification
from tbi_cli.verify.solved import Solved, Verification
from tbi_cli.verify.table import table, verdict

FORCE_CASE = """
train: {model: moving-load, forces: [100 kN], positions: [0]}
bridge:
  length: 20 m
  modes: 1
  right: {youngs_modulus: 30 GPa, second_moment: 0.3, mass_per_length: 10 t/m, damping: 0}
velocity: 30 m/s
solver: {sampling: 0.01, duration: 1}
output: {histories: {channels: [right_midspan]}}
"""
TIGHT = Tolerance(1e-9, "none: a made-up check")


def verify(*arguments: str | Path, cwd: Path) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "tbi_cli", "verify", *map(str, arguments)]
    return subprocess.run(command, cwd=cwd, capture_output=True, text=True)


@pytest.fixture(scope="module")
def verified(tmp_path_factory: pytest.TempPathFactory) -> tuple[subprocess.CompletedProcess[str], Path]:
    folder = tmp_path_factory.mktemp("verified")
    return verify("--keep", "kept", cwd=folder), folder


def test_every_case_passes(verified: tuple[subprocess.CompletedProcess[str], Path]) -> None:
    done, _ = verified
    assert done.returncode == 0, done.stdout + done.stderr
    assert "FAIL" not in done.stdout
    last = done.stdout.splitlines()[-1]
    assert re.fullmatch(r"all \d+ checks passed in [\d.]+ s; page: verification\.html", last)
    for v in VERIFICATIONS:
        assert f"{v.number}. {v.title}\n" in done.stdout


def test_the_page_holds_everything(verified: tuple[subprocess.CompletedProcess[str], Path]) -> None:
    done, folder = verified
    html = (folder / "verification.html").read_text(encoding="utf-8")
    checks = int(re.search(r"all (\d+) checks", done.stdout)[1])  # type: ignore[index]
    groups = len(VERIFICATIONS)
    assert html.count('<td class="pass">') == checks + groups
    assert '<td class="fail">' not in html
    # self-contained: nothing is fetched (namespaces of SVG are names, not addresses)
    assert not re.search(r"<(script|link|img|iframe)\b|@import|\burl\((?!#)", html)
    assert html.count("<svg") > 30
    for v in VERIFICATIONS:
        for name in v.cases:
            assert f"<summary>{name}.yaml</summary>" in html


def test_case_files_are_kept_and_run_alone(
    verified: tuple[subprocess.CompletedProcess[str], Path], tmp_path: Path
) -> None:
    kept = verified[1] / "kept"
    names = [name for v in VERIFICATIONS for name in v.cases]
    assert sorted(p.name for p in kept.iterdir()) == sorted(f"{n}.{e}" for n in names for e in ("yaml", "h5"))
    command = [sys.executable, "-m", "tbi_cli", "run", str(kept / "moving-force-largest.yaml")]
    assert subprocess.run([*command, "-o", "alone.h5"], cwd=tmp_path, capture_output=True).returncode == 0


def test_names_and_numbers_are_unique() -> None:
    names = [name for v in VERIFICATIONS for name in v.cases]
    assert len(set(names)) == len(names)
    assert [v.number for v in VERIFICATIONS] == list(range(1, len(VERIFICATIONS) + 1))


@pytest.mark.parametrize("kind", ["folder", "results", "nowhere"])
def test_an_output_that_is_no_page_is_refused(kind: str, tmp_path: Path) -> None:
    path = tmp_path / "out"
    if kind == "folder":
        path.mkdir()
    elif kind == "results":
        path.write_bytes(b"\x89HDF\r\n")
    else:
        path = path / "deeper" / "page.html"
    before = sorted(tmp_path.rglob("*"))
    done = verify("-o", path, cwd=tmp_path)
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr.startswith("--output: ") and done.stderr.count("\n") == 1
    assert sorted(tmp_path.rglob("*")) == before


def test_a_folder_with_files_in_it_is_not_filled(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(UserError, match="--keep: expected a new or an empty folder"), case_folder(tmp_path):
        pass
    with pytest.raises(UserError, match="--keep: "), case_folder(tmp_path / "notes.txt"):
        pass


def made_up(compare_with: float, case: str = FORCE_CASE) -> Verification:
    """A verification whose reference is `compare_with` times what tbi gives."""

    def compare(solved: Mapping[str, Solved]) -> Outcome:
        outcome = Outcome()
        w = solved["force"].history()["right_midspan"]
        outcome.history("a force", "right_midspan", "m", w, compare_with * w, "made up", TIGHT)
        return outcome

    return Verification(1, "Made up", "A case with a known outcome.", {"force": case}, compare)


@pytest.mark.parametrize(("factor", "passes"), [(1.0, True), (1 + 0.5e-9, True), (1 + 2e-9, False)])
def test_a_wrong_reference_fails(factor: float, passes: bool, tmp_path: Path) -> None:
    groups = list(run_verification(tmp_path, [made_up(factor)]))
    assert groups[0].passed is passes
    assert ("FAIL" in "\n".join(table(groups[0]))) is not passes
    assert verdict(groups).startswith("all 1 checks passed" if passes else "1 of 1 checks FAILED")
    assert ('class="fail"' in page(groups)) is not passes


@pytest.mark.parametrize(
    ("case", "message"),
    [
        (FORCE_CASE.replace("30 m/s", "-30 m/s"), "velocity: expected a positive speed"),
        (FORCE_CASE.replace("sampling: 0.01", "sampling: 0.4, substeps: 1"), "expected a stable step"),
    ],
)
def test_a_case_that_is_refused_fails(case: str, message: str, tmp_path: Path) -> None:
    (group,) = run_verification(tmp_path, [made_up(1.0, case)])
    assert not group.passed
    assert message in group.outcome.checks[0].case


def test_a_number_that_is_not_finite_fails() -> None:
    outcome = Outcome()
    bad = np.array([0.0, math.nan, 1.0])
    outcome.history("c", "q", "m", bad, np.ones(3), "s", TIGHT)
    outcome.zero("c", "q", "m", bad, 1.0, "s", TIGHT)
    outcome.number("c", "q", "m", math.nan, 1.0, "s", TIGHT)
    outcome.at_least("c", "q", math.nan, 1.0, "s", TIGHT)
    assert not any(check.passed for check in outcome.checks)
    assert worst_channel({"good": (np.ones(3), np.ones(3)), "bad": (bad, np.ones(3))}) == "bad"


def test_a_group_without_checks_has_not_passed() -> None:
    assert not Group(made_up(1.0), Outcome(), 0.0).passed


def test_at_least_allows_more() -> None:
    outcome = Outcome()
    for ours in (4.5, 4.0, 3.9, 3.7):
        outcome.at_least("c", "slope", ours, 4.0, "s", Tolerance(0.05, "made up"))
    assert [check.passed for check in outcome.checks] == [True, True, True, False]


def test_thinning_keeps_the_extremes() -> None:
    x = np.linspace(0.0, 1.0, 100_001)
    y = np.sin(300 * x)
    y[77_777], y[12_345] = 9.0, -9.0
    tx, ty = thinned(x, y)
    assert len(tx) <= 900 and (np.diff(tx) > 0).all()
    assert (ty.max(), ty.min()) == (9.0, -9.0)


def test_a_figure_escapes_its_words() -> None:
    line = Line("a < b & c", np.arange(3.0), np.arange(3.0))
    svg = figure(Curve("<script>", "x", "y", (line,)))
    assert svg.startswith("<svg") and "<script>" not in svg and "a &lt; b &amp; c" in svg


def test_the_page_replaces_an_earlier_one_and_nothing_else(tmp_path: Path) -> None:
    check = Check("c", "q", "m", 1.0, "s", 1.0, 0.0, TIGHT)
    group = Group(made_up(1.0), Outcome(checks=[check]), 0.1)
    path = tmp_path / "page.html"
    for _ in range(2):
        check_page_path(path)
        write_page(path, [group])
    assert [p.name for p in tmp_path.iterdir()] == ["page.html"]
    path.write_text("something else")
    with pytest.raises(UserError, match="neither"):
        check_page_path(path)


def test_every_group_and_case_is_explained() -> None:
    text = (Path(__file__).parents[2] / "docs" / "VERIFICATION.md").read_text(encoding="utf-8")
    for v in VERIFICATIONS:
        assert f"### {v.number}. {v.title}\n" in text
        section = text.split(f"### {v.number}. ")[1].split("\n### ")[0]
        for name in v.cases:
            assert f"`{name}`" in section, name


def test_references_import_nothing_of_the_solver() -> None:
    script = (
        "import pkgutil, importlib, sys, tbi_cli.verify.references as r\n"
        "for m in pkgutil.iter_modules(r.__path__): importlib.import_module(f'{r.__name__}.{m.name}')\n"
        "print(*sorted(m for m in sys.modules if m.startswith('tbi_cli')))"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    loaded = done.stdout.split()
    assert all(
        m in ("tbi_cli", "tbi_cli.verify") or m.startswith("tbi_cli.verify.references") for m in loaded
    )
