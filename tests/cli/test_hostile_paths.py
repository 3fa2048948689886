"""Names that no one expects and places without permission: one printable message, nothing left behind."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from pathlib import Path

import h5py
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tbi_cli.errors import UserError
from tbi_cli.printable import printable
from tests.cli.forked import Died, forked

CASE = """\
title: Two forces
train: {model: moving-load, forces: [1 kN, 2 kN], positions: [0, 3]}
bridge: {length: 20, modes: 1, right: {youngs_modulus: 35 GPa, second_moment: 0.5, mass_per_length: 15 t/m,
  damping: {ratio: 1 %}}}
solver: {method: exact, sampling: 0.01}
sweep: {velocity: [40, 50, 60]}
"""
NO_UTF8 = os.fsdecode(b"r\xff.h5")
MARKS = "r\x1b[31m\t\u202ex\n.h5"


@pytest.fixture(scope="module")
def solved(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the case, its results, and those of two shards."""
    folder = tmp_path_factory.mktemp("solved")
    (folder / "case.yaml").write_text(CASE)
    for arguments in (("-o", "good.h5"), *(("-o", f"s{n}.h5", "--shard", f"{n}/2") for n in (1, 2))):
        ended = forked("run", "case.yaml", "-q", *arguments, folder=folder)
        assert ended.code == 0, ended
    return folder


@pytest.fixture
def place(solved: Path, tmp_path: Path) -> Iterator[Path]:
    """A copy, beside which folders have all modes."""
    place = shutil.copytree(solved, tmp_path / "place")
    shutil.copy(place / "good.h5", place / "locked.h5")
    (place / "locked.h5").chmod(0)
    for name, mode in (("closed", 0), ("read", 0o500)):
        (place / name).mkdir()
        shutil.copy(place / "good.h5", place / name / "r.h5")
        (place / name).chmod(mode)
    yield place
    for name in ("closed", "read"):
        (place / name).chmod(0o700)


def below(folder: Path) -> set[Path]:
    return set(folder.rglob("*"))


def message(ended: Died) -> str:
    """The one line that a refused command prints."""
    assert (ended.code, ended.out) == (2, b""), ended
    text = ended.err.decode("utf-8")
    assert text.endswith("\n")
    assert text[:-1].isprintable(), ended
    return text[:-1]


REFUSED = [
    ("run case.yaml -o", "/", "/: is a folder, not a results file"),
    ("status", "/", "/: is a folder, not a results file"),
    ("merge s1.h5 s2.h5 -o", "/", "/: is a folder, not a results file"),
    ("submit case.yaml -o", "/", "sbatch: not found; is this a machine from which jobs are sent to Slurm?"),
    ("export", ".", "{place}: is a folder, not a results file"),
    ("status", "r\0", None),
    ("run case.yaml -o", "x" * 252, "{place}/" + "x" * 252 + ".parts: File name too long"),
    ("export good.h5 -o", "x" * 300, "x" * 300 + ": File name too long"),
    ("info", "/".join(["d" * 50] * 100), None),
    ("info", NO_UTF8, r"{place}/r\xff.h5: No such file or directory"),
    ("info", MARKS, r"{place}/r\x1b[31m\x09\u202ex\x0a.h5: No such file or directory"),
    ("status", MARKS, r"r\x1b[31m\x09\u202ex\x0a.h5: nothing has been computed yet"),
    ("submit case.yaml --dry-run -o", NO_UTF8, None),
    ("status", "closed/r.h5", "{place}/closed/r.h5: Permission denied"),
    ("export", "closed/r.h5", "{place}/closed/r.h5: Permission denied"),
    ("export good.h5 -o", "closed/r", "closed/r: Permission denied"),
    ("merge s1.h5", "closed/r.h5 -o m.h5", "{place}/closed/r.h5: Permission denied"),
    ("run case.yaml -o", "closed/r.h5", "{place}/closed/r.h5: Permission denied"),
    ("run case.yaml -o", "read/new.h5", "{place}/read/new.h5: the folder {place}/read cannot be written to"),
    ("info", "locked.h5", "{place}/locked.h5: Permission denied"),
    ("run case.yaml --resume -o", "locked.h5", "{place}/locked.h5: Permission denied"),
    ("report good.h5 --formats png -o", "read/new", "read/new: Permission denied"),
    ("init", "read/new", "read/new/case.yaml: Permission denied"),
    ("reproduce good.h5 -o", "read/new", "read/new: Permission denied"),
]


