"""Files from strangers: whatever is in them, a message comes out; no crash, and nothing of another file."""

from __future__ import annotations

import json
import os
import random
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from tbi_cli.store import ResultsStore, StoreError, open_parts, open_results, studies_of
from tbi_cli.store.compare import changed_keys
from tbi_cli.store.layout import FORMAT_VERSION, STUDIES_FORMAT
from tests.store.example import batch, content, layout, solve

OF = layout(shape=(2, 3), channels=3, histories=2)


@pytest.fixture(scope="module")
def good(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("good") / "results.h5"
    solve(path, OF)
    return path


@pytest.fixture(autouse=True)
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    """One second is plenty for files as small as these."""
    monkeypatch.setattr("tbi_cli.store.vet._CPU_SECONDS", 1)


def read_all(path: Path) -> None:
    """Asks for everything that the reader can give."""
    with open_results(path) as results:
        assert results.status.shape == results.shape
        assert all(isinstance(text, str) for text in results.messages.values())
        assert isinstance(results.case_yaml, str)
        assert len(results.attributes) < 100
        for group in results.layout.groups:
            for variable in results.layout.columns(group):
                assert results.table(group, variable.name).dtype == np.float64
        for index in results.history_indices():
            results.history(index)
            results.history(index, [results.history_channels[0].name])


def replace_by(name: str, data: object = None, **options: object) -> Callable[[h5py.File], None]:
    """Puts another dataset in the place of one."""

    def change(file: h5py.File) -> None:
        del file[name]
        file.create_dataset(name, data=data, **options)

    return change


def link(name: str, to: object) -> Callable[[h5py.File], None]:
    def change(file: h5py.File) -> None:
        del file[name]
        file[name] = to

    return change


def attribute(name: str, value: object, of: str = "/") -> Callable[[h5py.File], None]:
    return lambda file: file[of].attrs.__setitem__(name, value)


def delete(name: str) -> Callable[[h5py.File], None]:
    return lambda file: file.__delitem__(name)


def virtual(file: h5py.File) -> None:
    source = h5py.VirtualSource(__file__, "secret", shape=(2, 3))
    target = h5py.VirtualLayout(shape=(2, 3), dtype="f8")
    target[...] = source
    del file["peak/body_0_y"]
    file.create_virtual_dataset("peak/body_0_y", target)


def references(file: h5py.File) -> None:
    del file["peak/body_0_y"]
    data = file.create_dataset("peak/body_0_y", (2, 3), h5py.ref_dtype)
    data[...] = file["rms"].ref


def references_as_attribute(file: h5py.File) -> None:
    file.attrs["format"] = file["rms"].ref


HUGE = {"shape": (10**6, 10**7), "dtype": "f8", "chunks": (1000, 1000)}
GRID = np.ones((2, 3))


def channel_named(name: str) -> Callable[[h5py.File], None]:
    """The name of a channel leads elsewhere, to where there is a table of the same shape."""

    def change(file: h5py.File) -> None:
        for group in ("peak", "max", "min", "rms", "time_of_peak"):
            file[f"{group}/way"] = h5py.ExternalLink("other.h5", f"/{group}")
        file.attrs["channels"] = name

    return change


HARM: dict[str, Callable[[h5py.File], None]] = {
    "not ours": lambda f: f.attrs.clear(),
    "another format": attribute("format", "netcdf"),
    "a newer version": attribute("format_version", 2),
    "a version of text": attribute("format_version", "one"),
    "a version of many numbers": attribute("format_version", np.ones(50)),
    "a format that is a reference": references_as_attribute,
    "no status": delete("status"),
    "status of another shape": replace_by("status", np.ones((3, 2), dtype="i1")),
    "status of another number": replace_by("status", np.full((2, 3), 7, dtype="i1")),
    "status of text": replace_by("status", np.full((2, 3), b"done")),
    "status is a group": lambda f: (delete("status")(f), f.create_group("status"))[0],
    "no messages where they are needed": lambda f: (
        replace_by("status", np.full((2, 3), 2, dtype="i1"))(f),
        delete("message")(f),
    )[0],
    "messages of numbers": lambda f: (
        replace_by("status", np.full((2, 3), 2, dtype="i1"))(f),
        replace_by("message", GRID)(f),
    )[0],
    "no axis": delete("velocity"),
    "an axis of two dimensions": replace_by("velocity", GRID),
    "an axis of another length": replace_by("velocity", np.ones(4)),
    "an axis of no number": replace_by("velocity", np.array([1.0, np.nan, 3.0])),
    "an axis that moves the cursor": attribute("dimensions", "\x1b[31mvelocity"),
    "an axis that is claimed": attribute("dimensions", "velocity velocity velocity"),
    "no axes": attribute("dimensions", ""),
    "no table": delete("rms"),
    "a table that is a dataset": replace_by("rms", GRID),
    "no channel": delete("rms/body_1_y"),
    "a channel of another shape": replace_by("rms/body_1_y", np.ones(6)),
    "a channel of text": replace_by("peak/body_0_y", np.full((2, 3), b"1.0")),
    "a channel of complex numbers": replace_by("peak/body_0_y", GRID * 1j),
    "a channel of nothing": replace_by("peak/body_0_y", h5py.Empty("f8")),
    "a channel of records": replace_by("peak/body_0_y", np.zeros((2, 3), dtype=[("a", "f8")])),
    "a channel of lists": replace_by("peak/body_0_y", shape=(2, 3), dtype=h5py.vlen_dtype("f8")),
    "a channel of references": references,
    "a channel in another file": virtual,
    "a channel in external storage": replace_by(
        "peak/body_0_y", shape=(2, 3), dtype="f8", external=[("/etc/passwd", 0, 48)]
    ),
    "a channel behind an external link": link("peak/body_0_y", h5py.ExternalLink("/etc/passwd", "/x")),
    "a table behind an external link": link("peak", h5py.ExternalLink("results.h5", "/rms")),
    "a table behind a soft link": link("peak", h5py.SoftLink("/rms")),
    "a loop of soft links": link("peak/body_0_y", h5py.SoftLink("/peak/body_0_y")),
    "a loop of groups": lambda f: (delete("histories/0")(f), f["histories"].__setitem__("0", f["histories"]))[
        0
    ],
    "a type instead of a channel": link("peak/body_0_y", np.dtype("f8")),
    "a channel that claims to be huge": replace_by("peak/body_0_y", **HUGE),
    "a grid that claims to be huge": lambda f: (
        replace_by("velocity", shape=(10**13,), dtype="f8", chunks=(10**6,))(f),
        replace_by("status", shape=(2, 10**13), dtype="i1", chunks=(1, 10**6))(f),
    )[0],
    "a history without time": delete("histories/1/time"),
    "a history of another length": replace_by("histories/1/body_0_y", np.ones(3)),
    "a history that lacks a channel": delete("histories/1/body_1_y"),
    "a history that is a dataset": replace_by("histories/1", GRID),
    "channels that are not there": attribute("channels", "body_0_y ../../etc/passwd"),
    "a channel in another group": channel_named("../rms/body_0_y"),
    "a channel behind a slash": channel_named("way/body_0_y"),
    "a channel that is the group": channel_named("."),
    "a version in bytes": attribute("format_version", np.bytes_(b"\x1b[2J\xff")),
    "a version without end": attribute("format_version", "9" * 50_000),
    "unknown factors": attribute("daf", "right middle"),
}


@pytest.mark.parametrize("harm", HARM.values(), ids=HARM)
def test_harm(good: Path, tmp_path: Path, harm: Callable[[h5py.File], None]) -> None:
    path = shutil.copy(good, tmp_path / "results.h5")
    shutil.copy(good, tmp_path / "other.h5")
    with h5py.File(path, "a") as file:
        harm(file)
    with pytest.raises(StoreError) as caught:
        read_all(Path(path))
    message = str(caught.value)
    assert message.startswith(str(tmp_path))
    assert message.isprintable()
    assert len(message) < len(str(tmp_path)) + 400


def test_a_size_that_is_only_claimed_is_refused(good: Path, tmp_path: Path) -> None:
    """A history that memory has room for, five million samples, of which the file holds none."""
    path = Path(shutil.copy(good, tmp_path / "results.h5"))
    with h5py.File(path, "a") as file:
        for name in ("time", *(channel.name for channel in OF.history_channels)):
            replace_by(f"histories/1/{name}", shape=(5_000_000,), dtype="f8", chunks=(10**6,))(file)
    with (
        open_results(path) as results,
        pytest.raises(StoreError, match="claims 40000000 bytes, but only 0 are stored"),
    ):
        results.history(1)


def test_what_does_no_harm(good: Path, tmp_path: Path) -> None:
    """Other things in the file, odd attributes, and histories of cases outside the grid."""
    path = Path(shutil.copy(good, tmp_path / "results.h5"))
    with h5py.File(path, "a") as file:
        file["elsewhere"] = h5py.ExternalLink("/etc/passwd", "/")
        file["histories/elsewhere"] = h5py.SoftLink("/histories")
        for name in ("99", "-1", "٣", "1" * 400, "00"):
            file[f"histories/{name}"] = 1.0
        file.attrs["self"] = file.ref
        file.attrs["many"] = np.zeros(1000)
        file.attrs["empty"] = h5py.Empty("f8")
        file.attrs["old"] = np.bytes_(b"\xff\x00text")
        file["peak/body_0_y"].attrs["units"] = np.arange(3)
    read_all(path)


def test_words_of_a_stranger_move_no_cursor(good: Path, tmp_path: Path) -> None:
    path = Path(shutil.copy(good, tmp_path / "results.h5"))
    with h5py.File(path, "a") as file:
        for name in ("velocity", "peak/body_0_y"):
            file[name].attrs.update({"units": "\x1b[31mm", "long_name": "a\nb"})
    with open_results(path) as results:
        found = (next(dim for dim in results.dims if dim.name == "velocity"), results.channels[0])
    assert [(one.units, one.long_name) for one in found] == [("[31mm", "a b")] * 2


# Each of these stands for 9^30 values, or for an end that Python's stack does not reach.
EXPLOSIVE = {
    "aliases": "a0: &a0 [x, x]\n"
    + "\n".join(f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 9)}]" for i in range(1, 30)),
    "nesting": "[" * 50_000,
    "no YAML": "a: [1",
    "code": "a: !!python/object/apply:os.getcwd []",
}


