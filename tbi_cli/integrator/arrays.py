"""The arrays that the integrator works on: what many scenarios share, what each brings, and the work space.

Every float array is C-contiguous float64 with the lanes in its last axis.  A *row* is one lane vector; a
*place* is how many bytes of rows stand before it.
The signal array stacks, in this order, what a channel can be made of:

    x | x' | x'' | P of each wheel | w | w' | w'' under each | its time aloft | static moment over L and
    static shear of each station, beam by beam | weighted sums | low-passed signals | x'' of stages 2-4

with `n_dof` rows for each of x, x', x'' (the vehicle's coordinates, then the modal amplitudes of each beam).
"""

from __future__ import annotations

from math import prod
from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

LANES = 8
ROW = 8 * LANES  # bytes of a lane vector

# Arrays of kernels, with their type and number of axes.
Index = Annotated[NDArray[np.int64], np.int64, 1]
Vector = Annotated[NDArray[np.float64], np.float64, 1]
Lanes = Annotated[NDArray[np.float64], np.float64, 2]
History = Annotated[NDArray[np.float64], np.float64, 3]  # sample, channel kept, lane
Rails = Annotated[NDArray[np.float64], np.float64, 3]  # see `rails`


class Topology(NamedTuple):
    """What every scenario of a batch has in common: which entries there are, not their values."""

    n_modes: int
    beams: int
    stations: int  # places of each beam where static moment and shear are wanted
    static_row: int  # where blocks of the signal array begin: static moments and shears,
    sum_row: int  # weighted sums,
    filter_row: int  # low-passed signals,
    stage_row: int  # x'' of stages 2-4
    forces: bool  # whether all wheels are constant forces, one on each axle, on one beam
    wheel_signals: bool  # whether P, w or its derivatives are wanted
    convective: bool  # whether dampers feel v phi' q
    unilateral: bool  # whether a wheel may lift off: its spring is then not part of A
    irregular: bool  # whether the rails have a profile
    term_row: Index  # coordinates in the order of their number of terms: equal loops follow each other
    term_begin: Index  # per entry of term_row, its terms of A: places in term
    term_end: Index
    term: Index  # of each term, place in signal (x or x') of what it multiplies + 2^32 place in Crossing.term
    axle_wheel_begin: Index  # per axle, its wheels
    axle_wheel_end: Index
    wheel_begin: Index  # per wheel, the terms of its row g
    wheel_end: Index
    wheel_col: Index  # coordinate of each term of g
    wheel_mode: Index  # per wheel, the coordinate of the first mode of its beam
    wheel_rail: Index  # per wheel, 0 on the right rail, 1 on the left
    sum_begin: Index  # per weighted sum, its terms
    sum_end: Index
    sum_col: Index  # signal row of each term
    filter_col: Index  # per low-passed signal, the signal row that it is made of
    filter_beam: Index  # and the beam whose filter it passes
    channel: Index  # signal row of each channel whose reductions are taken
    history: Index  # signal row of each channel that a history keeps


class Crossing(NamedTuple):
    """The numbers of the scenarios that are in the lanes now (or, with scenarios last, of a whole batch)."""

    scale: Lanes  # h, h/2, h/6, h^2/6, v/L, x0/L; v, number of the first interval of the rails, 1/(v h)
    wave: Lanes  # per mode, i pi v/L
    term: Lanes  # the different entries of A
    axle: Lanes  # per axle: cos, sin of pi offset/L; entry, exit in steps; place on the rails at the start
    wheel: Lanes  # per wheel: k, c, f_g, 2/(mu L)
    wheel_g: Lanes  # entries of g
    wheel_gm: Lanes  # entries of g over the mass of their coordinate
    sum_offset: Lanes
    sum_coef: Lanes
    station: Lanes  # per station: x/L; the same, but 2 at the end of the beam
    low_pass: Lanes  # per beam and biquad: b0, b1, b2, a1, a2
    mode: Lanes  # of trains of forces, per mode: omega^2, damping
    exact: Lanes  # of them, per mode: E11, E12, E21, E22, a1, a2, b1, b2 of `exact`; none for Runge-Kutta


class Work(NamedTuple):
    """State and scratch space of one block of lanes."""

    state: Lanes  # x | x' at the start of the step
    signal: Lanes
    sine: Lanes  # sin(i pi xi/L) by instant (start, middle, end of the step), axle and mode
    cosine: Lanes
    on: Lanes  # per axle: 1 where it is on the bridge at the start of this step, and during it; see axles_on
    active: Index  # per axle, 1 if any lane has it on, 2 if it enters or leaves in any
    window: Index  # first axle that may be on the bridge in any lane, and the first behind these
    force: Lanes  # see forces
    due: Lanes  # step at which the forces on the bridge change next; the step under way
    standing: Index  # per lane, the first force that stands on the bridge; per lane, the first behind these
    filter: Lanes  # per low-passed signal and biquad: its two states
    rail: Lanes  # by instant and wheel: r, v r', v^2 r''
    rails: Rails
    interval: Lanes  # per axle, the interval of the rails that it is on: see `rails`
    corner: Lanes  # per wheel, what the corners that it passes in this step add in the middle to r and v r'
    step: Lanes  # number of the step about to be taken, per lane
    reduced: Lanes  # per channel: sum of squares, max, min, step of max, step of min


def lane_zeros(*shape: int) -> NDArray[np.float64]:
    """Zeros of shape (*shape, LANES) aligned to a cache line, so that no vector straddles two."""
    n = prod(shape) * LANES * 8
    raw = np.zeros(n + 64, dtype=np.uint8)
    start = -raw.ctypes.data % 64
    aligned: NDArray[np.float64] = raw[start : start + n].view(np.float64)
    return aligned.reshape(*shape, LANES)


# One interval without end, for both rails; the last four numbers say where it is.
LEVEL_RAILS = np.zeros((1, 3, 4))
LEVEL_RAILS[0, 2, 2] = np.inf


def work_space(topology: Topology, rails: NDArray[np.float64] = LEVEL_RAILS) -> Work:
    """Room for a block of lanes; see `put_to_rest`."""
    nd, n = topology.term_begin.size, topology.n_modes
    axles, wheels = topology.axle_wheel_begin.size, topology.wheel_mode.size
    return Work(
        state=lane_zeros(2 * nd),
        signal=lane_zeros(topology.stage_row + 3 * nd),
        sine=lane_zeros(3 * max(axles, 1) * n),
        cosine=lane_zeros(3 * max(axles, 1) * n),
        on=lane_zeros(7 * axles),
        active=np.zeros(axles, dtype=np.int64),
        window=np.zeros(2, dtype=np.int64),
        force=lane_zeros(5 * n),
        due=lane_zeros(2),
        standing=np.zeros(2 * LANES, dtype=np.int64),
        filter=lane_zeros(4 * topology.filter_col.size),
        rail=lane_zeros(9 * wheels),
        rails=rails,
        interval=lane_zeros(5 * axles),
        corner=lane_zeros(2 * wheels),
        step=lane_zeros(1),
        reduced=lane_zeros(5 * topology.channel.size),
    )


def put_to_rest(work: Work) -> None:
    """A block of lanes at rest before its first step, nothing reduced yet."""
    for values in work:
        if values is not work.rails:
            values.fill(0)
    work.reduced[1::5] = -np.inf
    work.reduced[2::5] = np.inf