@pytest.mark.parametrize(("command", "path", "text"), REFUSED, ids=range(len(REFUSED)))
def test_refused(place: Path, command: str, path: str, text: str | None) -> None:
    before = below(place)
    words = path.split(" ") if " -o " in path else [path]
    ended = forked(*command.split(), *words, folder=place)
    if text is not None and not (text.startswith("sbatch") and shutil.which("sbatch")):
        assert message(ended) == text.format(place=place)
    else:
        message(ended)
    assert below(place) == before


@pytest.mark.parametrize("name", [NO_UTF8, MARKS, "é" * 122 + ".h5", "n" * 246 + ".h5"], ids=range(4))
def test_a_name_of_any_kind_that_the_disk_takes(place: Path, name: str) -> None:
    """Made, read and exported; temporary names stay within what a name may be."""
    ended = forked("run", "case.yaml", "-o", name, folder=place)
    assert ended.code == 0, ended
    lines = ended.out.decode("utf-8").rstrip("\n").split("\n")
    assert all(line.isprintable() for line in lines)
    assert lines[-1].endswith(printable(name.rpartition("\n")[2]))
    with h5py.File(os.fsencode(place / name), "r") as file:
        assert file.attrs["command"].isprintable()
    for command in (("status",), ("info",), ("export",), ("merge", "-o", "m.h5")):
        ended = forked(command[0], name, *command[1:], folder=place)
        assert ended.code == (2 if command[0] == "merge" else 0), ended
        assert all(line.isprintable() for line in ended.out.decode("utf-8").split("\n"))
    assert not [path for path in below(place) if "unfinished" in path.name or path.name.endswith(".parts")]


def test_an_unreadable_lock_is_somebodys(place: Path) -> None:
    """Of another user, who may be writing: it is not taken over."""
    folder = place / "r.h5.parts"
    folder.mkdir()
    (folder / "lock").write_text("{}")
    (folder / "lock").chmod(0)
    assert (
        message(forked("run", "case.yaml", "-o", "r.h5", folder=place)) == f"{folder}/lock: Permission denied"
    )
    assert (folder / "lock").exists()


def test_a_report_of_what_is_not_solved_in_full(place: Path) -> None:
    """A shard lacks whole curves, each with marks of its own."""
    histories = "output.histories={channels: [right_midspan], every: 0.05 s}"
    shard = ("--set", histories, "--shard", "1/2", "-o", "part.h5", "-q")
    assert forked("run", "case.yaml", *shard, folder=place).code == 0
    ended = forked("report", "part.h5", "--formats", "png", "-q", folder=place)
    assert (ended.code, ended.err) == (0, b"")


@given(st.text(st.characters(codec=None)))  # lone surrogates too
def test_printable(text: str) -> None:
    shown = printable(text)
    assert shown.isprintable()
    assert printable(shown) == shown
    assert shown == text or not text.isprintable()
    shown.encode("utf-8")
    assert str(UserError(text)) == shown


def test_each_kind_of_what_cannot_be_printed() -> None:
    assert printable("a\tb\nc\x1b[2J\x85 \u202e\U000e0041 \udcff\ud800") == (
        r"a\x09b\x0ac\x1b[2J\x85 \u202e\U000e0041 \xff\ud800"
    )
    assert printable("Brücke 橋 α²") == "Brücke 橋 α²"
