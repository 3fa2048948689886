#!/usr/bin/env python
"""Plants faults in the code, one at a time, and runs the tests that must notice: what lives is a gap.

    python scripts/mutate.py                 all faults, two at a time (about an hour of two cores)
    python scripts/mutate.py kernel lock     those whose name or file contains a word
    python scripts/mutate.py --check         whether every fault's place and tests are still there; runs none
    python scripts/mutate.py --markdown FILE the table of docs/VERIFICATION.md as well

The faults are data: scripts/mutation/*.toml, a file a room, each fault with its name, the file, the text
before and after, and the tests that must fail.  Ends with exit code 1 if a fault lives, and with 2, before
anything is run, if the text of one is not found exactly once, or one of its tests is not there: whoever
rewrites a place moves its fault along.
"""

from __future__ import annotations

import argparse
import os
import queue
import shutil
import subprocess
import sys
import tempfile
import threading
import time
import tomllib
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
COPIED = (
    "tbi_cli",
    "tests",
    "scripts",
    "configs",
    "docs",
    ".ci",
    "pyproject.toml",
    "README.md",
    "CHANGELOG.md",
)
PATIENCE = 900.0  # seconds; a fault that makes a test hang is noticed as well


@dataclass(frozen=True)
class Fault:
    """One planted fault: `before` becomes `after` in `file`, and one of `tests` must fail."""

    room: str
    name: str
    file: str
    before: str
    after: str
    tests: tuple[str, ...]

    def planted(self, tree: Path) -> tuple[Path, str]:
        """The file in a checkout, and its text with the fault."""
        path = tree / self.file
        text = path.read_text(encoding="utf-8") if path.exists() else ""
        if (count := text.count(self.before)) != 1 or self.before == self.after:
            raise LookupError(
                f"{self.room}: {self.name}: `before` is {count} times in {self.file}, expected once"
            )
        return path, text.replace(self.before, self.after)


def faults() -> list[Fault]:
    """All planted faults, by room."""
    found = []
    for file in sorted((ROOT / "scripts" / "mutation").glob("*.toml")):
        for name, entry in tomllib.loads(file.read_text(encoding="utf-8")).items():
            found.append(
                Fault(file.stem, name, entry["file"], entry["before"], entry["after"], tuple(entry["tests"]))
            )
    return found


def surroundings(tree: Path) -> dict[str, str]:
    """The environment of the tests of a checkout; kernels of faulty code are kept beside it alone."""
    return {**os.environ, "PYTHONPATH": str(tree), "TBI_CACHE_DIR": str(tree.parent / "kernels")}


def notices(fault: Fault, tree: Path) -> tuple[str, float]:
    """killed, lives or what went wrong; and the seconds that it took."""
    path, text = fault.planted(tree)
    whole = path.read_text(encoding="utf-8")
    quick = ("-x", "-q", "-p", "no:cacheprovider", "--hypothesis-profile=any-failure")
    command = [sys.executable, "-m", "pytest", *quick, *fault.tests]
    environment = surroundings(tree) | {"PYTHONDONTWRITEBYTECODE": "1"}
    begin = time.monotonic()
    path.write_text(text, encoding="utf-8")
    try:
        run = subprocess.run(
            command, cwd=tree, env=environment, capture_output=True, text=True, timeout=PATIENCE, check=False
        )
        # Anything else, such as a test that is not there, is a mistake in the data.
        found = {0: "lives", 1: "killed"}.get(run.returncode, f"wrong: {run.stdout}{run.stderr}")
    except subprocess.TimeoutExpired:
        found = "killed"
    finally:
        path.write_text(whole, encoding="utf-8")
    return found, time.monotonic() - begin


def copied(tree: Path) -> Path:
    """The working tree's files, in a new folder."""
    tree.mkdir()
    for name in COPIED:
        source = ROOT / name
        if source.is_dir():
            shutil.copytree(source, tree / name, ignore=shutil.ignore_patterns("__pycache__"))
        else:
            shutil.copy(source, tree / name)
    return tree


def tests_of(wanted: list[Fault]) -> list[str]:
    """The tests of some faults, each once."""
    return sorted({test for fault in wanted for test in fault.tests})


