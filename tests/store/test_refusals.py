"""What is refused leaves the disk as it was, and says why in one line."""

from __future__ import annotations

import os
import resource
import shutil
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest

from tbi_cli.store import Layout, ResultsStore, StoreError, check_output, open_results
from tests.store.example import batch, batches, content, layout


def tree(folder: Path) -> dict[str, bytes]:
    """All files below a folder, with what is in them."""
    return {str(p.relative_to(folder)): p.read_bytes() if p.is_file() else b"" for p in folder.rglob("*")}


def refusal(act: Callable[[], object]) -> str:
    """The message that ``act`` is refused with: one line, nothing unprintable."""
    with pytest.raises(StoreError) as caught:
        act()
    message = str(caught.value)
    assert message.isprintable()
    return message


def finished(path: Path, of: Layout, cases: int = 15) -> Path:
    """A results file of the first cases."""
    with ResultsStore(path, of) as store:
        store.write(batch(of, range(cases)))
        return store.finish()


def interrupted(path: Path, of: Layout, cases: int = 4) -> None:
    """A run that stopped after its first cases."""
    with ResultsStore(path, of) as store:
        store.write(batch(of, range(cases)))


def test_an_existing_file(tmp_path: Path) -> None:
    path = finished(tmp_path / "results.h5", layout())
    before = tree(tmp_path)
    assert refusal(lambda: ResultsStore(path, layout())) == (
        f"{path}: exists already; --resume completes it, --overwrite replaces it"
    )
    assert refusal(lambda: check_output(path)) == refusal(lambda: ResultsStore(path, layout()))
    assert tree(tmp_path) == before


def test_an_unfinished_run(tmp_path: Path) -> None:
    path = tmp_path / "results.h5"
    interrupted(path, layout())
    before = tree(tmp_path)
    assert refusal(lambda: ResultsStore(path, layout())) == (
        f"{path}.parts: holds an unfinished run, 4 of 15 cases; "
        "--resume continues it, --overwrite starts afresh"
    )
    assert tree(tmp_path) == before


def test_a_run_that_finished_nothing_is_in_nobodys_way(tmp_path: Path) -> None:
    path = tmp_path / "results.h5"
    ResultsStore(path, layout()).close()
    assert tree(tmp_path) == {}
    with ResultsStore(path, layout()):
        shutil.copytree(f"{path}.parts", f"{tmp_path}/killed.h5.parts", ignore=lambda *_: ["lock"])
    for options in ({"resume": True}, {}):
        with ResultsStore(tmp_path / "killed.h5", layout(sha256="2" * 64), **options) as store:
            assert not store.done().any()


def test_resume_and_overwrite_together(tmp_path: Path) -> None:
    message = refusal(lambda: ResultsStore(tmp_path / "r.h5", layout(), resume=True, overwrite=True))
    assert message == "--resume and --overwrite exclude each other"


@pytest.mark.parametrize("resume", [True, False])
def test_with_nothing_there_resume_and_overwrite_start_afresh(tmp_path: Path, resume: bool) -> None:
    with ResultsStore(tmp_path / "r.h5", layout(), resume=resume, overwrite=not resume) as store:
        assert not store.done().any()


@pytest.mark.parametrize("unfinished", [True, False])
def test_resuming_another_case_names_the_keys(tmp_path: Path, unfinished: bool) -> None:
    path = tmp_path / "results.h5"
    (interrupted if unfinished else finished)(path, layout())
    before = tree(tmp_path)
    other = layout(
        case="title: an example\nbridge:\n  length: 60.0\n  span: 3\n  modes: 4\n", sha256="2" * 64
    )
    where = f"{path}.parts" if unfinished else f"{path}"
    assert refusal(lambda: ResultsStore(path, other, resume=True)) == (
        f"{where}: holds another case (bridge.length: 50.0, now 60.0; bridge.span: absent, now 3); "
        "choose another file with -o"
    )
    assert tree(tmp_path) == before


