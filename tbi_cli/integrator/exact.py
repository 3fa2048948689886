"""Trains of constant forces solved exactly: a mode is an oscillator that sinusoids drive, piecewise in time.

Between two events, a force that enters or leaves, mode i obeys

    q'' + d q' + omega^2 q = S(t),    S = A sin(i p t) + B cos(i p t),   p = pi v/L,

and so does its state one sampling interval h later:

    (q, q')  <-  E (q, q') + a S + b C,    C = A cos(i p t) - B sin(i p t),

with a matrix E and vectors a, b of the mode that depend on h alone.  A force that enters within an interval,
r before its end, starts there from S = 0, C = F; what it adds is F b(r).  One that leaves is another, of
opposite sign, that enters: beyond the bridge the two cancel.  Nothing is approximated but by rounding.
"""

from __future__ import annotations

from math import ceil, floor, inf, pi
from typing import Any

from tbi_cli.integrator.arrays import LANES, Crossing, History, Lanes, Topology, Vector, Work
from tbi_cli.integrator.forces import changes_due, stand, waves
from tbi_cli.integrator.kernel import record
from tbi_cli.integrator.lanes import fma, load, splat, store
from tbi_cli.integrator.primitives import flush_subnormals, inlined, subroutine
from tbi_cli.integrator.sampling import take_sample
from tbi_cli.integrator.shapes import axles_on

# The powers of a Taylor series of which one step is made, and the largest angle of such a step: what is left
# out is below 1/20! = 4e-19.
_POWERS = 20
_LARGEST = 1.0


@subroutine
def _oscillate(
    q: float, rate: float, s: float, c: float, stiffness: float, damping: float, pace: float, time: float
) -> Any:
    """State of an oscillator after some time: q'' + damping q' + stiffness q = s cos(pace t) + c sin(pace t).

    In so many equal Taylor steps that the next power is below rounding.
    """
    fastest = max(stiffness**0.5, damping, pace)
    steps = max(ceil(fastest * time / _LARGEST), 1)
    h = time / steps
    wave = pace * h
    for _ in range(steps):
        # Terms x_k h^k of q, and f_k h^k of what drives it.
        x0, x1 = q, rate * h
        f0, f1 = s, c * wave
        q, slope = x0 + x1, x1
        for k in range(_POWERS):
            x2 = (f0 * h * h - damping * h * (k + 1) * x1 - stiffness * h * h * x0) / ((k + 1) * (k + 2))
            q += x2
            slope += (k + 2) * x2
            x0, x1 = x1, x2
            f2 = -wave * wave * f0 / ((k + 1) * (k + 2))
            f0, f1 = f1, f2
        rate = slope / h if h > 0.0 else rate
        s, c = _turned(s, c, wave)
    return q, rate


@inlined
def _turned(s: float, c: float, angle: float) -> Any:
    """(s cos + c sin, c cos - s sin) of an angle of at most one radian, by its series."""
    sine = term = angle
    cosine = other = 1.0
    for k in range(1, 11):
        other *= -angle * angle / ((2 * k - 1) * (2 * k))
        term *= -angle * angle / ((2 * k) * (2 * k + 1))
        cosine += other
        sine += term
    return s * cosine + c * sine, c * cosine - s * sine


@inlined
def one_interval(
    stiffness: Lanes, damping: Lanes, pace: Vector, interval: Vector, found: Lanes, modes: int
) -> None:
    """E, a and b of the first modes of every scenario, with the stiffness and damping of the mode.

    stiffness, damping (modes, scenarios); pace p and interval h (scenarios); found (8 modes, scenarios):
    rows E11, E12, E21, E22, a1, a2, b1, b2 of each mode.
    """
    for i in range(modes):
        for m in range(stiffness.shape[1]):
            w, d, p, h = stiffness[i, m], damping[i, m], (i + 1) * pace[m], interval[m]
            for column, start in enumerate(((1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0))):
                q, rate = _oscillate(start[0], start[1], 0.0, 0.0, w, d, p, h)
                found[8 * i + column, m], found[8 * i + 2 + column, m] = q, rate
            found[8 * i + 4, m], found[8 * i + 5, m] = _oscillate(0.0, 0.0, 1.0, 0.0, w, d, p, h)
            found[8 * i + 6, m], found[8 * i + 7, m] = _oscillate(0.0, 0.0, 0.0, 1.0, w, d, p, h)