def check_tests_are_there(wanted: list[Fault]) -> None:
    """Exits unless every test has the name by which it is called here."""
    tests = tests_of(wanted)
    files = sorted({test.partition("::")[0] for test in tests})
    run = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "--collect-only", "-p", "no:cacheprovider", *files],
        cwd=ROOT,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=False,
    )
    there = run.stdout.splitlines()
    absent = [
        test
        for test in tests
        if not any(line == test or line.startswith((f"{test}[", f"{test}::")) for line in there)
    ]
    if run.returncode or absent:
        print("\n".join([run.stderr, *(f"{test}: no such test" for test in absent)]), file=sys.stderr)
        sys.exit(2)


def check_without_faults(wanted: list[Fault], tree: Path, jobs: int) -> None:
    """Exits unless all the tests pass where nothing is wrong: else every fault would seem noticed."""
    command = [sys.executable, "-m", "pytest", "-q", "-n", str(jobs), "-p", "no:cacheprovider"]
    environment = surroundings(tree)
    run = subprocess.run(
        [*command, *tests_of(wanted)], cwd=tree, env=environment, capture_output=True, text=True, check=False
    )
    if run.returncode:
        print(f"{run.stdout}{run.stderr}\nthe tests fail where no fault is planted", file=sys.stderr)
        sys.exit(2)


def all_noticed(wanted: list[Fault], jobs: int) -> dict[Fault, tuple[str, float]]:
    """What becomes of each fault, tried in copies of the working tree side by side."""
    todo: queue.SimpleQueue[Fault] = queue.SimpleQueue()
    for fault in wanted:
        todo.put(fault)
    results: dict[Fault, tuple[str, float]] = {}

    def work(tree: Path) -> None:
        while True:
            try:
                fault = todo.get_nowait()
            except queue.Empty:
                return
            results[fault] = notices(fault, tree)
            print(f"{results[fault][0]:8}{results[fault][1]:6.0f} s  {fault.room}: {fault.name}", flush=True)

    with tempfile.TemporaryDirectory() as folder:
        trees = [copied(Path(folder, f"{number}")) for number in range(jobs)]
        check_without_faults(wanted, trees[0], jobs)
        workers = [threading.Thread(target=work, args=(tree,)) for tree in trees]
        for worker in workers:
            worker.start()
        for worker in workers:
            worker.join()
    return {fault: results[fault] for fault in wanted}


def markdown(results: dict[Fault, tuple[str, float]]) -> str:
    """A table of rooms: how many faults were planted and noticed, and what lived."""
    planted = Counter(fault.room for fault in results)
    lived = [fault for fault, (found, _) in results.items() if found != "killed"]
    lines = ["| room | planted | noticed | lived |", "| --- | --- | --- | --- |"]
    for room, count in planted.items():
        names = [fault.name for fault in lived if fault.room == room]
        lines.append(f"| {room} | {count} | {count - len(names)} | {'; '.join(names)} |")
    lines.append(f"| all | {len(results)} | {len(results) - len(lived)} | |")
    return "\n".join(lines) + "\n"


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("words", nargs="*", help="only faults whose name, room or file contains one of these")
    parser.add_argument("-j", "--jobs", type=int, default=2, help="how many side by side (default: 2)")
    parser.add_argument(
        "--check", action="store_true", help="only look whether every place and test is there"
    )
    parser.add_argument("--markdown", type=Path, help="a file for the table")
    arguments = parser.parse_args()
    wanted = [
        fault
        for fault in faults()
        if not arguments.words
        or any(word in f"{fault.room}: {fault.name} {fault.file}" for word in arguments.words)
    ]
    wrong = []
    for fault in wanted:
        try:
            fault.planted(ROOT)
        except LookupError as error:
            wrong.append(str(error))
    if wrong:
        print("\n".join(wrong), file=sys.stderr)
        sys.exit(2)
    check_tests_are_there(wanted)
    if arguments.check:
        print(f"{len(wanted)} faults, every place and every test is there")
        return
    results = all_noticed(wanted, arguments.jobs)
    killed = sum(found == "killed" for found, _ in results.values())
    if arguments.markdown is not None:
        arguments.markdown.write_text(markdown(results), encoding="utf-8")
    spent = os.times()
    minutes = (spent.children_user + spent.children_system) / 60
    print(f"{killed} of {len(results)} noticed, in {minutes:.0f} minutes of one processor")
    sys.exit(0 if killed == len(results) else 1)


if __name__ == "__main__":
    main()
