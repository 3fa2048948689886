"""Trains of constant forces on one beam: what they do to a mode is A sin(i pi v t/L) + B cos(i pi v t/L).

A force F at xi = v t - offset pushes mode i with F sin(i pi xi/L), so all forces that stand on the bridge
push together with two numbers, which change only where one enters or leaves.  The cost of a step does not
depend on their number.
"""

from __future__ import annotations

from math import floor, inf, pi, sin
from typing import Any

from tbi_cli.integrator.arrays import LANES, Crossing, History, Topology, Work
from tbi_cli.integrator.kernel import record
from tbi_cli.integrator.lanes import any_lane, at_least, fma, load, splat, store
from tbi_cli.integrator.primitives import flush_subnormals, inlined, subroutine
from tbi_cli.integrator.sampling import take_sample
from tbi_cli.integrator.shapes import axles_on, multiples, sin_cos_pi

# Rows of work.force, each block one per mode: A | B | what axles add that enter or leave within the step, at
# its start, in its middle and at its end.
_EXTRA = 2


@inlined
def waves(topology: Any, crossing: Any, work: Any, j: Any, slot: int) -> None:
    """sin(i pi v t/L) and cos(i pi v t/L), j steps after the start, into a slot."""
    t = j * load(crossing.scale, 0)
    sine, cosine = sin_cos_pi(fma(load(crossing.scale, 4), t, load(crossing.scale, 5)))
    multiples(topology, work, slot * topology.n_modes, sine, cosine)


@inlined
def _push(topology: Any, work: Any, i: int, instant: int, slot: int) -> Any:
    """What the forces add to the acceleration of mode i at an instant of the step."""
    n = topology.n_modes
    s, c = load(work.sine, slot * n + i), load(work.cosine, slot * n + i)
    more = load(work.force, (_EXTRA + instant) * n + i)
    return fma(load(work.force, i), s, fma(load(work.force, n + i), c, more))


@inlined
def changes_due(work: Any, j: Any) -> Any:
    """Whether the forces on the bridge change in any lane at step j; keeps the number of the step."""
    store(work.due, 1, j)
    return any_lane(at_least(j, load(work.due, 0)))


@inlined
def stand(topology: Any, crossing: Any, work: Any, lane: int, first: int, behind: int) -> None:
    """Sets A and B of a lane to those of the forces from `first` to before `behind`."""
    n = topology.n_modes
    for i in range(2 * n):
        work.force[i, lane] = 0.0
    for k in range(first, behind):
        c1, s1 = crossing.axle[5 * k, lane], crossing.axle[5 * k + 1, lane]
        force = -crossing.wheel[4 * k + 2, lane] * crossing.wheel[4 * k + 3, lane]
        s_before, c_before, s, c = 0.0, 1.0, s1, c1
        for i in range(n):
            work.force[i, lane] += force * c
            work.force[n + i, lane] -= force * s
            s_before, s = s, 2.0 * c1 * s - s_before
            c_before, c = c, 2.0 * c1 * c - c_before


@subroutine
def _change_forces(topology: Any, crossing: Any, work: Any) -> None:
    """What stands on the bridge during the step, in the lanes where that changes with it.

    A force that enters or leaves within the step has its right impulse, as `axles_on` says.
    """
    n, axles = topology.n_modes, topology.axle_wheel_begin.size
    for lane in range(LANES):
        j = work.due[1, lane]
        if work.due[0, lane] > j:
            continue
        first, behind = work.standing[lane], work.standing[LANES + lane]
        while behind < axles and crossing.axle[5 * behind + 2, lane] <= j:
            behind += 1
        while first < behind and crossing.axle[5 * first + 3, lane] < j + 1:
            first += 1
        work.standing[lane], work.standing[LANES + lane] = first, behind
        stand(topology, crossing, work, lane, first, behind)
        for i in range(_EXTRA * n, (_EXTRA + 3) * n):
            work.force[i, lane] = 0.0
        due = inf
        entering = behind
        while entering < axles and crossing.axle[5 * entering + 2, lane] < j + 1:
            _enter_or_leave(topology, crossing, work, lane, entering, j)
            entering += 1
            due = j + 1
        leaving = first - 1
        while leaving >= 0 and crossing.axle[5 * leaving + 3, lane] > j:
            _enter_or_leave(topology, crossing, work, lane, leaving, j)
            leaving -= 1
            due = j + 1
        if entering < axles:
            due = min(due, floor(crossing.axle[5 * entering + 2, lane]))
        if first < behind:
            due = min(due, floor(crossing.axle[5 * first + 3, lane]))
        work.due[0, lane] = due