def test_resuming_another_version_or_shard(tmp_path: Path) -> None:
    path = finished(tmp_path / "results.h5", layout(shard="1/3"))
    newer = layout(shard="1/3", tbi_version="0.2.0")
    assert "was written by tbi 0.1.0, this is 0.2.0" in refusal(
        lambda: ResultsStore(path, newer, resume=True)
    )
    assert "is shard 1/3, not 2/3" in refusal(lambda: ResultsStore(path, layout(shard="2/3"), resume=True))
    assert "is shard 1/3, not none" in refusal(lambda: ResultsStore(path, layout(), resume=True))


@pytest.mark.parametrize("text", [b"", b"not HDF5", b"\x89HDF\r\n\x1a\n and then nothing of the kind"])
def test_resuming_something_else(tmp_path: Path, text: bytes) -> None:
    path = tmp_path / "results.h5"
    path.write_bytes(text)
    assert refusal(lambda: ResultsStore(path, layout(), resume=True)).startswith(f"{path}: is ")
    assert tree(tmp_path) == {"results.h5": text}


def test_overwrite_replaces_at_the_end_only(tmp_path: Path) -> None:
    path = finished(tmp_path / "results.h5", layout())
    old = path.read_bytes()
    other = layout(channels=2, sha256="2" * 64)
    with ResultsStore(path, other, overwrite=True) as store:
        store.write(batch(other, range(10)))
        assert path.read_bytes() == old
    assert path.read_bytes() == old  # stopped half-way; the new run waits in its parts
    with ResultsStore(path, other, resume=True) as store:
        assert store.done().sum() == 10
        store.finish()
    with open_results(path) as results:
        assert len(results.channels) == 2
    assert sorted(tree(tmp_path)) == ["results.h5"]


def test_overwrite_forgets_an_unfinished_run(tmp_path: Path) -> None:
    path = tmp_path / "results.h5"
    interrupted(path, layout())
    with ResultsStore(path, layout(), overwrite=True) as store:
        assert not store.done().any()
        store.write(batch(layout(), range(15)))
        store.finish()
    assert content(path) == content(finished(tmp_path / "other.h5", layout()))


def test_overwrite_does_not_take_any_file_for_results(tmp_path: Path) -> None:
    path = tmp_path / "case.yaml"
    path.write_text("title: my only copy\n")
    assert refusal(lambda: ResultsStore(path, layout(), overwrite=True)) == (
        f"{path}: is not a results file, and is not replaced by one"
    )
    assert tree(tmp_path) == {"case.yaml": b"title: my only copy\n"}


def test_places_that_cannot_be(tmp_path: Path) -> None:
    (tmp_path / "folder").mkdir()
    (tmp_path / "file").write_text("")
    os.mkfifo(tmp_path / "pipe.h5")
    (tmp_path / "loop.h5").symlink_to("loop.h5")
    before = sorted(p.name for p in tmp_path.iterdir())
    for name, words in {
        "folder": "is a folder; name a file in it",
        "missing/results.h5": f"the folder {tmp_path / 'missing'} does not exist",
        "file/results.h5": f"{tmp_path / 'file'} is not a folder",
        "pipe.h5": "is not a regular file",
        "loop.h5": "not a usable path",
        "a\0b.h5": "not a usable path",
        "x" * 300 + ".h5": "File name too long",
    }.items():
        for options in ({}, {"resume": True}, {"overwrite": True}):
            message = refusal(lambda n=name, o=options: ResultsStore(tmp_path / n, layout(), **o))
            assert words in message
    assert sorted(p.name for p in tmp_path.iterdir()) == before


def test_a_folder_without_write_permission() -> None:
    user = os.geteuid()
    with TemporaryDirectory() as folder:
        Path(folder).chmod(0o555)
        if user == 0:  # root may write everywhere; be nobody for a moment
            os.seteuid(65534)
        try:
            message = refusal(lambda: ResultsStore(f"{folder}/results.h5", layout()))
        finally:
            os.seteuid(user)
        assert "cannot be written to" in message or "Permission denied" in message
        assert not list(Path(folder).iterdir())