@subroutine
def _change_forces(topology: Any, crossing: Any, work: Any) -> None:
    """A and B at the start of the interval, in the lanes where they change, and what events within it add."""
    n, axles = topology.n_modes, topology.axle_wheel_begin.size
    for lane in range(LANES):
        j = work.due[1, lane]
        if work.due[0, lane] > j:
            continue
        first, behind = work.standing[lane], work.standing[LANES + lane]
        while behind < axles and crossing.axle[5 * behind + 2, lane] <= j:
            behind += 1
        while first < behind and crossing.axle[5 * first + 3, lane] <= j:
            first += 1
        work.standing[lane], work.standing[LANES + lane] = first, behind
        stand(topology, crossing, work, lane, first, behind)
        for i in range(2 * n, 4 * n):
            work.force[i, lane] = 0.0
        due, k = inf, first
        while k < axles and crossing.axle[5 * k + 3, lane] < j + 1:
            _start(topology, crossing, work, lane, k, j + 1 - crossing.axle[5 * k + 3, lane], True)
            due = j + 1
            k += 1
        if k < axles:
            due = min(due, floor(crossing.axle[5 * k + 3, lane]))
        k = behind
        while k < axles and crossing.axle[5 * k + 2, lane] < j + 1:
            _start(topology, crossing, work, lane, k, j + 1 - crossing.axle[5 * k + 2, lane], False)
            due = j + 1
            k += 1
        if k < axles:
            due = min(due, floor(crossing.axle[5 * k + 2, lane]))
        work.due[0, lane] = due


@inlined
def _start(topology: Any, crossing: Any, work: Any, lane: int, k: int, share: float, leaves: bool) -> None:
    """Adds what a force does that enters or leaves when a share of the interval is left."""
    n = topology.n_modes
    h = crossing.scale[0, lane]
    force = -crossing.wheel[4 * k + 2, lane] * crossing.wheel[4 * k + 3, lane]
    sign = -1.0
    for i in range(n):
        stiffness, damping = crossing.mode[2 * i, lane], crossing.mode[2 * i + 1, lane]
        pace = (i + 1) * pi * crossing.scale[4, lane]
        q, rate = _oscillate(0.0, 0.0, 0.0, 1.0, stiffness, damping, pace, share * h)
        size = -sign * force if leaves else force
        work.force[2 * n + i, lane] += size * q
        work.force[3 * n + i, lane] += size * rate
        sign = -sign


@inlined
def advance_exactly(
    topology: Topology, crossing: Crossing, work: Work, history: History, samples: int
) -> None:
    """Takes `samples` samples of every lane, as `tbi_cli.integrator.kernel.advance` does, in closed form."""
    flush_subnormals(True)
    n = topology.n_modes
    j = load(work.step, 0)
    for sample in range(samples):
        if topology.stations > 0:
            axles_on(topology, crossing, work, j)
        if changes_due(work, j):
            _change_forces(topology, crossing, work)
        waves(topology, crossing, work, j, 0)
        for i in range(n):
            sine, cosine = load(work.sine, i), load(work.cosine, i)
            A, B = load(work.force, i), load(work.force, n + i)
            S, C = fma(A, sine, B * cosine), fma(A, cosine, -(B * sine))
            q, rate = load(work.state, i), load(work.state, n + i)
            store(work.signal, i, q)
            store(work.signal, n + i, rate)
            pull = fma(load(crossing.mode, 2 * i), q, load(crossing.mode, 2 * i + 1) * rate)
            store(work.signal, 2 * n + i, S - pull)
            for row in range(2):
                base = 8 * i
                total = fma(load(crossing.exact, base + 2 * row), q, load(work.force, (2 + row) * n + i))
                total = fma(load(crossing.exact, base + 2 * row + 1), rate, total)
                total = fma(load(crossing.exact, base + 4 + row), S, total)
                store(work.state, row * n + i, fma(load(crossing.exact, base + 6 + row), C, total))
        take_sample(topology, crossing, work, j)
        record(topology, work, history, sample)
        j = j + splat(1.0)
    store(work.step, 0, j)
    flush_subnormals(False)
