"""Reading results: one view of a grid, whether it lies in one file or in many."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType

import numpy as np
from numpy.typing import NDArray

from tbi_cli.printable import one_line
from tbi_cli.store.layout import Dim, Layout, Scalar, Variable
from tbi_cli.store.records import DONE, History
from tbi_cli.store.safe import reading
from tbi_cli.store.sources import Source

_OPEN_FILES = 64


class Results:
    """The results of a grid of cases.

    Where two sources hold the same case, the later one counts, but a failure never hides a solution.
    Arrays come in the grid's shape, NaN where nothing was computed.  Everything read from a damaged or
    foreign file raises `StoreError`.  Use it in a ``with`` block, or `close` it.
    """

    def __init__(
        self,
        path: Path,
        layout: Layout,
        sources: Sequence[Source],
        *,
        finished: bool,
        study: str = "",
        unsettled: NDArray[np.int64] | None = None,
    ) -> None:
        self.path = path
        #: Which study of the file this is; empty for a file of one grid.
        self.study = study
        self.layout = layout
        self.sources = tuple(sources)
        #: True if read from the results file itself, False if from the parts of an unfinished run.
        self.finished = finished
        #: Flat indices of cases with a peak that may change by more than a refined sweep's tolerance.
        self.unsettled = unsettled
        self._status = np.zeros(layout.size, dtype=np.int8)
        self._owner = np.full(layout.size, -1, dtype=np.int32)
        for k, source in enumerate(self.sources):
            counts = (source.status == DONE) | (self._status[source.indices] != DONE)
            self._status[source.indices[counts]] = source.status[counts]
            self._owner[source.indices[counts]] = k
        self._recent: OrderedDict[int, Source] = OrderedDict()

    def __enter__(self) -> Results:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Close the files."""
        for source in self.sources:
            source.close()
        self._recent.clear()

    @property
    def dims(self) -> tuple[Dim, ...]:
        """The swept axes."""
        return self.layout.dims

    @property
    def shape(self) -> tuple[int, ...]:
        """The grid's shape."""
        return self.layout.shape

    @property
    def channels(self) -> tuple[Variable, ...]:
        """The channels of the tables."""
        return self.layout.channels

    @property
    def attributes(self) -> dict[str, Scalar]:
        """Where the results come from: the root attributes, ``solve_seconds`` and ``case_steps`` included."""
        totals = {
            "solve_seconds": sum(s.solve_seconds for s in self.sources),
            "case_steps": sum(s.case_steps for s in self.sources),
        }
        return {**self.layout.attributes, **totals}

    @property
    def case_yaml(self) -> str:
        """The whole resolved case."""
        return str(self.layout.attributes.get("case", ""))

    @property
    def status(self) -> NDArray[np.int8]:
        """0 to do, 1 done, 2 failed; of the grid's shape."""
        return self._status.reshape(self.shape).copy()

    @property
    def converged(self) -> NDArray[np.int8] | None:
        """1, or 0 where a refined sweep did not reach its tolerance; of the grid's shape.

        0 too where nothing is solved; None of a sweep that is not refined.
        """
        if self.unsettled is None:
            return None
        found = (self._status == DONE).astype(np.int8)
        found[self.unsettled] = 0
        return np.asarray(found.reshape(self.shape))

    @property
    def messages(self) -> dict[int, str]:
        """Why cases failed, by flat index."""
        found: dict[int, str] = {}
        for k in self._owners(self._status > DONE):
            with self._source(k) as source:
                texts = source.messages.items()
            found.update({i: one_line(text) for i, text in texts if self._owner[i] == k})
        return dict(sorted(found.items()))

    def table(self, group: str, name: str) -> NDArray[np.float64]:
        """A variable, e.g. ``table("peak", "car_body_y")`` or ``table("daf", "right")``, in the grid's shape.

        Raises KeyError if the file has no such group or variable.
        """
        if group not in self.layout.groups:
            raise KeyError(group)
        names = [variable.name for variable in self.layout.columns(group)]
        if name not in names:
            raise KeyError(name)
        values = np.full(self.layout.size, np.nan)
        for k in self._owners(self._status != 0):
            with self._source(k) as source:
                own = self._owner[source.indices] == k
                values[source.indices[own]] = source.column(group, names.index(name))[own]
        return values.reshape(self.shape)

    def tables(self, groups: Sequence[str]) -> dict[str, NDArray[np.float64]]:
        """Whole table groups at once: (number of variables, number of cases), reading each file once."""
        found = {g: np.full((len(self.layout.columns(g)), self.layout.size), np.nan) for g in groups}
        for k in self._owners(self._status != 0):
            with self._source(k) as source:
                own = self._owner[source.indices] == k
                for group, values in source.tables(groups).items():
                    found[group][:, source.indices[own]] = values[own].T
        return found

    @property
    def history_channels(self) -> tuple[Variable, ...]:
        """The channels of the histories."""
        return self.layout.history_channels

    def history_indices(self) -> list[int]:
        """The flat indices of the cases that have a history, in ascending order."""
        found: list[int] = []
        if self.history_channels:
            for k in self._owners(self._status == DONE):
                with self._source(k) as source:
                    found += [i for i in source.history_indices() if self._owner[i] == k]
        return sorted(found)

    def history(self, index: int, names: Sequence[str] | None = None) -> History:
        """The history of the case with that flat index: all channels, or those named, in that order.

        Only what is asked for is read.  Raises KeyError if there is no such history or channel.
        """
        stored = [variable.name for variable in self.history_channels]
        rows = None if names is None else [stored.index(n) if n in stored else _missing(n) for n in names]
        if not 0 <= index < self.layout.size or self._owner[index] < 0:
            raise KeyError(index)
        with self._source(int(self._owner[index])) as source:
            if index not in source.history_indices():
                raise KeyError(index)
            return source.history(index, rows)

    def _owners(self, cases: NDArray[np.bool_]) -> list[int]:
        """The sources that count for any of these cases."""
        return [int(k) for k in np.unique(self._owner[cases])]

    @contextmanager
    def _source(self, k: int) -> Iterator[Source]:
        """Source ``k``, open; of many only the latest stay open."""
        source = self.sources[k]
        self._recent[k] = source
        self._recent.move_to_end(k)
        if len(self._recent) > _OPEN_FILES:
            self._recent.popitem(last=False)[1].close()
        with reading(source.path):
            yield source


def _missing(name: str) -> int:
    raise KeyError(name)
