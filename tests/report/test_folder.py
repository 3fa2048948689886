"""A new report replaces an earlier one and nothing else, whatever the folder holds."""

from __future__ import annotations

import contextlib
import json
import os
import signal
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tbi_cli.report.errors import ReportError
from tbi_cli.report.folder import MARKER, check_folder, report_folder
from tests.cli.commands import everything_below


def write(folder: Path, **files: str) -> None:
    with report_folder(folder) as scratch:
        for name, text in files.items():
            (scratch / f"{name}.txt").write_text(text)


def names(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()} - {MARKER}


def test_a_new_report_replaces_the_earlier_one_and_keeps_the_users_files(tmp_path: Path) -> None:
    folder = tmp_path / "report"
    write(folder, fig15="old", fig16="old")
    (folder / "my notes.md").write_text("mine")
    write(folder, fig15="new", fig17="new")
    assert names(folder) == {"fig15.txt", "fig17.txt", "my notes.md"}
    assert (folder / "fig15.txt").read_text() == "new"
    assert names(tmp_path) == {"report"}


@pytest.mark.parametrize("marker", [None, "", "{}", '{"kind": "other", "files": []}', "[1]", "not json"])
def test_a_folder_that_is_no_report_is_refused_untouched(tmp_path: Path, marker: str | None) -> None:
    (tmp_path / "thesis").mkdir()
    (tmp_path / "thesis" / "chapter.tex").write_text("years of work")
    if marker is not None:
        (tmp_path / "thesis" / MARKER).write_text(marker)
    before = everything_below(tmp_path)
    with pytest.raises(ReportError, match="got other files; nothing was touched"):
        write(tmp_path / "thesis", fig15="new")
    assert everything_below(tmp_path) == before


def test_a_file_in_the_way_is_refused(tmp_path: Path) -> None:
    (tmp_path / "report").write_text("a file")
    with pytest.raises(ReportError, match="expected a folder for the report, got a file"):
        check_folder(tmp_path / "report")


def test_an_empty_folder_is_taken(tmp_path: Path) -> None:
    (tmp_path / "report").mkdir()
    write(tmp_path / "report", fig15="new")
    assert names(tmp_path / "report") == {"fig15.txt"}


def test_a_marker_cannot_reach_outside(tmp_path: Path) -> None:
    folder = tmp_path / "report"
    write(folder, fig15="old")
    (tmp_path / "precious").write_text("keep me")
    (folder / "sub").mkdir()
    evil = ["../precious", str(tmp_path / "precious"), "..", ".", "", "sub", "a/b", "nul\0", 7, None]
    (folder / MARKER).write_text(json.dumps({"kind": "tbi-report", "files": evil}))
    write(folder, fig16="new")
    assert (tmp_path / "precious").read_text() == "keep me"
    assert names(folder) == {"fig15.txt", "fig16.txt", "sub"}


def test_a_link_to_a_marker_is_no_marker(tmp_path: Path) -> None:
    write(tmp_path / "report", fig15="old")
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / MARKER).symlink_to(tmp_path / "report" / MARKER)
    with pytest.raises(ReportError):
        check_folder(tmp_path / "other")


def test_a_failure_leaves_the_earlier_report(tmp_path: Path) -> None:
    folder = tmp_path / "report"
    write(folder, fig15="old")
    before = everything_below(tmp_path)
    with pytest.raises(KeyError), report_folder(folder) as scratch:
        (scratch / "fig15.txt").write_text("half")
        raise KeyError
    assert everything_below(tmp_path) == before


@given(
    st.lists(st.sets(st.sampled_from("abcdef"), min_size=1), min_size=1, max_size=4),
    st.sets(st.sampled_from("xyz")),
)
def test_after_any_sequence_of_reports_the_last_one_and_the_users_files_are_there(
    tmp_path_factory: pytest.TempPathFactory, reports: list[set[str]], own: set[str]
) -> None:
    folder = tmp_path_factory.mktemp("any") / "report"
    write(folder, first="made")
    for name in own:
        (folder / f"{name}.txt").write_text("mine")
    for report in reports:
        write(folder, **dict.fromkeys(report, "made"))
    assert names(folder) == {f"{name}.txt" for name in reports[-1] | own}


def test_what_a_kill_leaves_is_swept_and_what_lives_is_not(tmp_path: Path) -> None:
    """A report that is being made, one that was killed, and folders of others whose names are like it."""
    others = [".report-mine", ".report-12345678x", ".report2-abcdefgh", "report-abcdefgh"]
    for name in others:
        (tmp_path / name).mkdir()
    (tmp_path / ".report-linked__").symlink_to(tmp_path / others[0])
    ready, done = os.pipe()
    child = os.fork()
    if child == 0:
        with contextlib.suppress(BaseException), report_folder(tmp_path / "report") as scratch:
            (scratch / "half").touch()
            os.write(done, scratch.name.encode())
            signal.pause()
        os._exit(0)
    try:
        killed = tmp_path / os.read(ready, 100).decode()
        with report_folder(tmp_path / "report") as scratch:
            (scratch / "fig15.txt").touch()
            assert killed.exists()  # it lives
            os.kill(child, signal.SIGKILL)
            os.waitpid(child, 0)
            child = 0
            assert killed.exists()
            with report_folder(tmp_path / "report"):
                assert not killed.exists()
                assert scratch.exists()
    finally:
        if child:
            os.kill(child, signal.SIGKILL)
            os.waitpid(child, 0)
    assert names(tmp_path) == {*others, ".report-linked__", "report"}


def test_names_as_long_as_can_be(tmp_path: Path) -> None:
    write(tmp_path / ("橋" * 85), fig15="of three bytes each")
    assert names(tmp_path) == {"橋" * 85}
