"""What is made of a sample: signals of wheels and stations, weighted sums, low-passed ones, reductions."""

from __future__ import annotations

from typing import Any

from tbi_cli.integrator.lanes import any_lane, either, fma, greater, less, load, select, splat, store
from tbi_cli.integrator.primitives import inlined, item
from tbi_cli.integrator.wheels import wheel_signals


@inlined
def take_sample(topology: Any, crossing: Any, work: Any, j: Any) -> None:
    """Forms every channel at the start of step j and takes its reductions.

    The signals x, x' and x'' are those of this instant.
    """
    if topology.wheel_signals:
        for axle in range(topology.axle_wheel_begin.size):
            wheel_signals(topology, crossing, work, axle)
    if topology.stations > 0:
        _static_signals(topology, crossing, work, j)
    for row in range(topology.sum_begin.size):
        total = load(crossing.sum_offset, row)
        for t in range(item(topology.sum_begin, row), item(topology.sum_end, row)):
            total = fma(load(crossing.sum_coef, t), load(work.signal, item(topology.sum_col, t)), total)
        store(work.signal, topology.sum_row + row, total)
    for f in range(topology.filter_col.size):
        _low_pass(topology, crossing, work, f)
    for c in range(topology.channel.size):
        y = load(work.signal, item(topology.channel, c))
        store(work.reduced, 5 * c, fma(y, y, load(work.reduced, 5 * c)))
        high, low = load(work.reduced, 5 * c + 1), load(work.reduced, 5 * c + 2)
        above, below = greater(y, high), less(y, low)
        if any_lane(either(above, below)):
            store(work.reduced, 5 * c + 1, select(above, y, high))
            store(work.reduced, 5 * c + 2, select(below, y, low))
            store(work.reduced, 5 * c + 3, select(above, j, load(work.reduced, 5 * c + 3)))
            store(work.reduced, 5 * c + 4, select(below, j, load(work.reduced, 5 * c + 4)))


@inlined
def _static_signals(topology: Any, crossing: Any, work: Any, j: Any) -> None:
    """Bending moment over L and shear force that the wheels' forces would cause at rest, at every station.

    They are sums over the wheels of the force times the influence line of a simply supported beam.  With a
    wheel right above a station, the shear force is that just behind it (at the end of the beam, before it).
    """
    stations, one = topology.stations, splat(1.0)
    base = topology.static_row
    for row in range(base, base + 2 * stations * topology.beams):
        store(work.signal, row, splat(0.0))
    pace = load(crossing.scale, 4) * load(crossing.scale, 0)
    for axle in range(item(work.window, 0), item(work.window, 1)):
        if item(work.active, axle) == 0:
            continue
        xi = (j - load(crossing.axle, 5 * axle + 2)) * pace
        on = load(work.on, 7 * axle)
        for wheel in range(item(topology.axle_wheel_begin, axle), item(topology.axle_wheel_end, axle)):
            tension = load(work.signal, 3 * topology.term_begin.size + wheel)
            force = on * (load(crossing.wheel, 4 * wheel + 2) - tension)
            row = base + 2 * stations * item(topology.wheel_rail, wheel)
            for s in range(stations):
                x = load(crossing.station, 2 * s)
                behind = less(xi, load(crossing.station, 2 * s + 1))
                moment = select(behind, xi * (one - x), x * (one - xi))
                shear = select(behind, -xi, one - xi)
                store(work.signal, row + 2 * s, fma(force, moment, load(work.signal, row + 2 * s)))
                store(work.signal, row + 2 * s + 1, fma(force, shear, load(work.signal, row + 2 * s + 1)))


@inlined
def _low_pass(topology: Any, crossing: Any, work: Any, f: int) -> None:
    """One sample of a Butterworth filter of fourth order: two biquads, transposed direct form II."""
    y = load(work.signal, item(topology.filter_col, f))
    for part in range(2):
        c, z = 5 * (2 * item(topology.filter_beam, f) + part), 2 * (2 * f + part)
        b1, b2 = load(crossing.low_pass, c + 1), load(crossing.low_pass, c + 2)
        a1, a2 = load(crossing.low_pass, c + 3), load(crossing.low_pass, c + 4)
        x = y
        y = fma(load(crossing.low_pass, c), x, load(work.filter, z))
        store(work.filter, z, fma(b1, x, fma(-a1, y, load(work.filter, z + 1))))
        store(work.filter, z + 1, fma(b2, x, -a2 * y))
    store(work.signal, topology.filter_row + f, y)