@pytest.mark.parametrize("case", EXPLOSIVE.values(), ids=EXPLOSIVE)
def test_a_case_that_explodes_is_not_compared(case: str) -> None:
    assert changed_keys(case, "bridge: {modes: 4}") == "which cannot be compared"
    assert changed_keys("bridge: {modes: 4}", case) == "which cannot be compared"


def test_a_packed_file_is_read(good: Path, tmp_path: Path) -> None:
    """As h5repack leaves it."""
    path = Path(shutil.copy(good, tmp_path / "results.h5"))
    with h5py.File(path, "a") as file:
        for group in ("peak", "rms", "histories/2"):
            for name, data in file[group].items():
                if name.startswith("body"):
                    values, attributes = data[...], dict(data.attrs)
                    del file[group][name]
                    packed = file[group].create_dataset(name, data=values, compression="gzip", shuffle=True)
                    packed.attrs.update({k: v for k, v in attributes.items() if isinstance(v, str)})
    read_all(path)
    with open_results(path) as results:
        expected = batch(OF, range(6)).tables["peak"][:, 1]
        np.testing.assert_array_equal(results.table("peak", "body_1_y").ravel(), expected)


def test_cut_short_anywhere(good: Path, tmp_path: Path) -> None:
    whole = good.read_bytes()
    path = tmp_path / "results.h5"
    for size in sorted(random.Random(0).sample(range(len(whole)), 40)):
        path.write_bytes(whole[:size])
        with pytest.raises(StoreError):
            read_all(path)


