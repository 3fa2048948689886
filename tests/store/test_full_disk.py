"""A file system that is really full, where this may be set up; limits on file size are tested elsewhere."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from tbi_cli.store import ResultsStore, StoreError
from tests.store.example import batch, content, layout, solve


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Path]:
    """A file system of one megabyte."""
    folder = tmp_path / "disk"
    folder.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=1m", "tmpfs", str(folder)]
    done = subprocess.run(mount, capture_output=True, text=True, check=False)
    if done.returncode:
        pytest.skip(f"cannot mount a small file system here: {done.stderr.strip()}")
    yield folder
    subprocess.run(["umount", str(folder)], check=True)


OF = layout(shape=(4, 6), channels=5, histories=5)


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """What an undisturbed run gives."""
    path = tmp_path_factory.mktemp("whole") / "results.h5"
    solve(path, OF)
    return content(path)


@pytest.mark.parametrize("room", [0, 1, 3, 8, 20, 40, 70, 110, 150, 200])
def test_no_space(small_disk: Path, whole: dict[str, bytes], room: int) -> None:
    """With so many kilobytes free it stops somewhere, loses nothing, and ends well once there is room."""
    path, ballast = small_disk / "results.h5", small_disk / "ballast"
    with ResultsStore(path, OF) as store:
        store.write(batch(OF, range(4)))
        store.finish()
    before = path.read_bytes()
    state = os.statvfs(small_disk)
    ballast.write_bytes(bytes(max(0, state.f_bavail * state.f_frsize - 1024 * room)))
    with pytest.raises(StoreError, match="No space left on device"):
        solve(path, OF)
    assert path.read_bytes() == before
    assert not list(small_disk.rglob("*.unfinished"))
    ballast.unlink()
    subprocess.run(["mount", "-o", "remount,size=50m", str(small_disk)], check=True)
    solve(path, OF)
    assert content(path) == whole
    assert [p.name for p in small_disk.iterdir()] == ["results.h5"]
