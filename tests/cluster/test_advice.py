"""Every piece of advice that is printed is typed here as it stands: it works, and nothing is lost by it."""

from __future__ import annotations

import ast
import json
import os
import re
import shlex
import subprocess
import sys
import threading
import tomllib
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

import tbi_cli
from tbi_cli.advice import go_on
from tbi_cli.case import Case, load_case
from tbi_cli.cli.summary import print_summary
from tbi_cli.errors import UserError
from tbi_cli.report.missing import gaps
from tbi_cli.report.study import open_studies
from tbi_cli.reproduce import paper_cases
from tbi_cli.runner import Options, Silence, Summary, run
from tbi_cli.store.lock import LOCK_FILE, Holder
from tests.cli.commands import Ended
from tests.cluster.runs import CASE, content, inside

PROJECT = Path(tbi_cli.__file__).parents[1]
WHOLE = "whole run.h5"  # paths with blanks are to be quoted


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a case and, as WHOLE, its results; one with a blank in its name."""
    there = tmp_path / "a folder"
    there.mkdir()
    (there / "case.yaml").write_text(CASE)
    monkeypatch.chdir(there)
    return there


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """What is right in the end."""
    there = tmp_path_factory.mktemp("whole")
    (there / "case.yaml").write_text(CASE)
    assert inside("run", "case.yaml", "-q", folder=there).code == 0
    return tables(there / "results.h5")


def tables(path: Path) -> dict[str, bytes]:
    """The numbers of a results file."""
    return {name: value for name, value in content(path).items() if name.split("/")[0] in ("peak", "status")}


def tbi(*arguments: str, folder: Path) -> Ended:
    """A command, in this process, as if it had been typed."""
    before, sys.argv = sys.argv, ["tbi", *arguments]
    try:
        return inside(*arguments, folder=folder)
    finally:
        sys.argv = before


def typed(line: str, folder: Path) -> str:
    """A line typed into a shell in a folder; it has to work."""
    programs = folder / ".programs"
    programs.mkdir(exist_ok=True)
    (programs / "tbi").write_text(f'#!/bin/sh\nexec "{sys.executable}" -m tbi_cli "$@"\n')
    (programs / "tbi").chmod(0o755)
    done = subprocess.run(
        ["bash", "-c", line],
        cwd=folder,
        env=os.environ | {"PATH": f"{programs}{os.pathsep}{os.environ['PATH']}", "PYTHONPATH": str(PROJECT)},
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, f"{line}\n{done.stdout}{done.stderr}"
    return done.stdout


def advised(text: str, before: str = "continue with: ") -> str:
    """The command that a message ends with."""
    found = re.search(rf"{re.escape(before)}(.*)$", text.strip(), re.MULTILINE)
    assert found, text
    return found[1]


class _FirstBatch(Silence):
    """Stops a run once a batch is on disk."""

    def __init__(self) -> None:
        self.stop = threading.Event()

    def advance(self, scenarios: int, steps: int) -> None:
        self.stop.set()


def stopped(case: Case, options: Options) -> Summary:
    """A run that was stopped after a batch or two."""
    progress = _FirstBatch()
    summary = run(case, options, progress=progress, stop=progress.stop)
    assert summary.left and summary.solved
    return summary


def gap(path: Path) -> str:
    """What a report of one file says is missing."""
    studies = open_studies([path])
    try:
        (text,) = gaps(studies)
        return text
    finally:
        for study in studies:
            study.results.close()


def test_a_run_that_was_stopped_goes_on(
    folder: Path, whole: dict[str, bytes], capsys: pytest.CaptureFixture[str]
) -> None:
    """By what the run prints, and by what a report says of it later, in another folder too."""
    command = ("tbi", "run", "case.yaml", "-o", WHOLE, "--overwrite", "--set", "title=a b", "-q")
    case = load_case("case.yaml", overrides=["title=a b"])
    print_summary(stopped(case, Options(Path(WHOLE), command=command)), command)
    ends = "tbi run case.yaml -o 'whole run.h5' --set 'title=a b' -q --resume"
    assert advised(capsys.readouterr().out) == ends == advised(gap(folder / WHOLE))
    elsewhere = folder.parent / "elsewhere"
    elsewhere.mkdir()
    os.chdir(elsewhere)
    line = advised(gap(folder / WHOLE))
    assert line == f"cd '{folder}' && {ends}"
    typed(line, elsewhere)
    assert tables(folder / WHOLE) == whole


def test_a_run_that_python_began_goes_on_there(folder: Path, whole: dict[str, bytes]) -> None:
    case, options = load_case("case.yaml"), Options(Path("r.h5"))
    stopped(case, options)
    line = advised(gap(folder / "r.h5"), "continue in Python with ")
    assert "tbi" not in line
    with pytest.raises(UserError) as caught:
        run(case, options)
    text = "holds an unfinished run, "
    assert text in str(caught.value)
    assert str(caught.value).endswith(
        "; Options(resume=True) continues it, Options(overwrite=True) starts afresh"
    )
    resumed: Options = eval(line, {"Options": lambda **given: replace(options, **given)})
    run(case, resumed)
    assert tables(folder / "r.h5") == whole
    with pytest.raises(UserError) as caught:
        run(case, options)
    assert str(caught.value).endswith(
        "; Options(resume=True) completes it, Options(overwrite=True) replaces it"
    )
    with pytest.raises(UserError) as caught:
        run(load_case("case.yaml", overrides=["gravity=9.8"]), resumed)
    assert str(caught.value).endswith("; choose another file with Options(output=...)")


def test_nothing_is_advised_that_would_destroy_another_run(folder: Path) -> None:
    """Another shard's file, and another case's, finished or not, with --resume and without."""
    assert tbi("run", "case.yaml", "-q", "--shard", "1/3", "-o", "s.h5", folder=folder).code == 0
    stopped(load_case("case.yaml"), Options(Path("u.h5"), command=("tbi", "run", "case.yaml", "-o", "u.h5")))
    before = {path: path.read_bytes() for path in folder.rglob("*.h5")}
    assert len(before) > 2
    for file in ("s.h5", "u.h5"):
        for change in (["--shard", "2/3"], ["--set", "gravity=9.8"], ["--set", "studies={a: {}}"]):
            for how in ([], ["--resume"]):
                command = ["run", "case.yaml", "-q", *change, *how]
                ended = tbi(*command, "-o", file, folder=folder)
                assert ended.code == 2
                assert re.search(r": (is|holds) [^;]*(; [^;]*)*; choose another file with -o\n$", ended.err)
                assert "overwrite" not in ended.err
                assert {path: path.read_bytes() for path in folder.rglob("*.h5") if path in before} == before
    assert (
        tbi("run", "case.yaml", "-q", "--shard", "2/3", "--resume", "-o", "other.h5", folder=folder).code == 0
    )


def test_what_exists_is_completed_or_replaced(folder: Path, whole: dict[str, bytes]) -> None:
    """The options that a message names are added to the command that was refused, one after the other."""
    base = ["run", "case.yaml", "-q", "-o", "r.h5"]
    for finished in (True, False):
        if finished:
            assert tbi(*base, folder=folder).code == 0
        else:
            halfway = Options(Path("r.h5"), overwrite=True, command=("tbi", *base))
            stopped(load_case("case.yaml"), halfway)
            (folder / "r.h5").unlink()
        ended = tbi(*base, folder=folder)
        options = re.findall(r"--\w+", ended.err)
        assert (ended.code, options) == (2, ["--resume", "--overwrite"])
        for option in options:
            assert tbi(*base, option, folder=folder).code == 0
            assert tables(folder / "r.h5") == whole
    (folder / "text.h5").write_text("not mine")
    ended = tbi("run", "case.yaml", "-o", "text.h5", folder=folder)
    assert (
        ended.err == f"{folder}/text.h5: exists already and is no results file; choose another file with -o\n"
    )


@pytest.fixture
def shards(folder: Path) -> list[str]:
    """Three shards of a run, in files with a blank in their names."""
    for number in (1, 2, 3):
        more = ["--set", "output.file=r s.h5", "--requeue" if number == 1 else "--resume"]
        assert tbi("run", "case.yaml", "-q", "--shard", f"{number}/3", *more, folder=folder).code == 0
    return [f"r s.shard-{number}-of-3.h5" for number in (1, 2, 3)]


def test_shards_are_joined_and_what_they_lack_is_solved(
    folder: Path, shards: list[str], whole: dict[str, bytes], monkeypatch: pytest.MonkeyPatch
) -> None:
    third = (folder / shards[2]).read_bytes()
    (folder / shards[2]).unlink()
    merge = ["merge", *shards[:2], "-o", "part.h5"]
    refused = tbi(*merge, folder=folder)
    assert refused.err == "missing shards: 3/3; --partial leaves their cases to be done\n"
    assert tbi(*merge, *re.findall(r"--\w+", refused.err), folder=folder).code == 0
    # A report says how to go on: not with merge, which has no --resume.
    monkeypatch.chdir(folder.parent)
    ended = tbi(
        *("report", "a folder/part.h5", "-o", "page", "--channels", "right_midspan", "--formats", "png"),
        folder=folder.parent,
    )
    line = advised(ended.out)
    assert shlex.split(line)[3:6] == ["tbi", "run", "case.yaml"]
    typed(line, folder.parent)
    assert tables(folder / "part.h5") == whole
    # One shard alone is to be joined, from wherever.
    (folder / shards[2]).write_bytes(third)
    line = advised(gap(folder / shards[0]), "join it with the others: ")
    typed(line, folder.parent)
    assert tables(folder / "r s.h5") == whole
    # And what is there is not replaced without a word; merge has no --resume.
    ended = tbi(*merge[:1], *shards, "-o", "part.h5", folder=folder)
    assert (
        ended.err
        == f"{folder}/part.h5: exists already; choose another file with -o, --overwrite replaces it\n"
    )
    assert tbi(*merge[:1], *shards, "-o", "another.h5", folder=folder).code == 0
    assert tbi(*merge[:1], *shards, "-o", "part.h5", "--overwrite", folder=folder).code == 0
    assert tables(folder / "part.h5") == tables(folder / "another.h5") == whole


def test_a_disk_that_is_full(folder: Path, whole: dict[str, bytes]) -> None:
    """The limit of a file's size ends the run when the results file is put together, or a batch before."""
    (folder / "tbi").write_text(f'#!/bin/sh\nexec "{sys.executable}" -m tbi_cli "$@"\n')
    (folder / "tbi").chmod(0o755)
    line = "ulimit -f 160; trap '' XFSZ; ./tbi run case.yaml -j 1 -o 'r s.h5' -q"
    here = os.environ | {"PYTHONPATH": str(PROJECT)}
    ended = subprocess.run(
        ["bash", "-c", line], cwd=folder, env=here, capture_output=True, text=True, check=False
    )
    assert ended.returncode == 2, ended.stderr
    assert " safe" in ended.stderr
    typed(advised(ended.stderr), folder)
    assert tables(folder / "r s.h5") == whole


