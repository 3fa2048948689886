"""Several studies in one results file: each a group that holds what the root of a file of its own would."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType

import numpy as np
from numpy.typing import NDArray

from tbi_cli.store import safe
from tbi_cli.store.assemble import write_group
from tbi_cli.store.claim import Claim, check_output, check_path
from tbi_cli.store.compare import refuse_other_run
from tbi_cli.store.durable import new_h5, write_text
from tbi_cli.store.errors import StoreError, is_missing
from tbi_cli.store.layout import FORMAT_VERSION, STUDIES_FORMAT, Layout, Scalar
from tbi_cli.store.netcdf import create_group, set_attributes
from tbi_cli.store.opening import Run, is_there, look_first, resolve
from tbi_cli.store.parts import STUDIES_FILE, parts_folder
from tbi_cli.store.picked import settled
from tbi_cli.store.plain import read_plain
from tbi_cli.store.records import BatchResult
from tbi_cli.store.results import Results
from tbi_cli.store.store import ResultsStore
from tbi_cli.store.vet import vet

_MOST_BYTES = 1 << 24  # of the file that names the studies of an unfinished run, with their case


@dataclass(frozen=True)
class Heading:
    """What stands above the studies of a file: their names, none for a file of one grid; root attributes."""

    names: tuple[str, ...]
    attributes: Mapping[str, Scalar]


def studies_of(path: str | os.PathLike[str]) -> tuple[str, ...]:
    """The names of the studies in the results file ``path``, or in the unfinished run that writes it.

    Empty for a file of one grid, and where there is no file at all, about which `open_results` has more to
    say.  Raises `StoreError` for a file that is damaged.
    """
    return heading_of(path).names


def heading_of(path: str | os.PathLike[str]) -> Heading:
    """What stands above the studies of a results file, or of the unfinished run that writes it.

    Without attributes where there is no file at all, or no batch of a single grid is in one yet.  Raises
    `StoreError` for a file that is damaged.
    """
    path = resolve(path)
    if not (is_there(path) and path.is_file()):
        return _of_parts(path) or Heading((), {})
    vet(path, lambda: _of_file(path))
    return _of_file(path)


def attributes_of(path: str | os.PathLike[str]) -> Mapping[str, Scalar]:
    """The root attributes of a results file, or of the unfinished run that writes it; see `heading_of`."""
    heading = heading_of(path)
    if heading.names or heading.attributes:
        return heading.attributes
    path = resolve(path)
    look_first(path)
    run = Run.read(path)
    return {} if run is None else run.layout.attributes


def write_studies(
    path: Path,
    scratch: Path,
    attributes: Mapping[str, Scalar],
    studies: Mapping[str, Results],
    kept: str = "",
) -> None:
    """Write the results of studies, by name, as the results file ``path``; see `write_results`."""
    with new_h5(path, scratch, kept) as new:
        set_attributes(new.file, {"format": STUDIES_FORMAT, "format_version": FORMAT_VERSION})
        set_attributes(new.file, {"studies": " ".join(studies), **attributes})
        for name, results in studies.items():
            write_group(new, create_group(new.file, name), results.layout, results)


def _of_file(path: Path) -> Heading:
    with safe.open_h5(path) as file, safe.reading(path):
        attributes = safe.read_attributes(file)
        there = set(safe.child_names(file))
        names = str(attributes.pop("studies", "")).split()
    if attributes.pop("format", None) != STUDIES_FORMAT:
        return Heading((), attributes)
    version = attributes.pop("format_version", None)
    if version != FORMAT_VERSION:
        found = f"has the format version {version!r:.40}"
        raise StoreError(f"{path}: {found}, this tbi reads {FORMAT_VERSION}")
    if not set(names) <= there or not _are_studies(names):
        raise StoreError(f"{path}: does not hold the studies that it should")
    return Heading(tuple(names), attributes)


def _of_parts(path: Path) -> Heading | None:
    file = parts_folder(path) / STUDIES_FILE
    try:
        data = json.loads(read_plain(file, _MOST_BYTES))
        if data["format_version"] != FORMAT_VERSION:
            raise StoreError(f"{file}: has the format version {data['format_version']!r:.20}")
        names = [str(name) for name in data["studies"]]
        if not _are_studies(names):
            raise StoreError(f"{file}: does not name studies")
        return Heading(tuple(names), {str(k): v for k, v in data["attributes"].items()})
    except OSError as error:
        if is_missing(error):
            return None
        raise StoreError.from_os(file, error) from error
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise StoreError(f"{file}: is not what tbi writes there") from error


def _are_studies(names: list[str]) -> bool:
    """Whether these can be studies: their names are those of folders too, beside the file."""
    from tbi_cli.case.studies import NAME

    return bool(names) and len(set(names)) == len(names) and all(re.fullmatch(NAME, name) for name in names)


class StudiesStore:
    """Takes the batches of a run of several studies and makes one results file of them; see `ResultsStore`.

    The grids of the studies stand one behind the other: a flat index counts through all of them.
    ``attributes`` are those of the root of the file.
    """

    def __init__(
        self,
        path: str | os.PathLike[str],
        layouts: Mapping[str, Layout],
        attributes: Mapping[str, Scalar],
        *,
        resume: bool = False,
        overwrite: bool = False,
    ) -> None:
        self.path = check_output(path, resume=resume, overwrite=overwrite)
        self._attributes = attributes
        self._claim = Claim(self.path)
        #: The stores of the studies by name.
        self.parts: dict[str, ResultsStore] = {}
        try:
            check_path(self.path, resume=resume, overwrite=overwrite)  # again, now that nobody else writes
            if not (resume and self._may_continue()):
                self._begin(layouts)
            for name, layout in layouts.items():
                claim = self._claim.study(name)
                self.parts[name] = ResultsStore(self.path, layout, resume=resume, claim=claim)
        except BaseException:
            self.close()
            raise
        self._ends = np.cumsum([layout.size for layout in layouts.values()])

    def __enter__(self) -> StudiesStore:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _may_continue(self) -> bool:
        """Whether there is an unfinished run to continue; raises `StoreError` if another case is there."""
        heading, where = _of_parts(self.path), str(self._claim.folder)
        if heading is None:
            look_first(self.path)
            run = Run.read(self.path)
            if run is not None and run.parts():
                refuse_other_run(where, run.layout.attributes, self._attributes)
            if is_there(self.path):
                old = _of_file(self.path).attributes
                refuse_other_run(str(self.path), old, self._attributes)
            return False
        refuse_other_run(where, heading.attributes, self._attributes)
        return True

    def _begin(self, layouts: Mapping[str, Layout]) -> None:
        """A new run; whatever an older one has left goes."""
        self._claim.clean(parts=True)
        file = self._claim.folder / STUDIES_FILE
        heading = {
            "format_version": FORMAT_VERSION,
            "studies": list(layouts),
            "attributes": dict(self._attributes),
        }
        try:
            write_text(file, json.dumps(heading, indent=1))
        except OSError as error:
            raise StoreError.from_os(file, error) from error

    def done(self) -> NDArray[np.bool_]:
        """Which cases are solved already, by flat index through all studies; failed ones are not."""
        return np.concatenate([store.done() for store in self.parts.values()])

    def write(self, batch: BatchResult) -> None:
        """Put a batch, all of one study, on the disk; see `ResultsStore.write`."""
        number = int(np.searchsorted(self._ends, batch.indices[0], side="right"))
        store = list(self.parts.values())[number]
        store.write(batch.moved(store.layout.size - int(self._ends[number])))

    def finish(self) -> Path:
        """Make the results file from all batches, remove them, give the store up; returns the file's path.

        Raises `StoreError` if the disk refuses; all batches are then still safe.
        """
        self._claim.check()
        if any(store.has_news for store in self.parts.values()):
            kept = f"the finished cases are safe in {self._claim.folder}"
            with ExitStack() as stack:
                found = {name: stack.enter_context(store.results()) for name, store in self.parts.items()}
                for results in found.values():
                    results.layout = settled(results.layout)
                write_studies(self.path, self._claim.folder, self._attributes, found, kept)
        self._claim.clean(parts=True)
        self._claim.release()
        return self.path

    def close(self) -> None:
        """Give the store up.  Batches that were written stay, for a later run to resume."""
        if not self._claim.has_parts:
            self._claim.clean(parts=True)
        self._claim.release()
