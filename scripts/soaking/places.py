"""Places that fail: full disks, limits, kernels to be compiled by many at once."""

from __future__ import annotations

import contextlib
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from soaking.common import HISTORIES, Soak

from tests.cluster.runs import content, parts


def disk(soak: Soak) -> None:
    """A full disk, or a limit on file size, at many points: nothing lost, and it goes on with room."""
    points = 1 if soak.short else 20
    soak.tbi("run", "case.yaml", "-o", "whole.h5", "-q", "--overwrite", *HISTORIES)
    whole, size = content(soak.folder / "whole.h5"), (soak.folder / "whole.h5").stat().st_size
    print(f"disk: a limit on file size, then a full disk, at {points} points of a run of {size / 1e6:.1f} MB")
    messages = 0
    for limit in np.geomspace(0.9 * size, 500, points).astype(int):
        path = soak.folder / "limited.h5"
        path.unlink(missing_ok=True)
        ended = soak.tbi("run", "case.yaml", "-o", path.name, "-q", *HISTORIES, limit=int(limit))
        one_message = ended.returncode == 2 and ended.stderr.count("\n") == 1 and "too large" in ended.stderr
        messages += one_message and not path.exists()
        soak.tbi("run", "case.yaml", "-o", path.name, "-q", "--resume", *HISTORIES)
        if content(path) != whole:
            soak.holds(f"the same bits after a limit of {limit} bytes", False)
    soak.holds(
        f"{points} limits on file size: {messages} times one message and no broken file", messages == points
    )
    with small_disk(soak.folder / "disk", 4 * size) as place:
        if place is None:
            print("  --   no small file system can be mounted here")
            return
        messages = 0
        for room in np.linspace(0, 1.5 * size, points).astype(int):
            for file in place.iterdir():
                shutil.rmtree(file) if file.is_dir() else file.unlink()
            soak.tbi("run", "case.yaml", "-o", str(place / "r.h5"), "-q", "--shard", "1/9")
            before = (place / "r.h5").read_bytes()
            state = os.statvfs(place)
            (place / "ballast").write_bytes(bytes(max(0, state.f_bavail * state.f_frsize - int(room))))
            arguments = ("run", "case.yaml", "-o", str(place / "r.h5"), "-q", *HISTORIES)
            ended = soak.tbi(*arguments, "--overwrite")
            one_message = (
                ended.returncode == 2 and ended.stderr.count("\n") == 1 and "No space" in ended.stderr
            )
            messages += one_message and (place / "r.h5").read_bytes() == before
            (place / "ballast").unlink()
            soak.tbi(*arguments, "--resume" if parts(place / "r.h5") else "--overwrite")
            if content(place / "r.h5") != whole:
                soak.holds(f"the same bits after {room} bytes of room", False)
        text = f"{points} times a full disk: {messages} times one message, the older file untouched"
        soak.holds(text, messages == points)


@contextlib.contextmanager
def small_disk(folder: Path, size: int) -> Iterator[Path | None]:
    """A file system of that many bytes; None where none can be mounted."""
    folder.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", str(folder)]
    if shutil.which("mount") is None or subprocess.run(mount, capture_output=True, check=False).returncode:
        yield None
        return
    try:
        yield folder
    finally:
        subprocess.run(["umount", str(folder)], check=True)


def kernels(soak: Soak) -> None:
    """Many processes at once with an empty cache, with and without file locks, and a damaged cache."""
    few = ("--set", "sweep={velocity: [40, 50, 60]}", "-q")
    soak.tbi("run", "case.yaml", "-o", "few.h5", *few)
    first = content(soak.folder / "few.h5")
    # As flock fails where a file system has no locks.
    unlocked = "import fcntl; from tbi_cli.__main__ import main; fcntl.flock = lambda *_: open(''); main()"
    for name, start in (("", ["-m", "tbi_cli"]), (" without file locks", ["-c", unlocked])):
        cache = soak.folder / f"cache{name}"
        for file in soak.folder.glob("few[0-9].h5"):
            file.unlink()
        processes = [
            subprocess.Popen(
                [sys.executable, *start, "run", "case.yaml", "-o", f"few{number}.h5", "--overwrite", *few],
                cwd=soak.folder,
                env=os.environ | {"TBI_CACHE_DIR": str(cache)},
            )
            for number in range(8)
        ]
        codes = [process.wait() for process in processes]
        made = [soak.folder / f"few{number}.h5" for number in range(8)]
        same = sum(path.exists() and content(path) == first for path in made)
        soak.holds(
            f"8 processes with an empty cache{name}: {same} with the same bits",
            codes == [0] * 8 and same == 8,
        )
    file = next(cache.rglob("advance"))
    whole, healed = file.read_bytes(), 0
    one_byte = whole[:5000] + bytes([whole[5000] ^ 1]) + whole[5001:]
    damages = (b"", whole[:5000], one_byte, b"\x7fELF" * 1000)
    for damage in damages:
        file.write_bytes(damage)
        ended = soak.tbi("run", "case.yaml", "-o", "few.h5", "--overwrite", *few, TBI_CACHE_DIR=str(cache))
        same_code = file.read_bytes() == whole
        healed += ended.returncode == 0 and content(soak.folder / "few.h5") == first and same_code
    soak.holds(f"{len(damages)} damaged kernels, {healed} healed", healed == len(damages))
