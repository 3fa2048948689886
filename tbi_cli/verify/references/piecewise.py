"""DOP853 restarted at every event, so that no step of the reference crosses a kink."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from itertools import pairwise

import numpy as np

from tbi_cli.verify.references.parameters import Array


def integrate_between_events(
    rate_between: Callable[[float, float], Callable[[float, Array], Array]],
    size: int,
    events: Iterable[float],
    times: Array,
    rtol: float = 1e-10,
    atol: float = 1e-14,
) -> Array:
    """State (size, nt) at increasing `times` >= 0, starting from zero at t = 0.

    `rate_between(start, stop)` gives the right-hand side f(t, state) that is smooth from one event to the
    next. Raises ArithmeticError where DOP853 gives up.
    """
    from scipy.integrate import solve_ivp

    end = float(times[-1])
    cuts = [0.0, *sorted({float(t) for t in events if 0 < t < end}), end]
    state = np.zeros(size)
    samples = np.zeros((size, len(times)))
    for start, stop in pairwise(cuts):
        if stop <= start:
            continue
        inside = (times > start) & (times < stop)
        solution = solve_ivp(
            rate_between(start, stop),
            (start, stop),
            state,
            method="DOP853",
            t_eval=np.append(times[inside], stop),
            rtol=rtol,
            atol=atol,
        )
        if not solution.success:
            raise ArithmeticError(f"reference integration failed: {solution.message}")
        samples[:, inside] = solution.y[:, :-1]
        state = solution.y[:, -1]
        samples[:, times == stop] = state[:, None]
    return samples
