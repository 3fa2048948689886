"""Where the axles are on the beams, and the mode shapes under them.

Functions of the kernel: compiled into it, over lane vectors.
"""

from __future__ import annotations

from math import factorial, pi
from typing import Any

from tbi_cli.integrator.lanes import (
    any_lane,
    at_least,
    both,
    either,
    fma,
    greater,
    less,
    load,
    nearest_integer,
    select,
    splat,
    store,
)
from tbi_cli.integrator.primitives import inlined, item

# sin(pi r)/r and cos(pi r) in powers of r^2: Taylor's series, whose next term is below 1e-17 for |r| <= 1/2.
_SIN_PI = tuple((-1) ** i * pi ** (2 * i + 1) / factorial(2 * i + 1) for i in range(11))
_COS_PI = tuple((-1) ** i * pi ** (2 * i) / factorial(2 * i) for i in range(12))


@inlined
def sin_cos_pi(u: Any) -> Any:
    """sin(pi u) and cos(pi u) of a lane vector."""
    m = nearest_integer(u)
    r = u - m
    half = splat(0.5) * m
    odd = half - nearest_integer(half)  # 0 where m is even, +-1/2 where it is odd
    sign = fma(splat(-8.0) * odd, odd, splat(1.0))
    r2 = r * r
    sine = splat(_SIN_PI[10])
    cosine = fma(splat(_COS_PI[11]), r2, splat(_COS_PI[10]))
    for i in range(10):
        sine = fma(sine, r2, splat(_SIN_PI[9 - i]))
        cosine = fma(cosine, r2, splat(_COS_PI[9 - i]))
    return sign * sine * r, sign * cosine


@inlined
def axles_on(topology: Any, crossing: Any, work: Any, j: Any) -> Any:
    """Marks the axles that any lane has on its bridge at the start of step j or during it.

    They are among those of `work.window`, from its first to before its second.  Returns whether there is one,
    and whether one is on the bridge at the start but not during the step.

    Where an axle enters or leaves within the step, its force is a ramp s x from or to zero for a share theta
    of the step.  Runge-Kutta weighs start, middle and end by 1/6, 4/6, 1/6, and gets the ramp's impulse
    s theta^2/2 right if it is evaluated in the middle at the place x = theta (3 theta - 1)/4 from the end of
    the bridge, and not at all off it.  What does not start from zero, the convective part, gets its impulse
    s theta right with the factor (3/2) theta - 1/4 in the middle.
    """
    found = only_at_start = False
    end, one, zero = j + splat(1.0), splat(1.0), splat(0.0)
    first, behind = item(work.window, 0), item(work.window, 1)
    axles = topology.axle_wheel_begin.size
    while behind < axles and any_lane(less(load(crossing.axle, 5 * behind + 2), end)):
        behind += 1
    while first < behind and not any_lane(at_least(load(crossing.axle, 5 * first + 3), j)):
        work.active[first] = 0
        first += 1
    work.window[0], work.window[1] = first, behind
    for k in range(first, behind):
        entry, exit_ = load(crossing.axle, 5 * k + 2), load(crossing.axle, 5 * k + 3)
        at_start = both(at_least(j, entry), at_least(exit_, j))
        in_step = both(less(entry, end), greater(exit_, j))
        work.active[k] = any_lane(either(at_start, in_step))
        if not work.active[k]:
            continue
        found = True
        start, step = select(at_start, one, zero), select(in_step, one, zero)
        only_at_start = only_at_start or any_lane(greater(start, step))
        store(work.on, 7 * k, start)
        store(work.on, 7 * k + 1, step)
        enters, leaves = both(in_step, greater(entry, j)), both(in_step, less(exit_, end))
        if any_lane(either(enters, leaves)):
            work.active[k] = 2
            share = select(enters, end - entry, exit_ - j)
            ramp = splat(0.25) * share * fma(splat(3.0), share, -one)
            place = ramp * load(crossing.scale, 4) * load(crossing.scale, 0)
            event = either(enters, leaves)
            store(work.on, 7 * k + 2, select(enters, zero, one))  # factors of the shapes at the start,
            store(work.on, 7 * k + 3, select(leaves, zero, one))  # at the end
            middle = fma(splat(1.5), share, splat(-0.25))
            store(work.on, 7 * k + 4, select(event, middle, one))  # and of the slopes in the middle
            store(work.on, 7 * k + 5, select(event, one, zero))
            store(work.on, 7 * k + 6, select(enters, place, one - place))
    return found, only_at_start


@inlined
def mode_shapes(topology: Any, crossing: Any, work: Any, j: Any, instant: int) -> None:
    """sin(i pi xi/L) and cos(i pi xi/L) under every active axle, j steps after the start.

    xi = v t - offset, but for what `axles_on` says of axles that enter or leave within the step.
    """
    axles = topology.axle_wheel_begin.size
    t = j * load(crossing.scale, 0)
    sin0, cos0 = sin_cos_pi(fma(load(crossing.scale, 4), t, load(crossing.scale, 5)))
    for k in range(item(work.window, 0), item(work.window, 1)):
        if item(work.active, k) == 0:
            continue
        cos_b, sin_b = load(crossing.axle, 5 * k), load(crossing.axle, 5 * k + 1)
        sine = fma(sin0, cos_b, -(cos0 * sin_b))
        cosine = fma(cos0, cos_b, sin0 * sin_b)
        sine_factor = cosine_factor = splat(1.0)
        if item(work.active, k) == 2:
            if instant == 1:
                event = greater(load(work.on, 7 * k + 5), splat(0.5))
                sine_there, cosine_there = sin_cos_pi(load(work.on, 7 * k + 6))
                sine, cosine = select(event, sine_there, sine), select(event, cosine_there, cosine)
                cosine_factor = load(work.on, 7 * k + 4)
            else:
                sine_factor = cosine_factor = load(work.on, 7 * k + 2 + instant // 2)
        multiples(topology, work, (instant * axles + k) * topology.n_modes, sine, cosine)
        if item(work.active, k) == 2:
            for i in range(
                (instant * axles + k) * topology.n_modes, (instant * axles + k + 1) * topology.n_modes
            ):
                store(work.sine, i, sine_factor * load(work.sine, i))
                store(work.cosine, i, cosine_factor * load(work.cosine, i))


@inlined
def multiples(topology: Any, work: Any, row: int, sine: Any, cosine: Any) -> None:
    """sin and cos of the multiples of an angle, from its own, by Chebyshev's recurrence."""
    double = cosine + cosine
    s_before, c_before = splat(0.0), splat(1.0)
    for i in range(topology.n_modes):
        store(work.sine, row + i, sine)
        store(work.cosine, row + i, cosine)
        s_next = fma(double, sine, -s_before)
        c_next = fma(double, cosine, -c_before)
        s_before, c_before = sine, cosine
        sine, cosine = s_next, c_next