def test_bytes_changed_anywhere(good: Path, tmp_path: Path) -> None:
    """Read or refused, nothing else."""
    whole = good.read_bytes()
    path = tmp_path / "results.h5"
    dice = random.Random(0)
    for _ in range(100):
        changed = bytearray(whole)
        for _ in range(3):
            changed[dice.randrange(len(whole))] = dice.randrange(256)
        path.write_bytes(changed)
        try:
            read_all(path)
        except StoreError as error:
            assert str(error).isprintable()


def test_a_file_that_the_library_would_never_be_done_with(good: Path, tmp_path: Path) -> None:
    """A stretch of no size in a heap of strings: HDF5 2.0 looks for the next one for ever."""
    whole = bytearray(good.read_bytes())
    heap = whole.index(b"GCOL")
    whole[heap + 16 : heap + 32] = bytes(16)  # the first object's number, use and size
    path = tmp_path / "results.h5"
    path.write_bytes(whole)
    unbearable = "damaged in a way that the HDF5 library cannot bear"
    with pytest.raises(StoreError, match=unbearable):
        read_all(path)
    with pytest.raises(StoreError, match=unbearable):  # a run looks first, as every reader does
        ResultsStore(path, OF, resume=True)
    # A run that would complete the file, and has done something already.
    path.write_bytes(good.read_bytes())
    with ResultsStore(path, OF, resume=True) as store:
        store.write(batch(OF, [0]))
    path.write_bytes(whole)
    with pytest.raises(StoreError, match=unbearable):
        ResultsStore(path, OF, resume=True)
    with pytest.raises(StoreError, match=unbearable):
        open_parts(path)
    with ResultsStore(path, OF, overwrite=True) as store:  # what is there is of no concern
        store.write(batch(OF, range(6)))
        store.finish()
    assert content(path) == content(good)