def test_a_lock_of_a_machine_that_is_gone(folder: Path, whole: dict[str, bytes]) -> None:
    command = ("tbi", "run", "case.yaml", "-o", "r.h5")
    stopped(load_case("case.yaml"), Options(Path("r.h5"), command=command))
    other = replace(Holder.this_process(), host="elsewhere")
    (folder / "r.h5.parts" / LOCK_FILE).write_text(json.dumps(other.__dict__))
    ended = tbi(*command[1:], "-q", "--resume", folder=folder)
    assert ended.code == 2
    typed(f"rm {shlex.quote(advised(ended.err, 'if that run is dead, delete '))}", folder)
    assert tbi(*command[1:], "-q", "--resume", folder=folder).code == 0
    assert tables(folder / "r.h5") == whole


def test_the_way_from_init(folder: Path) -> None:
    told = tbi("init", "my first bridge", "--train", "hslm-a1", folder=folder).out
    for line in advised(told, " is ready: ").split(", "):
        typed(line, folder)
    (folder / "my first bridge" / "case.yaml").write_text("velocity: 5\n")
    assert tbi("init", "my first bridge", folder=folder).err.endswith("exists already; name another folder\n")
    assert tbi("init", "my second bridge", folder=folder).code == 0


@pytest.mark.parametrize(
    ("options", "key"),
    [
        (("sampling=0.2", "substeps=1"), "substeps"),
        (("sampling=0.31", "substeps=2"), "substeps"),
        (("sampling=0.5",), "sampling"),
    ],
)
def test_numbers_that_are_advised_are_accepted(folder: Path, options: tuple[str, ...], key: str) -> None:
    """Substeps that are enough, and one fewer are not; a sampling interval to the last digit printed."""
    given = [word for option in options for word in ("--set", f"solver.{option}")]
    given += (
        ["--set", "sweep=null", "--set", "bridge.low_pass=15 Hz"]
        if key == "sampling"
        else ["--set", "sweep=null"]
    )
    command = ["validate", "case.yaml", *given, "--set", "solver.substeps=auto"][
        : None if key == "sampling" else -2
    ]
    ended = tbi(*command, folder=folder)
    assert ended.code == 2
    pattern = r"use at least (\d+) substeps, or auto" if key == "substeps" else r"expected at most (\S+) s"
    found = re.search(pattern, ended.err)
    assert found, ended.err
    for value in (found[1], "auto"):
        assert tbi(*command, "--set", f"solver.{key}={value}", folder=folder).code == 0
    if key == "substeps":
        assert tbi(*command, "--set", f"solver.substeps={int(found[1]) - 1}", folder=folder).code == 2


