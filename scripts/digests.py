#!/usr/bin/env python
"""Whether the built-in cases still have the bits of a given commit: SHA-256 of every table of every case.

    python scripts/digests.py HEAD~3             all built-in cases, by that commit and by the working tree
    python scripts/digests.py v0.1 paper practice/hslm-a

Both are solved in this run, on this machine, with the same libraries.  Ends with exit code 1 if a table
differs, or is in one of the files only.  RENAMED says which names are other ones since.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import h5py
import numpy as np

ROOT = Path(__file__).resolve().parents[1]
# Old name -> new name of groups, channels and axes, as parts of a path in the file.
RENAMED: dict[str, str] = {}


def digests(path: Path) -> dict[str, str]:
    """SHA-256 of every dataset of numbers in a results file, by its path: type, shape and bits."""
    found: dict[str, str] = {}

    def note(name: str, item: object) -> None:
        if isinstance(item, h5py.Dataset) and item.dtype.kind in "iuf":
            values = np.ascontiguousarray(item[...])
            heading = f"{values.dtype.str} {values.shape} ".encode()
            found[name] = hashlib.sha256(heading + values.tobytes()).hexdigest()

    with h5py.File(path) as file:
        file.visititems(note)
    return found


def renamed(name: str) -> str:
    """The name that a dataset has now."""
    return "/".join(RENAMED.get(part, part) for part in name.split("/"))


def cases(tree: Path) -> list[str]:
    """The built-in cases of a checkout, by their names."""
    folder = tree / "configs"
    names = [str(path.relative_to(folder).with_suffix("")) for path in folder.rglob("*.yaml")]
    return sorted(name for name in names if name.split("/")[0] not in ("trains", "bridges", "templates"))


def solved(tree: Path, case: str, folder: Path) -> dict[str, str]:
    """The digests of a case's results as the code of a checkout gives them."""
    path = folder / f"{case.replace('/', '-')}.h5"
    command = [sys.executable, "-m", "tbi_cli", "run", case, "-q", "-o", str(path)]
    environment = os.environ | {"PYTHONPATH": str(tree)}
    run = subprocess.run(command, env=environment, cwd=folder, capture_output=True, text=True, check=False)
    if run.returncode:
        raise SystemExit(f"{tree}: tbi run {case}: {run.stderr}")
    return digests(path)


def differences(before: dict[str, str], after: dict[str, str]) -> Iterator[str]:
    """What a table's bits, or its being there, tell apart."""
    before = {renamed(name): digest for name, digest in before.items()}
    for name in sorted(before.keys() | after.keys()):
        if name not in after:
            yield f"{name}: is no more"
        elif name not in before:
            yield f"{name}: is new"
        elif before[name] != after[name]:
            yield f"{name}: other bits"


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("commit", help="what the working tree is compared with, as git names it")
    parser.add_argument("cases", nargs="*", help="built-in cases (default: all that both have)")
    arguments = parser.parse_args()
    differ = 0
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        tree, old, new = folder / "tree", folder / "old", folder / "new"
        git = ["git", "-C", str(ROOT), "worktree"]
        subprocess.run([*git, "add", "--quiet", "--detach", str(tree), arguments.commit], check=True)
        try:
            old.mkdir()
            new.mkdir()
            for case in arguments.cases or sorted({*cases(tree)} & {*cases(ROOT)}):
                found = solved(ROOT, case, new)
                lines = list(differences(solved(tree, case, old), found))
                print(f"{case}: {f'{len(lines)} differ' if lines else 'the same'}, of {len(found)} tables")
                print("".join(f"    {line}\n" for line in lines), end="", flush=True)
                differ += bool(lines)
        finally:
            subprocess.run([*git, "remove", "--force", str(tree)], check=True)
    sys.exit(1 if differ else 0)


if __name__ == "__main__":
    main()
