"""Made-up results, the same for the same flat index in whatever batch or process they are made."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

import h5py
import numpy as np

from tbi_cli.store import DAF, DONE, FAILED, TABLES, BatchResult, Dim, History, Layout, ResultsStore, Variable

CASE_YAML = "title: an example\nbridge:\n  length: 50.0\n  modes: 4\n"


def layout(
    *,
    shape: Sequence[int] = (3, 5),
    channels: int = 4,
    histories: int = 0,
    daf: Sequence[str] = tuple(DAF),
    case: str = CASE_YAML,
    sha256: str = "1" * 64,
    **attributes: str,
) -> Layout:
    """A grid over car body mass, speed, ... with as many channels as wanted."""
    names = ("span", "damping", "train_car_body_mass", "velocity")[-len(shape) :]
    units = {"train_car_body_mass": "kg", "velocity": "m/s", "span": "m", "damping": "N s/m^2"}
    dims = [
        Dim(k, np.linspace(1.1, 97.3, n), units[k], f"the {k}") for k, n in zip(names, shape, strict=True)
    ]
    made = [
        Variable(f"body_{i}_y", "m" if i % 2 else "m/s^2", f"motion {i} of the body") for i in range(1000)
    ]
    provenance = {"case": case, "case_sha256": sha256, "tbi_version": "0.1.0", **attributes}
    return Layout(tuple(dims), tuple(made[:channels]), tuple(made[:histories]), tuple(daf), provenance)


def numbers(index: int, count: int) -> np.ndarray:
    """Numbers for one case, of all magnitudes."""
    random = np.random.default_rng(index)
    return random.normal(size=count) * 10.0 ** random.integers(-12, 12, size=count)


def history(of: Layout, index: int) -> History:
    """A history whose length depends on the case."""
    samples = 20 + index % 7
    values = numbers(index + 1_000_000, samples * len(of.history_channels))
    return History(np.arange(samples) * 0.001, values.reshape(-1, samples))


def batch(of: Layout, indices: Iterable[int], failed: Iterable[int] = ()) -> BatchResult:
    """The results of those cases; of the failed ones with a message and no numbers."""
    flat = np.array(list(indices), dtype=np.int64)
    bad = np.isin(flat, list(failed))
    count = len(of.channels)
    every = np.array([numbers(i, 5 * count + len(of.daf)) for i in flat]).reshape(
        len(flat), 5 * count + len(of.daf)
    )
    every[bad] = np.nan
    tables = {group: every[:, k * count : (k + 1) * count] for k, group in enumerate(TABLES)}
    factors = {name: every[:, 5 * count + k] for k, name in enumerate(of.daf)}
    messages = [
        f"case {i}: the motion grew without bound" if b else "" for i, b in zip(flat, bad, strict=True)
    ]
    histories = {int(i): history(of, int(i)) for i in flat[~bad]} if of.history_channels else {}
    return BatchResult(
        flat,
        np.where(bad, FAILED, DONE).astype(np.int8),
        messages,
        tables,
        factors,
        np.full(len(flat), 0.25),
        np.full(len(flat), 100),
        histories,
    )


def batches(of: Layout, size: int = 4) -> list[list[int]]:
    """The flat indices of a grid in batches."""
    return [list(range(first, min(first + size, of.size))) for first in range(0, of.size, size)]


def solve(path: Path, of: Layout) -> None:
    """A run of the whole grid, or of what an earlier one left to do."""
    with ResultsStore(path, of, resume=True) as store:
        done = store.done()
        for indices in batches(of):
            left = [i for i in indices if not done[i]]
            if left:
                store.write(batch(of, left))
        store.finish()


def content(path: Path) -> dict[str, bytes]:
    """Every dataset of a results file, bit for bit, by its path; its units and long name too."""
    found: dict[str, bytes] = {}

    def note(name: str, item: h5py.HLObject) -> None:
        if isinstance(item, h5py.Dataset):
            text = h5py.check_string_dtype(item.dtype) is not None
            found[name] = repr(item[...].tolist()).encode() if text else item[...].tobytes()
            found[f"{name}@"] = repr([item.attrs["units"], item.attrs["long_name"]]).encode()

    with h5py.File(path, "r") as file:
        file.visititems(note)
    return found
