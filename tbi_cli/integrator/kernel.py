"""Classical fourth-order Runge-Kutta for many linear systems crossed by moving wheels, side by side.

The integrator knows arrays, not trains.  `LANES` scenarios advance together, one per lane.  Each is

    x'' = A (x, x') + contact

where A is one sparse matrix over the stacked state (x, x'): a vehicle on rigid track, and below it the modal
amplitudes of the beams.  A wheel on a beam adds what the beam's motion w = sum_i x_i sin(i pi xi/L) changes
[Eqs. (12b), (12d), (12e)]:

    P = k (g x - w) + c (g x' - w')          force of its suspension, tension positive
    bodies:  x'' += g (k w + c w') / m
    beam:    x'' += sin(i pi xi/L) (P - f_g) 2/(mu L)

A step in which an axle enters or leaves gives its force the right impulse, see `shapes.axles_on`.  Where all
wheels are constant forces, `forces.advance_forces` does the same at less cost.
"""

from __future__ import annotations

from typing import Any

from tbi_cli.integrator.arrays import Crossing, History, Topology, Work
from tbi_cli.integrator.lanes import fma, load, load_at, splat, store
from tbi_cli.integrator.primitives import flush_subnormals, inlined, item
from tbi_cli.integrator.rails import carry_rails, rails
from tbi_cli.integrator.sampling import take_sample
from tbi_cli.integrator.shapes import axles_on, mode_shapes
from tbi_cli.integrator.wheels import contact


@inlined
def _added(topology: Any, crossing: Any, work: Any, t: int, total: Any) -> Any:
    """A sum with term t of A (x, x') added."""
    places = item(topology.term, t)
    return fma(load_at(crossing.term, places >> 32), load_at(work.signal, places & 0xFFFFFFFF), total)


@inlined
def free_accelerations(topology: Any, crossing: Any, work: Any, out: int) -> None:
    """x'' = A (x, x') for all coordinates, the wheels on rigid track.

    Rows are taken by twos, of which the second has no fewer terms: one sum does not wait for the other.
    """
    rows = topology.term_begin.size
    alone = rows % 2
    if alone:
        total = splat(0.0)
        for t in range(item(topology.term_begin, 0), item(topology.term_end, 0)):
            total = _added(topology, crossing, work, t, total)
        store(work.signal, out + item(topology.term_row, 0), total)
    for row in range(alone, rows, 2):
        t1, t2 = item(topology.term_begin, row), item(topology.term_begin, row + 1)
        both = item(topology.term_end, row) - t1
        one, two = splat(0.0), splat(0.0)
        for t in range(both):
            one = _added(topology, crossing, work, t1 + t, one)
            two = _added(topology, crossing, work, t2 + t, two)
        for t in range(t2 + both, item(topology.term_end, row + 1)):
            two = _added(topology, crossing, work, t, two)
        store(work.signal, out + item(topology.term_row, row), one)
        store(work.signal, out + item(topology.term_row, row + 1), two)


@inlined
def next_stage(work: Any, nd: int, a: int, factor: Any) -> None:
    """Moves the signal to where the next stage is evaluated: x0 + factor v, v0 + factor a."""
    for i in range(nd):
        v = load(work.signal, nd + i)
        store(work.signal, i, fma(factor, v, load(work.state, i)))
        store(work.signal, nd + i, fma(factor, load(work.signal, a + i), load(work.state, nd + i)))


@inlined
def end_step(work: Any, nd: int, later: int, h: Any, sixth: Any, square_sixth: Any) -> None:
    """x += h v + h^2/6 (a1 + a2 + a3), v += h/6 (a1 + 2 a2 + 2 a3 + a4): Eq. (27) for x'' = a(x, v)."""
    for i in range(nd):
        a1, a4 = load(work.signal, 2 * nd + i), load(work.signal, later + 2 * nd + i)
        inner = load(work.signal, later + i) + load(work.signal, later + nd + i)
        v = load(work.state, nd + i)
        x = fma(square_sixth, a1 + inner, fma(h, v, load(work.state, i)))
        v = fma(sixth, (a1 + a4) + (inner + inner), v)
        store(work.state, i, x)
        store(work.state, nd + i, v)
        store(work.signal, i, x)
        store(work.signal, nd + i, v)


@inlined
def record(topology: Any, work: Any, history: Any, sample: int) -> None:
    """Keeps the channels of a sample in the history, which may have no length."""
    if history.shape[0] > 0:
        for c in range(topology.history.size):
            y = load(work.signal, item(topology.history, c))
            store(history, sample * topology.history.size + c, y)


@inlined
def advance(
    topology: Topology, crossing: Crossing, work: Work, substeps: int, history: History, samples: int
) -> None:
    """Takes `samples` samples of every lane, each followed by `substeps` Runge-Kutta steps.

    `history`, shape (at least samples, channels kept, LANES), is filled where its length is not zero.
    """
    flush_subnormals(True)
    nd = topology.term_begin.size
    later = topology.stage_row
    h, half = load(crossing.scale, 0), load(crossing.scale, 1)
    sixth, square_sixth = load(crossing.scale, 2), load(crossing.scale, 3)
    j = load(work.step, 0)
    everywhere = topology.irregular or topology.unilateral
    for i in range(2 * nd):
        store(work.signal, i, load(work.state, i))
    if topology.irregular:
        rails(topology, crossing, work, j, 0, True)
    for sample in range(samples):
        for substep in range(substeps):
            on_bridge, leaving = axles_on(topology, crossing, work, j)
            if on_bridge:
                mode_shapes(topology, crossing, work, j, 0)
                mode_shapes(topology, crossing, work, j + splat(0.5), 1)
                mode_shapes(topology, crossing, work, j + splat(1.0), 2)
            if topology.irregular:
                rails(topology, crossing, work, j + splat(0.5), 1, True)
                rails(topology, crossing, work, j + splat(1.0), 2, True)
            # The first evaluation is the sample's, by the axles on the bridge at this instant.  It serves as
            # the first stage too, unless an axle leaves just then.
            for evaluation in range(0 if substep == 0 else 1, 5):
                if evaluation == 1 and substep == 0 and not leaving:
                    continue
                stage = max(evaluation - 1, 0)
                out = 2 * nd if stage == 0 else later + (stage - 1) * nd
                free_accelerations(topology, crossing, work, out)
                if on_bridge or everywhere:
                    for axle in range(
                        0 if everywhere else item(work.window, 0),
                        topology.axle_wheel_begin.size if everywhere else item(work.window, 1),
                    ):
                        if everywhere or item(work.active, axle) != 0:
                            contact(
                                topology,
                                crossing,
                                work,
                                axle,
                                (stage + 1) // 2,
                                min(evaluation, 1),
                                evaluation == 4,
                                out,
                            )
                if evaluation == 0:
                    take_sample(topology, crossing, work, j)
                    record(topology, work, history, sample)
                if stage < 3 and (evaluation > 0 or not leaving):
                    next_stage(work, nd, out, half if stage < 2 else h)
            end_step(work, nd, later, h, sixth, square_sixth)
            j = j + splat(1.0)
            if topology.irregular:
                carry_rails(topology, work)
                rails(topology, crossing, work, j, 0, False)
    store(work.step, 0, j)
    flush_subnormals(False)