def test_a_folder_that_nobody_can_write_to() -> None:
    """/proc takes no files, from root either."""
    message = refusal(lambda: ResultsStore("/proc/self/results.h5", layout()))
    assert message.startswith("/proc/")


def test_a_link_to_a_results_file_stays_a_link(tmp_path: Path) -> None:
    (tmp_path / "data").mkdir()
    real = finished(tmp_path / "data" / "real.h5", layout(), cases=10)
    link = tmp_path / "results.h5"
    link.symlink_to(real)
    with ResultsStore(link, layout(), resume=True) as store:
        store.write(batch(layout(), range(10, 15)))
        store.finish()
    assert link.is_symlink()
    with open_results(link) as results:
        assert (results.status == 1).all()


@pytest.fixture
def small_files() -> Callable[[int], None]:
    """Limits the size of the files that this process writes; the limit is lifted after the test."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)

    def limit(size: int) -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (size if size >= 0 else before[0], before[1]))

    yield limit  # type: ignore[misc]
    limit(-1)


@pytest.mark.parametrize("limit", [0, 10, 1000])
def test_no_room_to_begin(tmp_path: Path, small_files: Callable[[int], None], limit: int) -> None:
    small_files(limit)
    assert "File too large" in refusal(lambda: ResultsStore(tmp_path / "results.h5", layout()))
    small_files(-1)
    assert tree(tmp_path) == {}


@pytest.mark.parametrize("share", [0.01, 0.3, 0.6, 0.9, 0.99])
def test_no_room_for_a_batch(tmp_path: Path, small_files: Callable[[int], None], share: float) -> None:
    of = layout(histories=3)
    path = tmp_path / "results.h5"
    with ResultsStore(path, of) as store:
        store.write(batch(of, range(4)))
        part = next((tmp_path / "results.h5.parts").glob("*.h5"))
        before = tree(tmp_path)
        small_files(int(share * part.stat().st_size))
        message = refusal(lambda: store.write(batch(of, range(4, 8))))
        assert message == (
            f"{part.with_name('000001.h5')}: File too large; the cases finished before are safe"
        )
        small_files(-1)
        assert tree(tmp_path) == before
        store.write(batch(of, range(4, 15)))
        store.finish()
    assert content(path) == content(finished(tmp_path / "other.h5", of))


@pytest.mark.parametrize("share", [0.001, 0.2, 0.5, 0.8, 0.99])
def test_no_room_for_the_results_file(
    tmp_path: Path, small_files: Callable[[int], None], share: float
) -> None:
    of = layout(histories=3)
    expected = finished(tmp_path / "other.h5", of)
    path = finished(tmp_path / "results.h5", of, cases=8)
    before = path.read_bytes()
    with ResultsStore(path, of, resume=True) as store:
        for indices in batches(of)[2:]:
            store.write(batch(of, indices))
        small_files(int(share * expected.stat().st_size))
        message = refusal(store.finish)
        small_files(-1)
    assert message == (f"{path}: File too large; the finished cases are safe in {path}.parts")
    assert path.read_bytes() == before
    assert not list(tmp_path.rglob("*.unfinished"))
    with ResultsStore(path, of, resume=True) as store:
        assert store.done().all()
        store.finish()
    assert content(path) == content(expected)


def test_a_folder_that_vanishes(tmp_path: Path) -> None:
    folder = tmp_path / "run"
    folder.mkdir()
    with ResultsStore(folder / "results.h5", layout()) as store:
        store.write(batch(layout(), range(4)))
        folder.rename(tmp_path / "gone")
        for act in (lambda: store.write(batch(layout(), range(4, 8))), store.finish):
            assert "was removed or taken over while the run went on" in refusal(act)
    assert not folder.exists()
    (tmp_path / "gone").rename(folder)
    (folder / "results.h5.parts" / "lock").unlink()  # as of a dead process; this one lives on
    with ResultsStore(folder / "results.h5", layout(), resume=True) as store:
        assert store.done().sum() == 4
