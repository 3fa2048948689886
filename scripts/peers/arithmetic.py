"""How many multiply-adds this processor can do: the ceiling of any kernel."""

from __future__ import annotations

import time

import numpy as np
from numba import njit

from tbi_cli.integrator.arrays import LANES, lane_zeros
from tbi_cli.integrator.lanes import fma, load, store

_CHAINS, _ROUNDS = 12, 2_000_000


@njit(nogil=True)
def _chains(x, rounds):  # type: ignore[no-untyped-def]
    a, b = load(x, 0), load(x, 1)
    c0 = c1 = c2 = c3 = c4 = c5 = c6 = c7 = c8 = c9 = c10 = c11 = load(x, 2)
    for _ in range(rounds):
        c0, c1, c2, c3 = fma(a, c0, b), fma(a, c1, b), fma(a, c2, b), fma(a, c3, b)
        c4, c5, c6, c7 = fma(a, c4, b), fma(a, c5, b), fma(a, c6, b), fma(a, c7, b)
        c8, c9, c10, c11 = fma(a, c8, b), fma(a, c9, b), fma(a, c10, b), fma(a, c11, b)
    store(x, 2, c0 + c1 + c2 + c3 + c4 + c5 + c6 + c7 + c8 + c9 + c10 + c11)


def multiply_adds_per_second() -> float:
    """Fused multiply-adds of float64 per second and core, from registers."""
    x = lane_zeros(3)
    x[0] = 0.5
    _chains(x, 1)
    best = np.inf
    for _ in range(5):
        begin = time.perf_counter()
        _chains(x, _ROUNDS)
        best = min(best, time.perf_counter() - begin)
    return _CHAINS * _ROUNDS * LANES / best


def multiply_adds_of_a_step(
    terms: int, g_terms: int, wheels: int, coordinates: int, share_on: float
) -> float:
    """Multiply-adds that one step cannot do without: matrix and wheels at four stages, the update of the
    state.

    Contact counts for the share of the time in which an axle is on the bridge; channels do not count.
    """
    contact = wheels * (2 * g_terms / wheels + g_terms / wheels + 12 + 2)
    return 4 * (terms + share_on * contact) + 10 * coordinates
