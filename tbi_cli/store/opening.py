"""From a path to results: the results file, or the parts of a run that is not finished."""

from __future__ import annotations

import contextlib
import json
import os
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tbi_cli.store.durable import write_text
from tbi_cli.store.errors import StoreError, is_missing
from tbi_cli.store.layout import Layout
from tbi_cli.store.parts import (
    LAYOUT_FILE,
    STUDIES_FILE,
    UNSETTLED_FILE,
    PartSource,
    part_number,
    parts_folder,
)
from tbi_cli.store.picked import MovedSource, numbers_in, refined_axis, solved_only
from tbi_cli.store.plain import read_plain
from tbi_cli.store.results import Results
from tbi_cli.store.sources import ResultsSource, Source
from tbi_cli.store.vet import vet

_LAYOUT_BYTES = 1 << 28  # of a layout file; the coordinates of ten million grid points


def resolve(path: str | os.PathLike[str]) -> Path:
    """The path with links followed, so that a link to a results file stays one."""
    try:
        resolved = Path(path).resolve()
    except (OSError, RuntimeError, ValueError) as error:  # a loop of links; a null character
        raise StoreError(f"{os.fspath(path)!r}: is not a usable path ({error})") from error
    if not resolved.name:  # the root of all folders
        raise StoreError(f"{resolved}: is a folder, not a results file")
    return resolved


def is_there(path: Path) -> bool:
    """Whether there is anything at ``path``; raises `StoreError` where that cannot be told."""
    try:
        path.stat()
    except OSError as error:
        if is_missing(error):
            return False
        raise StoreError.from_os(path, error) from error
    return True


def open_results(path: str | os.PathLike[str], *, study: str = "", own: bool = False) -> Results:
    """Open the results file ``path`` or, where it is not there yet, the parts of the run that writes it.

    Of a file of several studies (see `studies_of`) one has to be named.
    Raises `StoreError` if there is neither, or if what is there is damaged or not written by tbi.  Files may
    come from strangers: nothing outside them is read.  A file that this process has just written (``own``)
    needs no look by a child process first.
    """
    path = resolve(path)
    if not own:
        look_first(path, study)
    return _open(path, study)


def look_first(path: Path, study: str = "") -> None:
    """Have a child process read the results file ``path``, and the parts of the run that writes it, if any.

    Whoever reads what an earlier process has left looks first: files may be damaged, or come from strangers.
    Raises `StoreError` for what the HDF5 library cannot bear; all else is for the reader to find.
    """
    folder = parts_folder(path, study)
    if os.path.isfile(path):  # noqa: PTH113 - Path.is_file raises where a name is too long
        vet(path, lambda: _look_through(ResultsSource(path, study)))
    if os.path.isdir(folder):  # noqa: PTH112
        vet(folder, lambda: _look_through_parts(path, study), files=len(os.listdir(folder)))  # noqa: PTH208


def _open(path: Path, study: str) -> Results:
    if not is_there(path):
        try:
            results = _open_parts(path, study)
        except StoreError:
            if not is_there(path):  # else the run has just ended, and taken its parts away
                raise
            results = None
        if results is not None:
            return results
    source = ResultsSource(path, study)
    unsettled = source.unsettled
    return Results(path, source.layout, [source], finished=True, study=study, unsettled=unsettled)


def _look_through(source: ResultsSource | PartSource) -> None:
    """Open all that is read later, and read it but for the numbers of most tables and histories."""
    source.messages  # noqa: B018
    source.look()
    for index in sorted(source.history_indices())[:1]:
        source.history(index)


def _look_through_parts(path: Path, study: str) -> None:
    run = Run.read(path, study)
    if run is None:
        return
    for part in run.parts():
        with contextlib.suppress(StoreError), contextlib.closing(PartSource(part, run.layout)) as source:
            _look_through(source)


def open_parts(path: Path, study: str = "") -> Results | None:
    """The results of the unfinished run that writes ``path``; None if there is none.  Raises `StoreError`."""
    look_first(path, study)
    return _open_parts(path, study)


def _open_parts(path: Path, study: str) -> Results | None:
    run = Run.read(path, study)
    return None if run is None else run.results()