def test_options_and_units_that_are_advised_are_accepted(folder: Path) -> None:
    ended = tbi("sweep", "span", "case.yaml", "--from", "20", folder=folder)
    assert ended.err == "sweep span: missing --to, --step; expected --from, --to and --step, or --values\n"
    for more in (("--from", "20", "--to", "30", "--step", "10"), ("--values", "20, 30")):
        small = ("--set", "sweep=null", "-q", "--overwrite", *more)
        assert tbi("sweep", "span", "case.yaml", *small, folder=folder).code == 0
    ended = tbi(
        "validate", "case.yaml", "--set", "sweep=null", "--set", "train.car_body.mass=40", folder=folder
    )
    meant = advised(ended.err, "; was ").removesuffix(" meant?").strip('"')
    quiet = ["--strict", "--set", "sweep=null", "--set", f"train.car_body.mass={meant}"]
    assert tbi("validate", "case.yaml", *quiet, folder=folder).code == 0
    ended = tbi("validate", "case.yaml", "--set", "title=5", folder=folder)
    assert ended.err.endswith("(put it in quotes)\n")
    assert tbi("validate", "case.yaml", "--set", "title='5'", folder=folder).code == 0
    over = "sweep={sample: {kind: random, count: 60, over: {gravity: {normal: [1, 1]MORE}}}}"
    ended = tbi("validate", "case.yaml", "--set", over.replace("MORE", ""), folder=folder)
    assert "; bound the distribution with within: [low, high]" in ended.err
    bound = over.replace("MORE", ", within: [0.1, 9]")
    assert tbi("validate", "case.yaml", "--set", bound, folder=folder).code == 0


