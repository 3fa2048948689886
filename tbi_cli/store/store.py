"""The writing end: one results file, growing batch by batch, safe against whatever stops it."""

from __future__ import annotations

import os
import secrets
from collections.abc import Sequence
from pathlib import Path
from types import TracebackType

import numpy as np
from numpy.typing import NDArray

from tbi_cli.store.assemble import write_results
from tbi_cli.store.claim import Claim, check_output, check_path
from tbi_cli.store.compare import refuse_other_run
from tbi_cli.store.durable import write_text
from tbi_cli.store.errors import StoreError
from tbi_cli.store.layout import Layout
from tbi_cli.store.opening import Run, as_of, is_there, look_first
from tbi_cli.store.parts import LAYOUT_FILE, part_number, write_part
from tbi_cli.store.picked import numbers_in, settled
from tbi_cli.store.records import DONE, BatchResult
from tbi_cli.store.results import Results
from tbi_cli.store.sources import ResultsSource


class ResultsStore:
    """Takes the batches of a run and makes a results file of them.

    Each batch is on the disk, in a file of its own, when `write` returns; `finish` puts them together.  Only
    one process at a time may hold the store of a path.  An existing file, or the finished cases of an
    interrupted run, are touched only with ``resume`` (they count as done where they were solved) or
    ``overwrite`` (they go; an existing file stays until the new one replaces it).  Every trouble with the
    disk is a `StoreError`, and leaves what was there before.

    ``claim`` is given where this is one study of several: the claim on its folder, within the run's own.

    Raises `StoreError` on opening, with nothing left behind, if the place cannot be written to, if another
    process writes there, or if what is to be resumed is another case or comes from another version.
    """

    def __init__(
        self,
        path: str | os.PathLike[str],
        layout: Layout,
        *,
        resume: bool = False,
        overwrite: bool = False,
        claim: Claim | None = None,
    ) -> None:
        self.path = check_output(path, resume=resume, overwrite=overwrite) if claim is None else claim.path
        self.layout = layout
        self._study = "" if claim is None else claim.folder.name
        self._claim = Claim(self.path) if claim is None else claim
        try:
            if claim is None:
                check_path(self.path, resume=resume, overwrite=overwrite)  # now that nobody else writes
            self._done = np.zeros(layout.size, dtype=bool)
            self._run = self._continue() if resume else self._begin(extends=False)
            self._claim.clean(parts=False)
            self._next = 1 + max((part_number(p) or 0 for p in self._run.parts()), default=-1)
        except BaseException:
            self.close()
            raise

    def __enter__(self) -> ResultsStore:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _begin(self, *, extends: bool) -> Run:
        """A new run; once its layout is written, the parts of an older one no longer count."""
        run = Run(self.path, self.layout, secrets.token_hex(8), extends=extends, study=self._study)
        layout_file = self._claim.folder / LAYOUT_FILE
        try:
            write_text(layout_file, run.to_json())
        except OSError as error:
            raise StoreError.from_os(layout_file, error) from error
        for part in run.parts():
            part.unlink()
        return run

    def _continue(self) -> Run:
        """The run that was interrupted, or one that completes the file that is there, or a new one."""
        look_first(self.path, self._study)
        run = Run.read(self.path, self._study)
        if run is not None and run.parts():
            refuse_other_run(str(run.folder), run.layout.attributes, self.layout.attributes)
            run.layout = self.layout
            with run.results() as results:
                self._note_done(results)
            return run
        if not is_there(self.path):
            return self._begin(extends=False)
        source = ResultsSource(self.path, self._study)
        refuse_other_run(str(self.path), source.layout.attributes, self.layout.attributes)
        with Results(self.path, self.layout, [as_of(source, self.layout)], finished=True) as results:
            self._note_done(results)
        return self._begin(extends=True)

    def _note_done(self, results: Results) -> None:
        self._done[self._numbers(results)] = results.status.ravel() == DONE

    def _numbers(self, results: Results) -> NDArray[np.int64]:
        """The flat index in the whole grid of each case of results, which may lack speeds."""
        return numbers_in(results.layout.dims, [dim.values for dim in self.layout.dims])

    def done(self) -> NDArray[np.bool_]:
        """Which cases are solved already, (number of cases,) by flat index; failed ones are not."""
        return self._done.copy()

    def write(self, batch: BatchResult) -> None:
        """Put a batch on the disk.  When this returns, neither a crash nor a power cut can take it away.

        Raises `StoreError` if the disk refuses; the batches before are safe.  ValueError for a batch that
        does not fit the layout.
        """
        self._claim.check()
        write_part(self._claim.folder, self._next, self._run.run_id, self.layout, batch)
        self._next += 1
        self._done[batch.indices] |= batch.status == DONE

    def solved_peaks(self, columns: Sequence[int]) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """The cases that are solved, by flat index, and their peaks (cases, columns)."""
        with self.results() as results:
            done = results.status.ravel() == DONE
            peaks = results.tables(["peak"])["peak"][list(columns)]
            return self._numbers(results)[done], peaks[:, done].T

    def note_unsettled(self, unsettled: NDArray[np.int64]) -> None:
        """Keep which cases of a refined grid (flat indices) have a peak that may still change."""
        self._claim.check()
        self._run.note_unsettled(unsettled)

    @property
    def parts(self) -> dict[str, ResultsStore]:
        """The stores of its grids by name: of a file of one grid, itself."""
        return {"": self}

    @property
    def has_news(self) -> bool:
        """Whether there is anything that the results file does not hold yet."""
        return bool(self._run.parts()) or not (self._run.extends and is_there(self.path))

    def results(self) -> Results:
        """All that is finished, in one view."""
        return self._run.results()

    def finish(self) -> Path:
        """Make the results file from all batches, remove them, give the store up; returns the file's path.

        Cases that were never written have status 0 there.  Raises `StoreError` if the disk refuses; all
        batches are then still safe, and a resumed run needs only to finish.
        """
        self._claim.check()
        kept = f"the finished cases are safe in {self._claim.folder}"
        if self.has_news:
            with self.results() as results:
                results.layout = settled(results.layout)
                write_results(self.path, self._claim.folder, results.layout, results, kept)
        self._claim.clean(parts=True)
        self.close()
        return self.path

    def close(self) -> None:
        """Give the store up.  Batches that were written stay, for a later run to resume."""
        if not self._claim.has_parts:
            self._claim.clean(parts=True)
        self._claim.release()
