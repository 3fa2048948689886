"""The rails under the wheels: their level, and what becomes of a step in which a wheel passes a corner.

Functions of the kernel: compiled into it, over lane vectors.

Rails are intervals one after the other, of any lengths.  `work.rails` holds of each: the level of the right
rail in powers of the share of the interval that is behind, the same of the left rail, and where it is: its
begin (m), one over its length (1/m), its end (m), and 1 where a rail has a corner at that end.  Wheels go
forward, so that every axle keeps the interval that it is on, in `work.interval`: its number, begin, one over
its length, and the places from which on an axle is on the next one, at the start of a step and within it.

A corner is a kink in the level r and a jump J in its rate v r', which Runge-Kutta, weighing start, middle and
end by 1/6, 4/6, 1/6, gets wrong unless it lies between two steps.  So a corner that lies on a step within
rounding is passed just there: the step before ends on the near side of it, the next one starts on the far
side.  Where it lies inside a step, of which the share s is behind it, J adds the right impulses J h s and
J h^2 s^2/2 if its part in the middle is changed to J (6 s - 1)/4 and J h s (3 s - 1)/4.
"""

from __future__ import annotations

from typing import Any

from tbi_cli.integrator.lanes import (
    any_lane,
    at_least,
    both,
    fma,
    gather_four,
    greater,
    load,
    select,
    splat,
    store,
)
from tbi_cli.integrator.primitives import inlined, item, subroutine

# Of a step: a corner nearer to an end of a step than this lies on it.
_ROUNDING = 1e-7


@inlined
def rails(topology: Any, crossing: Any, work: Any, j: Any, instant: int, all_axles: bool) -> None:
    """Level r of the rail under every wheel, with v r' and v^2 r'', j steps after the start.

    At the start of a step (instant 0) on the far side of a corner, in its middle and at its end (1, 2) on the
    near one.  Without `all_axles` only of axles that are on another interval now.
    """
    wheels = topology.wheel_mode.size
    t, velocity = j * load(crossing.scale, 0), load(crossing.scale, 6)
    first = load(crossing.scale, 7)
    for axle in range(topology.axle_wheel_begin.size):
        place = fma(velocity, t, load(crossing.axle, 5 * axle + 4))
        beyond = any_lane(at_least(place, load(work.interval, 5 * axle + (3 if instant == 0 else 4))))
        if beyond:
            _go_on(topology, crossing, work, axle, instant, t)
        elif not all_axles:
            continue
        density = load(work.interval, 5 * axle + 2)
        f = (place - load(work.interval, 5 * axle + 1)) * density
        pace = velocity * density
        record = splat(3.0) * (first + load(work.interval, 5 * axle))
        for wheel in range(item(topology.axle_wheel_begin, axle), item(topology.axle_wheel_end, axle)):
            rail = splat(float(item(topology.wheel_rail, wheel)))
            c0, c1, c2, c3 = gather_four(work.rails, record + rail)
            twice = c2 + c2
            thrice = splat(3.0) * c3
            row = 3 * (instant * wheels + wheel)
            store(work.rail, row, fma(f, fma(f, fma(f, c3, c2), c1), c0))
            store(work.rail, row + 1, pace * fma(f, fma(f, thrice, twice), c1))
            store(work.rail, row + 2, pace * pace * fma(f, thrice + thrice, twice))
            if beyond and instant > 0:
                middle = 3 * (wheels + wheel)
                store(work.rail, middle, load(work.rail, middle) + load(work.corner, 2 * wheel))
                store(work.rail, middle + 1, load(work.rail, middle + 1) + load(work.corner, 2 * wheel + 1))


@inlined
def carry_rails(topology: Any, work: Any) -> None:
    """The rails at the end of a step are those at the start of the next."""
    rows = 3 * topology.wheel_mode.size
    for row in range(rows):
        store(work.rail, row, load(work.rail, 2 * rows + row))


@subroutine
def _go_on(topology: Any, crossing: Any, work: Any, axle: int, instant: int, t: Any) -> None:
    """Takes an axle to the interval that it is on in every lane, noting the corners that it passes."""
    zero, one = splat(0.0), splat(1.0)
    velocity, first, steps = load(crossing.scale, 6), load(crossing.scale, 7), load(crossing.scale, 8)
    place = fma(velocity, t, load(crossing.axle, 5 * axle + 4))
    rounding = splat(_ROUNDING) * velocity * load(crossing.scale, 0)
    begin, end = item(topology.axle_wheel_begin, axle), item(topology.axle_wheel_end, axle)
    for row in range(2 * begin, 2 * end):
        store(work.corner, row, zero)
    limit = 3 if instant == 0 else 4
    beyond = at_least(place, load(work.interval, 5 * axle + limit))
    while any_lane(beyond):
        here = first + load(work.interval, 5 * axle)
        there = here + select(beyond, one, zero)
        _, old, corner_at, corner = gather_four(work.rails, fma(splat(3.0), here, splat(2.0)))
        start, density, stop, next_corner = gather_four(work.rails, fma(splat(3.0), there, splat(2.0)))
        passed = both(beyond, greater(corner, zero))
        if instant > 0 and any_lane(passed):
            # The share of the step behind the corner, and whether its middle is.
            middle = one if instant == 1 else zero
            share = fma(place - corner_at, steps, splat(0.5) * middle)
            level = splat(0.25) * share * fma(splat(3.0), share, -one) - middle * (share - splat(0.5))
            rate = fma(splat(1.5), share, splat(-0.25)) - middle
            for wheel in range(begin, end):
                rail = splat(float(item(topology.wheel_rail, wheel)))
                _, b1, b2, b3 = gather_four(work.rails, fma(splat(3.0), here, rail))
                _, a1, _, _ = gather_four(work.rails, fma(splat(3.0), there, rail))
                before = fma(splat(3.0), b3, fma(splat(2.0), b2, b1)) * old
                jump = select(passed, velocity * (a1 * density - before), zero)
                row = 2 * wheel
                kink = jump * load(crossing.scale, 0) * level
                store(work.corner, row, load(work.corner, row) + kink)
                store(work.corner, row + 1, fma(jump, rate, load(work.corner, row + 1)))
        store(work.interval, 5 * axle, there - first)
        store(work.interval, 5 * axle + 1, start)
        store(work.interval, 5 * axle + 2, density)
        store(work.interval, 5 * axle + 3, stop - next_corner * rounding)
        store(work.interval, 5 * axle + 4, fma(next_corner, rounding, stop))
        beyond = at_least(place, load(work.interval, 5 * axle + limit))