def test_what_a_report_names(folder: Path) -> None:
    """Commands for what is missing of the paper; they take minutes, so that here they are checked alone."""
    assert tbi("run", "case.yaml", "-q", "--set", "sweep=null", "-o", WHOLE, folder=folder).code == 0
    ended = tbi("report", WHOLE, "-o", "page", "--heat-map", folder=folder)
    assert "axis           velocity: 1 value" in typed(advised(ended.err, "are shown by: "), folder)
    ended = tbi("report", WHOLE, "-o", "page", "--formats", "png", folder=folder)
    missing = re.findall(r"^missing: .*: (tbi run \S+)$", ended.out, re.MULTILINE)
    assert missing
    for command in [*missing, *(f"tbi run {name}" for name in paper_cases())]:
        assert tbi("validate", *shlex.split(command)[2:], folder=folder).code == 0
    (folder / "taken").write_text("")
    for taken in ("taken", "."):
        ended = tbi("report", WHOLE, "-o", taken, folder=folder)
        assert ended.code == 2 and "choose another with -o" in ended.err
    assert tbi("export", WHOLE, "-o", "out", folder=folder).code == 0
    ended = tbi("export", WHOLE, "-o", "out", folder=folder)
    assert tbi("export", WHOLE, "-o", "out", *re.findall(r"--\w+", ended.err), folder=folder).code == 0


