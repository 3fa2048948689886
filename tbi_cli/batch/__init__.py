"""Scenarios side by side: from systems, speeds and time grids to the arrays of the integrator."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tbi_cli.batch.entries import Entries
from tbi_cli.batch.low_pass import low_pass_filters
from tbi_cli.batch.model import Model
from tbi_cli.batch.rails import Rails
from tbi_cli.batch.rows import SignalRows
from tbi_cli.integrator import kernel_cache
from tbi_cli.integrator.arrays import ROW, Crossing, Topology
from tbi_cli.timegrid import TimeGrid
from tbi_cli.track import RailProfile

__all__ = ["Batch", "Crosser", "Model", "build_batch"]


@dataclass(frozen=True)
class Crosser:
    """One scenario, ready to be integrated: what crosses what, how fast, and when it is looked at."""

    model: Model
    velocity: float
    grid: TimeGrid
    rails: RailProfile | None = None
    exact: bool = False


@dataclass(frozen=True)
class Batch:
    """Scenarios of one structure: what the integrator needs to solve them.

    The arrays of `crossing` have the scenarios in their last axis.  `last` is each scenario's last sample.
    `rails` are those that any of them has.
    """

    topology: Topology
    crossing: Crossing
    substeps: int
    last: NDArray[np.int64]
    rails: NDArray[np.float64]


def build_batch(crossers: Sequence[Crosser], table: Sequence[int], history: Sequence[int]) -> Batch:
    """The arrays of scenarios of one structure and one number of substeps.

    `table` and `history` list the channels (by their place in the model) that are reduced and recorded.
    """
    models = list({id(c.model): c.model for c in crossers}.values())
    which = {id(model): i for i, model in enumerate(models)}
    pick = np.array([which[id(c.model)] for c in crossers])
    system = models[0].system
    nv, n = len(system.coordinates), len(system.beams[0].omega)
    nd = nv + n * len(system.beams)

    A, values = Entries.common([model.matrix for model in models])
    term_begin, term_end = _ranges(A.row, nd)
    term_row = np.argsort(term_end - term_begin, kind="stable")
    # Many entries are equal, of springs on either side and of equal vehicles: each is kept once.
    values, term_value = np.unique(values, axis=1, return_inverse=True)
    rows, wheel_g = Entries.common([model.wheel_rows for model in models])
    wheel_begin, wheel_end = _ranges(rows.row, len(system.wheel_axle))
    masses = np.stack([model.system.M for model in models])
    order = np.argsort(system.wheel_axle, kind="stable")
    assert np.array_equal(order, np.arange(len(order))), "wheels are listed axle by axle"
    axle_begin, axle_end = _ranges(system.wheel_axle, len(system.axle_offsets))

    forces = all(model.system.constant_forces for model in models)
    rails = Rails([None if forces else c.rails for c in crossers])
    signals = SignalRows(models, sorted({*table, *history}))
    topology = Topology(
        n_modes=n,
        beams=len(system.beams),
        stations=len(system.stations) if signals.of_stations else 0,
        static_row=signals.static,
        sum_row=signals.sums,
        filter_row=signals.filters,
        stage_row=signals.stages,
        forces=forces,
        wheel_signals=signals.of_wheels or (signals.of_stations and not forces),
        convective=system.convective,
        unilateral=system.unilateral,
        irregular=rails.irregular,
        term_row=term_row,
        term_begin=term_begin[term_row],
        term_end=term_end[term_row],
        term=ROW * (A.column + (term_value.ravel() << 32)),
        axle_wheel_begin=axle_begin,
        axle_wheel_end=axle_end,
        wheel_begin=wheel_begin,
        wheel_end=wheel_end,
        wheel_col=rows.column,
        wheel_mode=nv + n * system.wheel_beam,
        wheel_rail=system.wheel_beam,
        sum_begin=signals.begin,
        sum_end=signals.end,
        sum_col=signals.col,
        filter_col=signals.filter_col,
        filter_beam=signals.filter_beam,
        channel=np.array([signals.row_of[c] for c in table], dtype=np.int64),
        history=np.array([signals.row_of[c] for c in history], dtype=np.int64),
    )

    velocity = np.array([c.velocity for c in crossers])
    h = np.array([c.grid.h for c in crossers])
    length = np.array([c.model.system.length for c in crossers])
    offset = np.stack([model.system.axle_offsets for model in models])[pick].T
    start = np.array([c.grid.start * c.velocity for c in crossers])
    entry, exit_ = (offset - start) / (velocity * h), (offset + length - start) / (velocity * h)
    angles = np.stack([model.angles for model in models])[pick]
    # An event within rounding of a step is taken to fall on it.
    entry, exit_ = (np.where(np.abs(e - np.rint(e)) < 1e-7, np.rint(e), e) for e in (entry, exit_))
    place = start - offset - rails.begin + rails.lead
    axle = np.stack([angles[:, :, 0].T, angles[:, :, 1].T, entry, exit_, place], axis=1)
    sampling = np.array([c.grid.sampling for c in crossers])
    cut_off = np.array([[beam.low_pass for beam in model.system.beams] for model in models])
    scale = (h, h / 2, h / 6, h * h / 6, velocity / length, start / length)
    crossing = Crossing(
        scale=np.stack([*scale, velocity, rails.first, 1 / (velocity * h)]),
        wave=np.arange(1, n + 1)[:, None] * np.pi * (velocity / length),
        term=_by_scenario(values, pick),
        axle=np.ascontiguousarray(axle.reshape(-1, len(crossers))),
        wheel=_by_scenario(np.stack([model.wheels.ravel() for model in models]), pick),
        wheel_g=_by_scenario(wheel_g, pick),
        wheel_gm=_by_scenario(wheel_g / masses[:, rows.column], pick),
        sum_offset=_by_scenario(signals.offset, pick),
        sum_coef=_by_scenario(signals.coef, pick),
        station=_by_scenario(np.stack([model.stations.ravel() for model in models]), pick),
        low_pass=low_pass_filters(cut_off[pick].T * sampling),
        mode=_modes(crossers) if forces else np.zeros((0, len(crossers))),
        exact=_one_interval(crossers) if crossers[0].exact else np.zeros((0, len(crossers))),
    )
    last = np.array([c.grid.last for c in crossers], dtype=np.int64)
    return Batch(topology, crossing, crossers[0].grid.substeps, last, rails.intervals)


def _modes(crossers: Sequence[Crosser]) -> NDArray[np.float64]:
    """omega^2 and damping of each mode of the (one) beam and of each scenario."""
    beams = [c.model.system.beams[0] for c in crossers]
    rows = [np.stack([beam.omega**2, beam.damping], axis=1).ravel() for beam in beams]
    return np.stack(rows, axis=1)


def _one_interval(crossers: Sequence[Crosser]) -> NDArray[np.float64]:
    """What the exact solution needs to know of each mode of the (one) beam and of each scenario."""
    modes = _modes(crossers)
    stiffness, damping = modes[::2].copy(), modes[1::2].copy()
    pace = np.array([np.pi * c.velocity / c.model.system.length for c in crossers])
    found = np.empty((8 * len(stiffness), len(crossers)))
    interval = np.array([c.grid.sampling for c in crossers])
    kernel_cache.call("one_interval", stiffness, damping, pace, interval, found)(len(stiffness))
    return found


def _by_scenario(values: NDArray[np.float64], pick: NDArray[np.int64]) -> NDArray[np.float64]:
    """Rows of values with the scenarios last, from values (models, rows)."""
    return np.ascontiguousarray(values[pick].T)


def _ranges(owner: NDArray[np.int64], count: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Where the run of each owner begins and ends in a sorted list of owners."""
    begin = np.searchsorted(owner, np.arange(count))
    end = np.searchsorted(owner, np.arange(count), side="right")
    return begin.astype(np.int64), end.astype(np.int64)
