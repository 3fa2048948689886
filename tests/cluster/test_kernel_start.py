"""Many processes that start at once where no kernel was ever compiled, as the tasks of an array do."""

from __future__ import annotations

import hashlib
import os
import subprocess
from pathlib import Path

import pytest

from tbi_cli.integrator import kernel_cache
from tbi_cli.integrator.kernel_cache import compile_kernels, fingerprint
from tbi_cli.integrator.native import processor
from tests.cli.commands import tbi
from tests.cluster.runs import command, content

FEW = ("--set", "sweep={velocity: [40, 50, 60]}", "-q")


def test_eight_processes_with_an_empty_cache(folder: Path) -> None:
    """One compiles, the others wait; all work, with the same bits."""
    cache = folder / "cache"
    environment = os.environ | {"TBI_CACHE_DIR": str(cache)}

    started = [
        subprocess.Popen(
            command("run", "case.yaml", "-o", f"{number}.h5", *FEW),
            cwd=folder,
            env=environment,
            stderr=subprocess.PIPE,
        )
        for number in range(8)
    ]
    for process in started:
        _, err = process.communicate(timeout=300)
        assert (process.returncode, err) == (0, b"")
    first = content(folder / "0.h5")
    assert all(content(folder / f"{number}.h5") == first for number in range(1, 8))
    kept = sorted(file.name for file in cache.rglob("*") if file.is_file())
    assert kept == ["advance", "lock"], "the kernel that the case needs, and nothing half-written"


def kernel_in(cache: Path) -> Path:
    """Where a cache has the kernel of most cases."""
    return cache / "kernels" / fingerprint() / processor() / "advance"


def common_kernel() -> bytes:
    """The content of that file in the cache that all tests share."""
    compile_kernels(lambda text: None, ("general",))
    content, _ = kernel_cache._find(["advance"])
    return hashlib.sha256(content["advance"]).digest() + content["advance"]


# Each of them changed the code that numba made, or had it print.
SETTINGS = {
    "NUMBA_OPT": "0",
    "NUMBA_DISABLE_JIT": "1",
    "NUMBA_DEBUGINFO": "1",
    "NUMBA_DUMP_IR": "1",
    "NUMBA_CPU_NAME": "generic",
    "NUMBA_LOOP_VECTORIZE": "0",
    "NUMBA_BOUNDSCHECK": "1",
    "NUMBA_ENABLE_AVX": "0",
    "NUMBA_FUNCTION_CACHE_SIZE": "x",
    "PYTHONWARNINGS": "error",
}


def test_named_pipes_and_settings_of_numba(folder: Path) -> None:
    """To open a pipe waits until somebody writes to it.  However numba is set, it makes the same bytes."""
    kernel = kernel_in(folder / "cache")
    kernel.parent.mkdir(parents=True)
    os.mkfifo(kernel)
    os.mkfifo(kernel.with_name("lock"))
    (folder / ".numba_config.yaml").write_text("opt: 0\n")
    ended = tbi("run", "case.yaml", *FEW, folder=folder, TBI_CACHE_DIR=str(folder / "cache"), **SETTINGS)
    assert (ended.code, ended.out, ended.err) == (0, "", "")
    assert kernel.read_bytes() == common_kernel()


@pytest.mark.parametrize(
    "fault", ["a wrong hash", "another's file", "a file for all", "another's folder", "a folder for all"]
)
def test_a_kernel_that_is_not_to_be_run(folder: Path, fault: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Damaged, or with a right hash and what someone else may have written: made anew, or the next serves."""
    planted, good, code = kernel_in(folder / "planted"), kernel_in(folder / "good" / "tbi"), b"\x7fELF" * 1000
    content = common_kernel()
    for path in (planted, good):
        path.parent.mkdir(parents=True)
    planted.write_bytes((bytes(32) if "hash" in fault else hashlib.sha256(code).digest()) + code)
    good.write_bytes(content)
    place = planted.parent if "folder" in fault else planted
    if "another" in fault:
        if os.geteuid() != 0:
            pytest.skip("only root gives files away")
        os.chown(place, 12345, 12345)
    if "for all" in fault:
        place.chmod(place.stat().st_mode | 0o022)
    monkeypatch.setenv("TBI_CACHE_DIR", str(folder / "planted"))
    monkeypatch.setenv("XDG_CACHE_HOME", str(folder / "good"))
    found = kernel_cache._find(["advance"])
    assert found == (({"advance": content[32:]}, good.parent) if "folder" in fault else ({}, planted.parent))


def test_a_relative_cache_folder(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The XDG specification: it is to be ignored.  So it is where the home is no absolute path."""
    for name, value in {"XDG_CACHE_HOME": "here", "HOME": "there", "TBI_CACHE_DIR": ""}.items():
        monkeypatch.setenv(name, value)
    assert [path for path in kernel_cache._candidates() if not path.is_absolute()] == []


def test_a_temporary_folder_that_anyone_can_write_to(folder: Path) -> None:
    """Code of strangers is not run: nothing is read from there, and nothing kept."""
    (folder / "occupied").write_text("")
    open_to_all = folder / f"tbi-{os.getuid()}"
    open_to_all.mkdir()
    open_to_all.chmod(0o777)
    occupied = str(folder / "occupied")
    places = {"TBI_CACHE_DIR": occupied, "XDG_CACHE_HOME": occupied, "TMPDIR": str(folder)}
    ended = tbi("run", "case.yaml", *FEW, folder=folder, **places)
    assert (ended.code, ended.err) == (0, "")
    assert not list(open_to_all.iterdir())


def test_a_cache_that_cannot_be_written(folder: Path) -> None:
    """A file where the folder should be: the next place serves."""
    (folder / "occupied").write_text("")
    home = {"TBI_CACHE_DIR": str(folder / "occupied"), "XDG_CACHE_HOME": os.environ.get("XDG_CACHE_HOME", "")}
    ended = tbi("run", "case.yaml", *FEW, folder=folder, **home)
    assert (ended.code, ended.err) == (0, "")
