"""Rails that are not level, as functions of the place: from the keys of a case file, in SI.

Written down apart from the rails that the program integrates: no chain of cubics, and other forms of the
formulas where there are any; the cubic spline through measured points is solved here for its curvatures.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tbi_cli.verify.references.parameters import Array

Function = Callable[[Any], Any]
_SIDES = {"both": (1, 1), "right": (1, 0), "left": (0, 1), "opposite": (1, -1)}
# Before and behind a corner: nearer to it than any sample.
BESIDE = 1e-9


@dataclass(frozen=True)
class Rail:
    """A rail: level r(x), slope r'(x) and curvature r''(x) in m, each of a place or places.

    corners: where any of them jumps; there a slope may be either of its two.
    """

    level: Function
    slope: Function
    corners: Sequence[float] = ()
    curvature: Function = np.zeros_like


LEVEL = Rail(np.zeros_like, np.zeros_like)


def rails_of(irregularity: Mapping[str, Any], approach: float, span: float) -> tuple[Rail, Rail]:
    """The right and the left rail of `track.irregularity`, but for random ones.

    Waves and measured rails have the factor 1 - (1 - s)^3 (1 + 3 s + 6 s^2), s the share that is behind of
    the first quarter of the first approach, or ahead of the last quarter of the second.
    """
    found = []
    for side in (0, 1):
        standing: list[Rail] = []
        everywhere: list[Rail] = []
        for key, part in irregularity.items():
            if key == "profile":
                levels = part["left"] if side == 1 and "left" in part else part["right"]
                everywhere.append(_measured(part["x"], levels))
            elif sign := _SIDES[part.get("rails", "both")][side]:
                (everywhere if key == "harmonic" else standing).append(_scaled(_SHAPES[key](part), sign))
        found.append(
            _sum([*standing, _tapered(_sum(everywhere), approach, span)] if everywhere else standing)
        )
    return found[0], found[1]


def _sum(rails: Sequence[Rail]) -> Rail:
    def added(name: str) -> Function:
        return lambda x: sum((getattr(rail, name)(x) for rail in rails), 0 * x)

    corners = sorted({float(x) for rail in rails for x in rail.corners})
    return Rail(added("level"), added("slope"), corners, added("curvature"))


def _scaled(rail: Rail, factor: float) -> Rail:
    return Rail(
        lambda x: factor * rail.level(x),
        lambda x: factor * rail.slope(x),
        rail.corners,
        lambda x: factor * rail.curvature(x),
    )


def _between(begin: float, end: float, function: Function) -> Function:
    return lambda x: np.where((x > begin) & (x < end), function(x), 0.0)


def _ramp(part: Mapping[str, float]) -> Rail:
    ends = (part["at"], part["at"] + part["length"])
    return Rail(
        lambda x: np.interp(x, ends, (0.0, part["height"])),
        _between(*ends, lambda x: np.full_like(x, part["height"] / part["length"])),
        ends,
    )


def _dip(part: Mapping[str, float]) -> Rail:
    """-depth sin^2(pi s)."""
    ends, k, depth = (part["at"], part["at"] + part["length"]), np.pi / part["length"], part["depth"]
    return Rail(
        _between(*ends, lambda x: -depth * np.sin(k * (x - ends[0])) ** 2),
        _between(*ends, lambda x: -2 * depth * k * np.sin(k * (x - ends[0])) * np.cos(k * (x - ends[0]))),
        ends,
        _between(*ends, lambda x: -2 * depth * k * k * (1 - 2 * np.sin(k * (x - ends[0])) ** 2)),
    )


def _half_sine(part: Mapping[str, float]) -> Rail:
    """height cos(pi (s - 1/2))."""
    ends, k, a = (part["at"], part["at"] + part["length"]), np.pi / part["length"], part["height"]
    top = part["at"] + part["length"] / 2
    return Rail(
        _between(*ends, lambda x: a * np.cos(k * (x - top))),
        _between(*ends, lambda x: -a * k * np.sin(k * (x - top))),
        ends,
        _between(*ends, lambda x: -a * k * k * np.cos(k * (x - top))),
    )


def _harmonic(part: Mapping[str, float]) -> Rail:
    k, a, at = 2 * np.pi / part["wavelength"], part["amplitude"], part.get("at", 0.0)
    return Rail(
        lambda x: a * np.sin(k * (x - at)),
        lambda x: a * k * np.cos(k * (x - at)),
        (),
        lambda x: -a * k * k * np.sin(k * (x - at)),
    )


_SHAPES = {"ramp": _ramp, "dip": _dip, "half_sine": _half_sine, "harmonic": _harmonic}


def _measured(places: Sequence[float], levels: Sequence[float]) -> Rail:
    """The cubic spline through points, level at its ends and beyond: continuous slopes give its curvatures M.

    h_k M_k-1 + 2 (h_k + h_k+1) M_k + h_k+1 M_k+1 = 6 (rise_k+1 / h_k+1 - rise_k / h_k), with h = 0 beyond.
    """
    x, y = np.array(places), np.array(levels)
    h, chord = np.diff(x), np.diff(y) / np.diff(x)
    n = len(x)
    system, jump = np.zeros((n, n)), np.diff(np.concatenate([[0.0], chord, [0.0]]))
    for k in range(n - 1):
        system[k : k + 2, k : k + 2] += h[k] * np.array([[2.0, 1.0], [1.0, 2.0]])
    M: Array = np.linalg.solve(system, 6 * jump)

    def at(place: Any) -> tuple[Any, Any, Any]:
        k = np.clip(np.searchsorted(x, place) - 1, 0, n - 2)
        return k, x[k + 1] - place, place - x[k]

    def level(place: Any) -> Any:
        place = np.clip(place, x[0], x[-1])
        k, a, b = at(place)
        bent = M[k] * a * (a * a - h[k] ** 2) + M[k + 1] * b * (b * b - h[k] ** 2)
        return (y[k] * a + y[k + 1] * b + bent / 6) / h[k]

    def slope(place: Any) -> Any:
        k, a, b = at(place)
        bent = M[k + 1] * (3 * b * b - h[k] ** 2) - M[k] * (3 * a * a - h[k] ** 2)
        return chord[k] + bent / (6 * h[k])

    def curvature(place: Any) -> Any:
        k, a, b = at(place)
        return (M[k] * a + M[k + 1] * b) / h[k]

    ends = (float(x[0]), float(x[-1]))
    return Rail(level, _between(*ends, slope), ends, _between(*ends, curvature))


def _tapered(rail: Rail, approach: float, span: float) -> Rail:
    """The rail times its factor W, by the product rule."""
    start, end, length = -approach, span + approach, approach / 4

    def factor(x: Any) -> tuple[Any, Any, Any]:
        s = np.clip(np.minimum(x - start, end - x) / length, 0.0, 1.0)
        if np.all(s == 1.0):
            return 1.0, 0.0, 0.0
        side = np.where(x - start < end - x, 1.0, -1.0) / length
        W = 1 - (1 - s) ** 3 * (1 + 3 * s + 6 * s * s)
        return W, side * 30 * (s - s * s) ** 2, side * side * 60 * (s - s * s) * (1 - 2 * s)

    def level(x: Any) -> Any:
        return factor(x)[0] * rail.level(x)

    def slope(x: Any) -> Any:
        W, W1, _ = factor(x)
        return W1 * rail.level(x) + W * rail.slope(x)

    def curvature(x: Any) -> Any:
        W, W1, W2 = factor(x)
        return W2 * rail.level(x) + 2 * W1 * rail.slope(x) + W * rail.curvature(x)

    return Rail(level, slope, rail.corners, curvature)