def test_a_reproduction_goes_on_without_beginning_afresh(folder: Path) -> None:
    """It takes minutes: only its words are read here."""
    line = go_on(["tbi", "reproduce", "-o", "a b", "--overwrite", "-j", "2"])
    assert line == "continue with: tbi reproduce -o 'a b' -j 2"
    assert tbi(*shlex.split(line)[3:], "--help", folder=folder).code == 0


def test_what_can_be_installed_is_there_to_be() -> None:
    extras = tomllib.loads((PROJECT / "pyproject.toml").read_text())["project"]["optional-dependencies"]
    named = {name for _, text in _strings() for name in re.findall(r"tbi-cli\[(\w+)\]", text)}
    assert named == {"dask", "parquet"} <= set(extras)


# Where advice is printed, and which test types it.  What is tried elsewhere is named with its test.
_TRIED = {
    "advice.py": "here",
    "case/document.py": "test_options_and_units_that_are_advised_are_accepted",
    "case/starter.py": "options alone, before what is wrong with them",
    "cli/__init__.py": "tests/docs/test_tutorial.py",
    "cli/init.py": "test_the_way_from_init",
    "cli/reproduce.py": "tests/report/test_reproduce.py",
    "cluster/scripts.py": "tests/cluster/test_scripts.py",
    "cluster/submission.py": "tests/cluster/test_slurm.py",
    "cluster/slurm.py": "tests/cluster/test_slurm.py",
    "dask_workers.py": "test_what_can_be_installed_is_there_to_be; tests/cluster/test_dask.py",
    "export.py": "test_what_a_report_names",
    "report/make.py": "test_what_a_report_names",
    "report/missing.py": "test_what_a_report_names; test_shards_are_joined_and_what_they_lack_is_solved",
    "report/folder.py": "test_what_a_report_names",
    "report/wishes.py": "tests/report/test_wishes.py",
    "runner.py": "tests/cli/test_surroundings.py",
    "store/claim.py": "test_what_exists_is_completed_or_replaced",
    "store/merge.py": "test_shards_are_joined_and_what_they_lack_is_solved",
    "workers.py": "tests/cluster/test_workers.py",
}
# Scripts for Slurm and calls of other programs; names of options before what is wrong with them.
_NO_ADVICE = re.compile(
    r"<code>|--(signal|requeue|cpus-per-task|parsable|array=|dependency=|kill-on|noheader|me|format=)|"
    r"--(shards|shard|backend|scheduler|jobs|keep|sbatch|formats|select|channels|output|x|family|[{])\b.*: |"
    r"--(x|family|select|resume|overwrite|always|dirty|abbrev=12|exclude=[*]|shard|output|help)$|--select "
)


def _strings() -> Iterator[tuple[str, str]]:
    """Every text in the code that is printed, more or less: file and text."""
    root = Path(tbi_cli.__file__).parent
    for path in sorted(root.rglob("*.py")):
        tree = ast.parse(path.read_text())
        skipped: set[int] = set()
        for node in ast.walk(tree):
            if isinstance(node, ast.Call) and getattr(node.func, "attr", "") in ("Option", "Argument"):
                skipped |= {id(inner) for inner in ast.walk(node)}
            if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
                skipped.add(id(node.value))
        for node in ast.walk(tree):
            if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in skipped:
                yield str(path.relative_to(root)), node.value


def test_every_place_that_prints_advice_is_known() -> None:
    """Options and commands in texts stand in the files above; in a new place they are to be tried too."""
    commands = "run|sweep|report|merge|info|status|submit|validate|init|export|reproduce"
    advice = re.compile(rf"--[a-z]|\btbi ({commands})\b|\bwith -o\b|pip install")
    found = {file for file, text in _strings() if advice.search(text) and not _NO_ADVICE.search(text)}
    assert found <= set(_TRIED), found - set(_TRIED)
