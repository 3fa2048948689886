"""What may be in the way of `tbi submit`: one message, nothing sent, nothing left behind."""

from __future__ import annotations

import json
import os
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.cli.commands import Ended, everything_below
from tests.cluster.fake_slurm import fake_slurm
from tests.cluster.runs import inside


def sent(folder: Path, *arguments: str, results: str = "r.h5", **answers: bytes) -> Ended:
    """Sends the case to a Slurm that gives these answers."""
    place = folder.parent / f"bin-{'-'.join(answers)}"
    if not place.exists():
        fake_slurm(place, **answers)
    path = f"{place}:{os.environ['PATH']}"
    return inside("submit", "case.yaml", "-o", results, "--shards", "2", *arguments, folder=folder, PATH=path)


def refused(folder: Path, text: str, *arguments: str, results: str = "r.h5", **answers: bytes) -> None:
    before = everything_below(folder), set(folder.rglob("*"))
    ended = sent(folder, *arguments, results=results, **answers)
    assert (ended.code, ended.out, ended.err) == (2, "", f"{text}\n")
    assert (everything_below(folder), set(folder.rglob("*"))) == before


@pytest.fixture
def folder(folder: Path) -> Path:
    """A folder below another, in which there is room for Slurm."""
    inner = folder / "run"
    inner.mkdir()
    (folder / "case.yaml").rename(inner / "case.yaml")
    return inner


def _a_file(path: Path) -> None:
    path.parent.mkdir(exist_ok=True)
    path.touch()


IN_THE_WAY: dict[str, tuple[Callable[[Path], object], str]] = {
    "r-slurm": (_a_file, "File exists"),
    "r-slurm/shards": (_a_file, "File exists"),
    "r-slurm/log": (_a_file, "File exists"),
    "r-slurm/case.yaml": (lambda path: path.mkdir(parents=True), "Is a directory"),
    "r-slurm/merge.sh": (lambda path: path.mkdir(parents=True), "Is a directory"),
    "r-slurm/submission.json": (lambda path: path.mkdir(parents=True), "Is a directory"),
}


@pytest.mark.parametrize("name", IN_THE_WAY)
def test_something_in_the_way(folder: Path, name: str) -> None:
    make, why = IN_THE_WAY[name]
    make(folder / name)
    ended = sent(folder)
    assert (ended.code, ended.out, ended.err) == (2, "", f"{folder / name}: {why}\n")


def test_no_folder(folder: Path) -> None:
    refused(folder, f"{folder}/no/r.h5: the folder {folder}/no does not exist", results="no/r.h5")
    refused(folder, f"{folder}/case.yaml/r.h5: {folder}/case.yaml is not a folder", results="case.yaml/r.h5")
    refused(folder, "/: is a folder; name a file in it", results="/")
    awkward = repr(str(folder / "r\t.h5"))
    text = f"{awkward}: quotes, backslashes and what cannot be printed confuse Slurm"
    refused(folder, text, results="r\t.h5")


ANSWERS = {
    "in bytes": (
        b"!\xff\x1b[31m no\tsuch\npartition \xe2\x80\xaex",
        r"sbatch: \xff\x1b[31m no such partition \u202ex",
    ),
    "no number": (
        b"Submitted\x07 batch job 17\n",
        r"sbatch: expected the number of a job, got Submitted\x07 batch job 17",
    ),
    "no word": (b"", "sbatch: expected the number of a job, got nothing"),
    "without end": (b"!" + b"x" * 10**6, "sbatch: " + "x" * 1000 + "..."),
}


@pytest.mark.parametrize("answer", ANSWERS)
def test_what_sbatch_says(folder: Path, answer: str) -> None:
    said, text = ANSWERS[answer]
    ended = sent(folder, sbatch=said)
    assert (ended.code, ended.out, ended.err) == (2, "", f"{text}\n")
    assert not (folder / "r-slurm" / "submission.json").exists()


def test_other_answers_in_bytes(folder: Path) -> None:
    ended = sent(folder, scontrol=b"MaxArraySize = 9999999999999999999\nx = \xff\xfe\n")
    assert (ended.code, ended.err) == (0, "")
    refused(folder, "squeue: \\xff", "--resume", squeue=b"!\xff")


def test_no_inodes_are_left(folder: Path) -> None:
    """Bytes there are, but no more files can be made."""
    disk = folder / "disk"
    disk.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=1m,nr_inodes=3", "tmpfs", str(disk)]
    done = subprocess.run(mount, capture_output=True, text=True, check=False)
    if done.returncode:
        pytest.skip(f"cannot mount a small file system here: {done.stderr.strip()}")
    try:
        refused(folder, f"{disk}/r-slurm/shards: No space left on device", results="disk/r.h5")
    finally:
        subprocess.run(["umount", str(disk)], check=True)


NOTES = {
    "no JSON": "{",
    "too deep": "[" * 100_000,
    "no shards": '{"jobs": {}}',
    "a text of shards": '{"shards": "2", "jobs": {}}',
    "half a shard": '{"shards": 2.5, "jobs": {}}',
    "NaN": '{"shards": NaN, "jobs": {}}',
    "without end": '{"shards": 1e999, "jobs": {}}',
    "huge": '{"shards": 1' + "0" * 30 + ', "jobs": {}}',
    "of more digits than Python reads": '{"shards": 1' + "0" * 5000 + ', "jobs": {}}',
    "negative": '{"shards": -1, "jobs": {}}',
    "jobs in a list": '{"shards": 2, "jobs": [[1, 2]]}',
    "a job that is an option": '{"shards": 2, "jobs": {"shard": "--all"}}',
    "another kind": "[1]",
    "too large": '{"shards": 2, "jobs": {}, "x": "' + "x" * 10**6 + '"}',
}


@pytest.mark.parametrize("note", NOTES.values(), ids=NOTES)
def test_a_note_that_tbi_did_not_write(folder: Path, note: str) -> None:
    (folder / "r-slurm").mkdir()
    (folder / "r-slurm" / "submission.json").write_text(note)
    for command in (("status", "r.h5"), ("status", "case.yaml", "-o", "r.h5")):
        ended = inside(*command, folder=folder)
        assert (ended.code, ended.out) == (2, "")
        assert ended.err.startswith(f"{folder}/r-slurm/submission.json: ")
        assert ended.err.count("\n") == 1
    assert sent(folder, "--resume").err == ended.err


def test_more_shards_than_anyone_sends(folder: Path) -> None:
    """Told at once, not counted one by one."""
    (folder / "r-slurm").mkdir()
    (folder / "r-slurm" / "submission.json").write_text(json.dumps({"shards": 999_999, "jobs": {}}))
    ended = inside("status", "case.yaml", "-o", "r.h5", folder=folder)
    assert (ended.code, ended.err) == (2, "r.h5: expected at most 1000 shards, got 999999\n")
    ended = inside("status", "r.h5", folder=folder)
    assert (ended.code, ended.err) == (2, "r.h5: nothing has been computed yet\n")