class Run:
    """An unfinished run, or its part that is one study: its layout, its identity, and its finished files."""

    def __init__(self, path: Path, layout: Layout, run_id: str, *, extends: bool, study: str = "") -> None:
        self.path = path
        self.study = study
        self.folder = parts_folder(path, study)
        self.layout = layout
        #: Which run the parts belong to: parts of an earlier one that were not removed in time do not count.
        self.run_id = run_id
        #: Whether the run completes the results file that is there already; if not, it will replace it.
        self.extends = extends

    @classmethod
    def read(cls, path: Path, study: str = "") -> Run | None:
        """The run in the parts folder of ``path``, or None; raises `StoreError` if it is unreadable."""
        file = parts_folder(path, study) / LAYOUT_FILE
        if not study and is_there(file.parent / STUDIES_FILE):
            raise StoreError(f"{file.parent}: holds an unfinished run of several studies")
        try:
            text = read_plain(file, _LAYOUT_BYTES)
        except OSError as error:
            if is_missing(error):
                return None
            raise StoreError.from_os(file, error) from error
        try:
            layout, extra = Layout.from_json(text)
        except StoreError as error:
            raise StoreError(f"{file}: {error}") from error
        return cls(path, layout, str(extra.get("run_id")), extends=bool(extra.get("extends")), study=study)

    def to_json(self) -> str:
        """The text of the layout file."""
        return self.layout.to_json(run_id=self.run_id, extends=int(self.extends))

    def parts(self) -> list[Path]:
        """The part files, in the order in which they were written."""
        try:
            found = [p for p in self.folder.iterdir() if part_number(p) is not None]
        except OSError as error:
            raise StoreError.from_os(self.folder, error) from error
        return sorted(found, key=lambda p: part_number(p) or 0)

    def results(self) -> Results:
        """All that is finished, in one view."""
        sources: list[Source] = []
        layout = self.layout
        if self.extends and is_there(self.path):
            sources.append(as_of(ResultsSource(self.path, self.study), layout))
        for part in self.parts():
            source = PartSource(part, layout)
            if source.run_id == self.run_id:
                sources.append(source)
            source.close()
        layout, sources, unsettled = solved_only(layout, sources, self._unsettled())
        return Results(self.path, layout, sources, finished=False, study=self.study, unsettled=unsettled)

    def note_unsettled(self, unsettled: NDArray[np.int64]) -> None:
        """Keep which cases of a refined grid (flat indices) have a peak that may still change."""
        file = self.folder / UNSETTLED_FILE
        try:
            write_text(file, json.dumps({"run_id": self.run_id, "cases": unsettled.tolist()}))
        except OSError as error:
            raise StoreError.from_os(file, error) from error

    def _unsettled(self) -> NDArray[np.int64] | None:
        """What was noted last; all cases before the first note; None of a grid that is not refined."""
        if refined_axis(self.layout) is None:
            return None
        file = self.folder / UNSETTLED_FILE
        try:
            data = json.loads(read_plain(file, _LAYOUT_BYTES))
            if data["run_id"] == self.run_id:
                cases = np.array(data["cases"], dtype=np.int64).reshape(-1)
                if np.all((cases >= 0) & (cases < self.layout.size)):
                    return cases
                raise StoreError(f"{file}: names a case outside the grid")
        except OSError as error:
            if not is_missing(error):
                raise StoreError.from_os(file, error) from error
        except (ValueError, KeyError, TypeError, OverflowError, RecursionError) as error:
            raise StoreError(f"{file}: is not what tbi writes there") from error
        return np.arange(self.layout.size)


def as_of(source: ResultsSource, layout: Layout) -> Source:
    """A results file as a source of the run with that layout, which completes it.

    Raises `StoreError` if it has other axes or channels.
    """
    found = source.layout
    source.layout = replace(found, history_channels=layout.history_channels)
    check_same_grid(found, layout, source.path)
    if refined_axis(layout) is None:
        return source
    try:
        return MovedSource(source, numbers_in(found.dims, [dim.values for dim in layout.dims]))
    except StoreError as error:
        raise StoreError(f"{source.path}: {error}") from error


def check_same_grid(a: Layout, b: Layout, path: Path) -> None:
    """Raise `StoreError` unless both layouts have the same grid, channels and amplification factors.

    On an axis that is refined in `b` each has the values that it came to.
    """
    refined = refined_axis(b)
    same = (
        [d.name for d in a.dims] == [d.name for d in b.dims]
        and all(
            k == refined or x.values.tobytes() == y.values.tobytes()
            for k, (x, y) in enumerate(zip(a.dims, b.dims, strict=True))
        )
        and [c.name for c in a.channels] == [c.name for c in b.channels]
        and [c.name for c in a.history_channels] == [c.name for c in b.history_channels]
        and a.daf == b.daf
    )
    if not same:
        raise StoreError(f"{path}: has other axes or channels")
