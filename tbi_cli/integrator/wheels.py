"""What wheels and beams do to each other, and what is known of each wheel at a sample.

Functions of the kernel: compiled into it, over lane vectors.
"""

from __future__ import annotations

from typing import Any

from tbi_cli.integrator.lanes import fma, less, load, select, splat, store
from tbi_cli.integrator.primitives import inlined, item


@inlined
def _free_tension(topology: Any, crossing: Any, work: Any, wheel: int) -> Any:
    """P of a wheel on rigid track: k g x + c g x'."""
    nd = topology.term_begin.size
    stretch, rate = splat(0.0), splat(0.0)
    for t in range(item(topology.wheel_begin, wheel), item(topology.wheel_end, wheel)):
        g = load(crossing.wheel_g, t)
        stretch = fma(g, load(work.signal, item(topology.wheel_col, t)), stretch)
        rate = fma(g, load(work.signal, nd + item(topology.wheel_col, t)), rate)
    return fma(load(crossing.wheel, 4 * wheel), stretch, load(crossing.wheel, 4 * wheel + 1) * rate)


@inlined
def contact(
    topology: Any, crossing: Any, work: Any, axle: int, instant: int, during: int, last: bool, out: int
) -> None:
    """Adds what the wheels of one axle, the rails and the beams under them do to each other.

    The axle is where it is at the `instant` of the step, and on or off as at its start (during = 0) or in
    it (1).  A unilateral contact never pulls, P <= f_g, and is not part of A; a wheel that does not touch in
    the last stage of a step has been aloft for this step.
    """
    n, nd, wheels = topology.n_modes, topology.term_begin.size, topology.wheel_mode.size
    active = item(work.active, axle) != 0
    on = load(work.on, 7 * axle + during)
    shape = (instant * topology.axle_wheel_begin.size + axle) * n
    for wheel in range(item(topology.axle_wheel_begin, axle), item(topology.axle_wheel_end, axle)):
        mode = item(topology.wheel_mode, wheel)
        w, rate = splat(0.0), splat(0.0)
        if active:
            for i in range(n):
                s = load(work.sine, shape + i)
                w = fma(s, load(work.signal, mode + i), w)
                rate = fma(s, load(work.signal, nd + mode + i), rate)
            if topology.convective:
                for i in range(n):
                    slope = load(crossing.wave, i) * load(work.cosine, shape + i)
                    rate = fma(slope, load(work.signal, mode + i), rate)
            w, rate = on * w, on * rate
        if topology.irregular:
            w = w + load(work.rail, 3 * (instant * wheels + wheel))
            rate = rate + load(work.rail, 3 * (instant * wheels + wheel) + 1)
        pull = fma(load(crossing.wheel, 4 * wheel), w, load(crossing.wheel, 4 * wheel + 1) * rate)
        tension = _free_tension(topology, crossing, work, wheel) - pull
        load_of_wheel = load(crossing.wheel, 4 * wheel + 2)
        if topology.unilateral:
            touching = less(tension, load_of_wheel)
            tension = select(touching, tension, load_of_wheel)
            pull = -tension
            if last:
                row = 3 * nd + 4 * wheels + wheel
                aloft = select(touching, splat(0.0), load(crossing.scale, 0))
                store(work.signal, row, load(work.signal, row) + aloft)
        for t in range(item(topology.wheel_begin, wheel), item(topology.wheel_end, wheel)):
            row = out + item(topology.wheel_col, t)
            store(work.signal, row, fma(load(crossing.wheel_gm, t), pull, load(work.signal, row)))
        if active:
            force = on * load(crossing.wheel, 4 * wheel + 3) * (tension - load_of_wheel)
            for i in range(n):
                row = out + mode + i
                store(work.signal, row, fma(load(work.sine, shape + i), force, load(work.signal, row)))


@inlined
def wheel_signals(topology: Any, crossing: Any, work: Any, axle: int) -> None:
    """P; the level of the rail under the wheel with its total derivatives w, w', w''."""
    n, nd, wheels = topology.n_modes, topology.term_begin.size, topology.wheel_mode.size
    base = 3 * nd
    for wheel in range(item(topology.axle_wheel_begin, axle), item(topology.axle_wheel_end, axle)):
        w, dw, ddw, felt = splat(0.0), splat(0.0), splat(0.0), splat(0.0)
        if item(work.active, axle) != 0:
            mode = item(topology.wheel_mode, wheel)
            shape = axle * n
            local = splat(0.0)
            for i in range(n):
                s, c = load(work.sine, shape + i), load(work.cosine, shape + i)
                wave = load(crossing.wave, i)
                q, dq = load(work.signal, mode + i), load(work.signal, nd + mode + i)
                ddq = load(work.signal, 2 * nd + mode + i)
                slope = wave * c
                w = fma(s, q, w)
                local = fma(s, dq, local)
                dw = fma(slope, q, dw)
                ddw = fma(s, ddq, ddw)
                ddw = fma(slope + slope, dq, ddw)
                ddw = fma(-(wave * wave) * s, q, ddw)
            on = load(work.on, 7 * axle)
            felt = on * (local + dw) if topology.convective else on * local
            w, dw, ddw = on * w, on * (local + dw), on * ddw
        if topology.irregular:
            w = w + load(work.rail, 3 * wheel)
            dw = dw + load(work.rail, 3 * wheel + 1)
            felt = felt + load(work.rail, 3 * wheel + 1)
            ddw = ddw + load(work.rail, 3 * wheel + 2)
        pull = fma(load(crossing.wheel, 4 * wheel), w, load(crossing.wheel, 4 * wheel + 1) * felt)
        tension = _free_tension(topology, crossing, work, wheel) - pull
        if topology.unilateral:
            load_of_wheel = load(crossing.wheel, 4 * wheel + 2)
            tension = select(less(tension, load_of_wheel), tension, load_of_wheel)
        store(work.signal, base + wheel, tension)
        store(work.signal, base + wheels + wheel, w)
        store(work.signal, base + 2 * wheels + wheel, dw)
        store(work.signal, base + 3 * wheels + wheel, ddw)