@inlined
def _enter_or_leave(topology: Any, crossing: Any, work: Any, lane: int, k: int, j: float) -> None:
    n = topology.n_modes
    entry, exit_ = crossing.axle[5 * k + 2, lane], crossing.axle[5 * k + 3, lane]
    pace = crossing.scale[4, lane] * crossing.scale[0, lane]
    enters, leaves = entry > j, exit_ < j + 1
    share = j + 1 - entry if enters else exit_ - j
    place = 0.25 * share * (3.0 * share - 1.0) * pace
    middle = place if enters else 1.0 - place
    force = -crossing.wheel[4 * k + 2, lane] * crossing.wheel[4 * k + 3, lane]
    for i in range(n):
        wave = (i + 1) * pi
        if not enters:
            work.force[_EXTRA * n + i, lane] += force * sin(wave * (j - entry) * pace)
        work.force[(_EXTRA + 1) * n + i, lane] += force * sin(wave * middle)
        if not leaves:
            work.force[(_EXTRA + 2) * n + i, lane] += force * sin(wave * (j + 1 - entry) * pace)


@inlined
def _step(topology: Any, crossing: Any, work: Any, i: int, start: int, keep: bool) -> None:
    """A Runge-Kutta step of mode i, which no other feels; keeps its motion at the start if wanted."""
    n = topology.n_modes
    h, half = load(crossing.scale, 0), load(crossing.scale, 1)
    sixth, square_sixth = load(crossing.scale, 2), load(crossing.scale, 3)
    stiffness, damping = load(crossing.mode, 2 * i), load(crossing.mode, 2 * i + 1)
    x, v = load(work.state, i), load(work.state, n + i)
    first, middle = _push(topology, work, i, 0, start), _push(topology, work, i, 1, 1)
    last = _push(topology, work, i, 2, 2 - start)
    a1 = fma(-damping, v, fma(-stiffness, x, first))
    if keep:
        store(work.signal, i, x)
        store(work.signal, n + i, v)
        store(work.signal, 2 * n + i, a1)
    x2, v2 = fma(half, v, x), fma(half, a1, v)
    a2 = fma(-damping, v2, fma(-stiffness, x2, middle))
    x3, v3 = fma(half, v2, x), fma(half, a2, v)
    a3 = fma(-damping, v3, fma(-stiffness, x3, middle))
    x4, v4 = fma(h, v3, x), fma(h, a3, v)
    a4 = fma(-damping, v4, fma(-stiffness, x4, last))
    inner = a2 + a3
    store(work.state, i, fma(square_sixth, a1 + inner, fma(h, v, x)))
    store(work.state, n + i, fma(sixth, (a1 + a4) + (inner + inner), v))


@inlined
def advance_forces(
    topology: Topology, crossing: Crossing, work: Work, substeps: int, history: History, samples: int
) -> None:
    """What `tbi_cli.integrator.kernel.advance` does, for trains of constant forces on one beam."""
    flush_subnormals(True)
    j = load(work.step, 0)
    waves(topology, crossing, work, j, 0)
    # The waves at the start of a step lie in slot 0 or 2, those at its end, which are those at the start of
    # the next, in the other one.
    start = 0
    for sample in range(samples):
        for substep in range(substeps):
            if topology.stations > 0 and substep == 0:
                axles_on(topology, crossing, work, j)
            if changes_due(work, j):
                _change_forces(topology, crossing, work)
            waves(topology, crossing, work, j + splat(0.5), 1)
            waves(topology, crossing, work, j + splat(1.0), 2 - start)
            for i in range(topology.n_modes):
                _step(topology, crossing, work, i, start, substep == 0)
            if substep == 0:
                take_sample(topology, crossing, work, j)
                record(topology, work, history, sample)
            start = 2 - start
            j = j + splat(1.0)
    store(work.step, 0, j)
    flush_subnormals(False)