@pytest.mark.parametrize("name", ["", "missing.h5", "folder", "missing/results.h5", "nul\0.h5", "x" * 300])
def test_nothing_to_read(tmp_path: Path, name: str) -> None:
    (tmp_path / "folder").mkdir()
    with pytest.raises(StoreError) as caught:
        open_results(tmp_path / name)
    assert str(caught.value).isprintable()


def test_devices_and_pipes_are_not_waited_for(tmp_path: Path) -> None:
    for path in ("/dev/zero", "/dev/stdin", "/proc/self/mem"):
        with pytest.raises(StoreError):
            open_results(path)


LAYOUTS = [
    "",
    "{}",
    "[" * 100_000,
    '{"format": "tbi-results-layout", "format_version": 1}',
    '{"format": "tbi-results-layout", "format_version": 2}',
    '{"format": "tbi-results-layout", "format_version": 1, "dims": [{"name": 1}]}',
    "\x00",
]


@pytest.mark.parametrize("text", LAYOUTS, ids=range(len(LAYOUTS)))
def test_parts_without_a_sound_layout(tmp_path: Path, text: str) -> None:
    folder = tmp_path / "results.h5.parts"
    folder.mkdir()
    (folder / "layout.json").write_text(text)
    with pytest.raises(StoreError, match=r"layout\.json: is not a layout"):
        open_results(tmp_path / "results.h5")


Change = Callable[[dict[str, Any]], object]
CHANGES: dict[str, Change] = {
    "NaN": lambda data: data["dims"][1].update(values=[float("nan")] * 3),
    "no end": lambda data: data["dims"][1].update(values=[1.0, 2.0, float("inf")]),
    "a huge grid": lambda data: data.update(dims=[data["dims"][0] | {"values": [0.0] * 10_000}] * 5),
    "a name that leads elsewhere": lambda data: data["channels"][0].update(name="../../x"),
    "no name": lambda data: data["channels"][0].update(name=""),
    "an axis of lists": lambda data: data["dims"][0].update(values=[[1.0]]),
    "an axis of text": lambda data: data["dims"][0].update(values=["1"] * 2 + ["x"]),
    "an attribute that is no number": lambda data: data["attributes"].update(solve_seconds=float("nan")),
}


