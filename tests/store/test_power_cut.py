"""Durable by order: write, sync, rename, sync of the folder; and a power cut after any call loses nothing."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest

from tbi_cli.store import ResultsStore, merge
from tests.store.example import batch, batches, content, layout, solve
from tests.store.power_cut import Call, Disk, State, check_order, record, restore

pytestmark = pytest.mark.skipif(
    not shutil.which("strace"), reason="no strace here; Debian: apt-get install strace"
)

HEAD = """
import sys
from pathlib import Path
from tests.store.example import batch, batches, layout, solve
from tbi_cli.store import ResultsStore, merge
from tbi_cli.store.durable import write_text
folder = Path(sys.argv[1])
OF = layout(shape=(2, 6), channels=3, histories=2)
"""
OF = layout(shape=(2, 6), channels=3, histories=2)
SHARDS = [layout(shape=(2, 6), channels=3, histories=2, shard=f"{k}/2") for k in (1, 2)]
# The lock says who writes; it is worth nothing after a restart, and is not synced.
TEMPORARY = re.compile(r"\.unfinished$|/lock\.[0-9a-f]+$")


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """What an undisturbed run gives."""
    path = tmp_path_factory.mktemp("whole") / "r.h5"
    solve(path, OF)
    return content(path)


def played(folder: Path, calls: list[Call]) -> list[tuple[int, str, State]]:
    """Every state that a power cut may leave, with the number of calls before it.

    States that differ only in what an unfinished file holds, which nobody reads, are taken once.
    """
    found: dict[State, tuple[int, str, State]] = {}
    disk = Disk(folder)
    for number, call in enumerate(calls, 1):
        disk.play(call)
        for which, state in disk.states():
            kind = tuple((path, b"" if TEMPORARY.search(path) else content) for path, content in state)
            found.setdefault(kind, (number, which, state))
    return list(found.values())


def durable_cases(calls: list[Call]) -> int:
    """How many cases the parts hold that have their names for good."""
    parts, pending = 0, 0
    for call in calls:
        if call.name == "rename" and re.search(r"parts/\d+\.h5$", call.paths[1]):
            pending += 1
        elif call.name == "fsync" and call.paths[0].endswith(".parts"):
            parts, pending = parts + pending, 0
    return 4 * parts


def test_a_run_and_its_resumption(tmp_path: Path, whole: dict[str, bytes]) -> None:
    """One batch into a results file, then the rest; resumed from any instant it gives the same bits."""
    folder = tmp_path / "run"
    folder.mkdir()
    first = """
with ResultsStore(folder / "r.h5", OF) as store:
    store.write(batch(OF, batches(OF)[0]))
    store.finish()
"""
    begun = record(HEAD + first, folder, tmp_path / "first.log")
    assert check_order(begun, TEMPORARY) == ["r.h5.parts/layout.json", "r.h5.parts/000000.h5", "r.h5"]
    resumed = tmp_path / "resumed"
    resumed.mkdir()
    (resumed / "r.h5").write_bytes((folder / "r.h5").read_bytes())
    rest = record(HEAD + "solve(folder / 'r.h5', OF)", resumed, tmp_path / "rest.log")
    assert check_order(rest, TEMPORARY)[-1] == "r.h5"
    assert content(resumed / "r.h5") == whole

    empty = tmp_path / "empty"
    empty.mkdir()
    states = [(begun, 0, *state) for state in played(empty, begun)]
    states += [(rest, 4, *state) for state in played(folder, rest)]
    assert len(states) > 30
    for k, (calls, before, number, which, state) in enumerate(states):
        here = tmp_path / f"{k}"
        restore(state, here)
        path = here / "r.h5"
        with ResultsStore(path, OF, resume=True) as store:
            done = int(store.done().sum())
        assert done >= before + durable_cases(calls[:number]), f"{which}, call {number}: {calls[number - 1]}"
        solve(path, OF)
        assert content(path) == whole, f"{which}, call {number}: {calls[number - 1]}"
        assert [entry.name for entry in here.iterdir()] == ["r.h5"]


def test_a_merge(tmp_path: Path, whole: dict[str, bytes]) -> None:
    """The file is there as a whole or not at all; the shards stay; merging again gives the same bits."""
    folder = tmp_path / "shards"
    folder.mkdir()
    for k, (shard, own) in enumerate(zip(SHARDS, (batches(OF)[:2], batches(OF)[2:]), strict=True)):
        with ResultsStore(folder / f"{k}.h5", shard) as store:
            for indices in own:
                store.write(batch(OF, indices))
            store.finish()
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    merged = tmp_path / "merged"
    restore(tuple(before.items()), merged)
    calls = record(
        HEAD + "merge([folder / '0.h5', folder / '1.h5'], folder / 'r.h5')", merged, tmp_path / "log"
    )
    assert check_order(calls, TEMPORARY) == ["r.h5"]
    states = played(folder, calls)
    assert len(states) > 10
    for k, (number, which, state) in enumerate(states):
        here = tmp_path / f"{k}"
        restore(state, here)
        path = here / "r.h5"
        assert not path.exists() or content(path) == whole, f"{which}, call {number}: {calls[number - 1]}"
        assert {name: (here / name).read_bytes() for name in before} == before
        merge([here / "0.h5", here / "1.h5"], path, overwrite=True)
        assert content(path) == whole


def test_a_text(tmp_path: Path) -> None:
    """As the note of a submission: the old text or the new one, whatever happens."""
    folder = tmp_path / "notes"
    restore((("note.json", b"old"),), folder)
    calls = record(HEAD + "write_text(folder / 'note.json', 'new ' * 5000)", folder, tmp_path / "log")
    assert check_order(calls, TEMPORARY) == ["note.json"]
    begin = tmp_path / "begin"
    restore((("note.json", b"old"),), begin)
    last = None
    for _, which, state in played(begin, calls):
        last = dict(state)["note.json"]
        assert last in (b"old", b"new " * 5000), which
    assert last == b"new " * 5000


def test_the_command(tmp_path: Path) -> None:
    """`tbi run` of two studies with two threads: every file in order, and no other file is written."""
    folder = tmp_path / "run"
    folder.mkdir()
    command = """
import sys
from tbi_cli.__main__ import main
studies = "studies={a: {sweep: {velocity: [60, 70]}}, b: {sweep: {bridge.modes: [2, 3]}}}"
sys.argv[:] = ["tbi", "run", "paper", "-j2", "-o", sys.argv[1] + "/r.h5", "--set", "solver.duration=0.1"]
sys.argv += ["--set", studies]
main()
"""
    taken = check_order(record(command, folder, tmp_path / "log"), TEMPORARY)
    assert taken[0] == "r.h5.parts/studies.json" and taken[-1] == "r.h5"
    names = [f"r.h5.parts/{study}/{name}" for study in "ab" for name in ("layout.json", "000000.h5")]
    assert set(names) <= set(taken)
    assert [path.name for path in folder.iterdir()] == ["r.h5"]
