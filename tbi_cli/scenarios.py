"""The grid of a case: one scenario per point, numbered row-major from 0."""

from __future__ import annotations

import math
import threading
from collections import OrderedDict
from collections.abc import Iterable, Iterator

import numpy as np

from tbi_cli.batch import Crosser, Model
from tbi_cli.case import Axis, Case
from tbi_cli.case.checks import check_train
from tbi_cli.case.fields import BadValueError
from tbi_cli.case.part import replaced
from tbi_cli.responses import channels
from tbi_cli.system.assembly import System, build_system
from tbi_cli.timegrid import Pace, UnstableStepError, pace_of, time_grid
from tbi_cli.track import RailProfile, rail_profile

# Keys that decide how a scenario is crossed and looked at, not what crosses what.
_NOT_THE_MODEL = ("velocity", "solver.sampling", "solver.substeps", "solver.duration")
_COORDINATES_KEPT = 20_000  # of all models together; one takes some 4 kB
_COORDINATES_OF_A_MODEL = 16  # counted for what does not grow with them
_RAILS_KEPT = 256 * 2**20  # bytes
_PACES_KEPT = 10_000
_CASES_KEPT = 1000


def _not_the_model(path: str) -> bool:
    return path in _NOT_THE_MODEL or path.startswith("track.")


def _size(model: Model) -> int:
    return _COORDINATES_OF_A_MODEL + len(model.system.coordinates)


def _of_the_track(path: str) -> bool:
    return path == "bridge.length" or path.startswith("track.")


class Scenarios:
    """Every scenario of a case, made when it is asked for; models that scenarios share are made once.

    Safe to use from several threads.  Memory does not grow with the grid: only the last few models are kept.
    """

    def __init__(self, case: Case) -> None:
        self.case = case
        self.axes: tuple[Axis, ...] = case.axes
        self.shape = tuple(len(axis.values) for axis in self.axes)
        self._model_axes = [k for k, axis in enumerate(self.axes) if not all(map(_not_the_model, axis.paths))]
        self._track_axes = [k for k, axis in enumerate(self.axes) if any(map(_of_the_track, axis.paths))]
        self._rails: OrderedDict[tuple[float, ...], RailProfile] = OrderedDict()
        self._models: OrderedDict[tuple[float, ...], Model] = OrderedDict()
        self._kept = 0
        self._cases: dict[tuple[float, ...], Case] = {}
        self._lock = threading.Lock()

    def __len__(self) -> int:
        return math.prod(self.shape)

    @property
    def model_count(self) -> int:
        """How many models the grid has, no two of its values taken to give the same one."""
        return math.prod(self.shape[k] for k in self._model_axes)

    def values(self, index: int) -> tuple[float, ...]:
        """The axis values of a scenario, in the order of the axes."""
        place = np.unravel_index(index, self.shape) if self.shape else ()
        return tuple(axis.values[i] for axis, i in zip(self.axes, place, strict=True))

    def case_of(self, index: int) -> Case:
        """The single case that a scenario is."""
        if not self.axes:
            return self.case.at({})
        *before, value = self.values(index)
        case = self._case_before(tuple(before))
        for chain, number in self.axes[-1].settings(value):
            case = replaced(case, chain, number)
        return case

    def _case_before(self, values: tuple[float, ...]) -> Case:
        """The case with all axes but the last set; neighbours in the grid share it."""
        known = self._cases.get(values)
        if known is None:
            names = [axis.name for axis in self.axes]
            known = self.case.at(dict(zip(names, values, strict=False)))
            if len(self._cases) >= _CASES_KEPT:
                self._cases.clear()
            self._cases[values] = known
        return known

    def model_key(self, index: int) -> tuple[float, ...]:
        """The axis values that decide what crosses what: equal keys, equal models."""
        values = self.values(index)
        return tuple(values[k] for k in self._model_axes)

    def model(self, index: int, case: Case | None = None) -> Model:
        """The model of a scenario."""
        key = self.model_key(index)
        with self._lock:
            if key in self._models:
                self._models.move_to_end(key)
                return self._models[key]
        case = case or self.case_of(index)
        made = make_model(case, self._system(index, case))
        with self._lock:
            if key not in self._models:
                self._models[key] = made
                self._kept += _size(made)
            while self._kept > _COORDINATES_KEPT and len(self._models) > 1:
                self._kept -= _size(self._models.popitem(last=False)[1])
        return made

    def rails(self, index: int, case: Case) -> RailProfile | None:
        """The rails of a scenario, where they are not level."""
        if case.track is None:
            return None
        values = self.values(index)
        key = tuple(values[k] for k in self._track_axes)
        with self._lock:
            if key in self._rails:
                self._rails.move_to_end(key)
                return self._rails[key]
        made = rail_profile(case.track, case.bridge.length)
        with self._lock:
            self._rails[key] = made
            while len(self._rails) * made.cubics.nbytes > _RAILS_KEPT and len(self._rails) > 1:
                self._rails.popitem(last=False)
        return made

    def crosser(self, index: int) -> Crosser:
        """A scenario ready to be integrated."""
        case = self.case_of(index)
        model = self.model(index, case)
        grid, exact = time_grid(case, model.pace), case.solver.method == "exact"
        return Crosser(model, case.velocity, grid, self.rails(index, case), exact)

    def paces(self, indices: Iterable[int]) -> Iterator[tuple[int, Case, Pace]]:
        """Each scenario with its single case and what its time grid depends on."""
        known: dict[tuple[float, ...], Pace] = {}
        for index in indices:
            case, key = self.case_of(index), self.model_key(index)
            if key not in known:
                if len(known) == _PACES_KEPT:
                    known.clear()
                known[key] = pace_of(self._system(index, case))
            yield index, case, known[key]

    def _system(self, index: int, case: Case) -> System:
        """The system of a scenario.  Raises RunError where swept numbers do not go together.

        Most of these are found when the case is read, but not in a large design.
        """
        try:
            check_train(case)
        except BadValueError as error:
            key = next(
                (f"sweep.{a.key}" for a in self.axes for p in a.paths if p.startswith("train.")), "train"
            )
            raise self.case.refused(key, str(error), at=self.describe(index)) from None
        return build_system(case)

    def describe(self, index: int) -> str:
        """The axis values of a scenario in words, for messages."""
        at = [
            (column, column.values[int(value)] if axis.members else value)
            for axis, value in zip(self.axes, self.values(index), strict=True)
            for column in axis.members or (axis,)
        ]
        return ", ".join(
            f"{axis.name} = {value:g}" + ("" if axis.units == "1" else f" {axis.units}") for axis, value in at
        )


def make_model(case: Case, system: System | None = None) -> Model:
    """The model of a single case, whose system may be there already."""
    system = system or build_system(case)
    return Model(system, tuple(channels(case, system)), pace_of(system))


__all__ = ["Scenarios", "UnstableStepError", "make_model"]