@pytest.mark.parametrize("change", CHANGES.values(), ids=CHANGES)
def test_a_layout_that_cannot_be(tmp_path: Path, change: Change) -> None:
    """Refused before an array is made of it."""
    path = tmp_path / "results.h5"
    with ResultsStore(path, OF) as store:
        store.write(batch(OF, [0, 1, 2]))
    file = tmp_path / "results.h5.parts" / "layout.json"
    data = json.loads(file.read_text())
    change(data)
    file.write_text(json.dumps(data))
    for act in (lambda: open_results(path), lambda: ResultsStore(path, OF, resume=True)):
        with pytest.raises(StoreError) as caught:
            act()
        assert str(caught.value).startswith(f"{file}: ")


@pytest.mark.parametrize("name", ["layout.json", "studies.json", "000000.h5"])
def test_pipes_among_the_parts_are_not_waited_for(tmp_path: Path, name: str) -> None:
    path = tmp_path / "results.h5"
    with ResultsStore(path, OF) as store:
        store.write(batch(OF, [0, 1, 2]))
    file = tmp_path / "results.h5.parts" / name
    file.unlink(missing_ok=True)
    os.mkfifo(file)
    os.mkfifo(file.with_name("lock"))
    with pytest.raises(StoreError, match="is not a regular file"):
        studies_of(path), open_results(path)
    with ResultsStore(path, OF, overwrite=True):  # the lock is taken, as nobody holds it
        pass


def test_a_damaged_part(tmp_path: Path) -> None:
    path = tmp_path / "results.h5"
    with ResultsStore(path, OF) as store:
        store.write(batch(OF, [0, 1, 2], failed=[1]))
        store.write(batch(OF, [3, 4, 5]))
    part = tmp_path / "results.h5.parts" / "000001.h5"
    whole = part.read_bytes()
    for name, harm in {
        "cases": np.array([3, 4, 5]),
        "numbers": np.ones((3, 99)),
        "history_values": np.ones(3),
    }.items():
        part.write_bytes(whole)
        with h5py.File(part, "a") as file:
            replace_by(name, harm)(file)
        with pytest.raises(StoreError, match=r"000001\.h5"):
            read_all(path)
    part.write_bytes(whole[:1000])
    with pytest.raises(StoreError, match=r"000001\.h5"):
        read_all(path)
    part.write_bytes(whole)
    read_all(path)
    with ResultsStore(path, OF, resume=True) as store:
        store.write(batch(OF, [1]))
        store.finish()
    solve(tmp_path / "whole.h5", OF)
    assert content(path) == content(tmp_path / "whole.h5")


@pytest.mark.parametrize("name", ["..", "-rf", "a\x1b[31m", "x" * 100])
def test_studies_are_named_as_folders_may_be(tmp_path: Path, name: str) -> None:
    """`tbi export` makes a folder for each study, and a run keeps the parts of each in one."""
    path = tmp_path / "results.h5"
    heading = {"format": STUDIES_FORMAT, "format_version": FORMAT_VERSION, "studies": name}
    with h5py.File(path, "w") as file:
        file.create_group(name)
        file.attrs.update(heading)
    with pytest.raises(StoreError, match="does not hold the studies that it should"):
        studies_of(path)
    path.unlink()
    folder = tmp_path / "results.h5.parts"
    folder.mkdir()
    (folder / "studies.json").write_text(json.dumps(heading | {"studies": [name, "b"], "attributes": {}}))
    with pytest.raises(StoreError, match=r"studies\.json: does not name studies"):
        studies_of(path)
