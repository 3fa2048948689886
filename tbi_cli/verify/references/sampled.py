"""Derivatives and integrals of sampled histories, piece by piece between the axle events.

At an entry or exit the accelerations of the beams have a kink. Between two events everything is smooth, and
an interpolating spline of degree 7 is good to about (omega dt)^7.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from tbi_cli.verify.references.parameters import Array, Crossing

if TYPE_CHECKING:
    from scipy.interpolate import BSpline

DEGREE = 7


def pieces(crossing: Crossing, time: Array) -> list[slice]:
    """The runs of samples from one event to the next, both ends in; events must fall on samples."""
    crossing_time = crossing.right.length / crossing.velocity
    entries = crossing.train.axle_distances / crossing.velocity
    events = np.concatenate([entries, entries + crossing_time])
    cuts = np.searchsorted(time, events - 1e-9 * crossing_time)
    ends = np.unique(np.concatenate([[0], cuts[cuts < len(time)], [len(time) - 1]]))
    return [slice(int(a), int(b) + 1) for a, b in pairwise(ends)]


def derivative(time: Array, y: Array, between: list[slice]) -> Array:
    """dy/dt (nt,); at an event that of the piece before."""
    out = np.empty(len(time))
    for piece in reversed(between):
        out[piece] = _spline(time[piece], y[piece]).derivative()(time[piece])
    return out


def running_integral(time: Array, y: Array) -> Array:
    """Integral of y from time[0] to each time, for one piece."""
    primitive = _spline(time, y).antiderivative()
    integral: Array = primitive(time) - primitive(time[0])
    return integral


def with_modal_rates(crossing: Crossing, time: Array, h: Mapping[str, Array]) -> dict[str, Array]:
    """The histories with velocity and acceleration of every modal coordinate added, where they lack them."""
    between, out = pieces(crossing, time), dict(h)
    for side in ("right", "left"):
        for i in range(1, crossing.right.n + 1):
            name = f"{side}_mode_{i}"
            for suffix, of in (("_velocity", ""), ("_acceleration", "_velocity")):
                if f"{name}{suffix}" not in out:
                    out[f"{name}{suffix}"] = derivative(time, out[f"{name}{of}"], between)
    return out


def _spline(t: Array, y: Array) -> BSpline:
    from scipy.interpolate import make_interp_spline

    return make_interp_spline(t, y, k=max(d for d in (1, 3, 5, DEGREE) if d < max(len(t), 2)))
