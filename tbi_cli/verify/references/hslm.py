"""The trains HSLM-A of EN 1991-2, 6.4.6.1.1, put together from their vehicles."""

from __future__ import annotations

# Table 6.3: intermediate coaches N, coach length D [m], axle spacing of a bogie d [m], axle force P [kN].
TABLE = """
A1 18 18 2.0 170
A2 17 19 3.5 200
A3 16 20 2.0 180
A4 15 21 3.0 190
A5 14 22 2.0 170
A6 13 23 2.0 180
A7 13 24 2.0 190
A8 12 25 2.5 190
A9 11 26 2.0 210
A10 11 27 2.0 210
"""
POWER_CAR_BOGIES = (0.0, 3.0, 14.0, 17.0)


def hslm_a(number: int) -> tuple[list[float], float]:
    """Distance [m] of each axle behind the first, in rising order, and the force [N] of every one.

    A power car of four axles; an end coach with a bogie of its own 3.525 m behind the power car's last axle,
    d between its axles; then bogies shared by neighbours, one coach length D apart, the first D behind
    18.7625 m; the other end is the mirror image.
    """
    _, coaches, length, spacing, force = TABLE.split("\n")[number].split()
    N, D, d = int(coaches), float(length), float(spacing)
    total = 37.525 + (N + 2) * D
    front = [*POWER_CAR_BOGIES, 20.525, 20.525 + d]
    shared = [18.7625 + (i + 1) * D + side for i in range(N + 1) for side in (-d / 2, d / 2)]
    rear = [total - x for x in front]
    return sorted([*front, *shared, *rear]), 1e3 * float(force)
