"""The rails of a case: everything that its irregularity names, added up."""

from __future__ import annotations

import numpy as np

from tbi_cli.case import Irregularity, Ramp, Track
from tbi_cli.case.track import INTERVALS_IN_SHAPE, TAPER
from tbi_cli.track.profile import Array, RailProfile, chain
from tbi_cli.track.random_profile import random_profile
from tbi_cli.track.shapes import Chained, Level, Measured, Shape, Waves

# Points nearer to each other than this (m) are one.
_APART = 1e-6
# A point of random rails, where they have no corner, is left out if another is nearer than this share of
# their spacing.
_CROWDED = 0.125


def rail_profile(track: Track, span: float) -> RailProfile:
    """Both rails from -approach to span + approach (m), or to the end of the last shape.

    Sine waves, random and measured rails are tapered at both ends, so that a train starts on level rails;
    shapes stand where they stand, and a ramp leads to a level that is kept.
    """
    irregularity = track.irregularity
    start, end = -track.approach, span + track.approach
    everywhere = _everywhere(irregularity, start, end)
    x = _points(track, everywhere, start, end)
    middle = (x[:-1] + x[1:]) / 2
    level = np.zeros((2, len(x)))
    slope_after, slope_before = np.zeros((2, len(middle))), np.zeros((2, len(middle)))
    for shape in map(Shape, irregularity.shapes.values()):
        level += shape.level(x)
        slope_after += shape.slope(x[:-1], middle)
        slope_before += shape.slope(x[1:], middle)
    if everywhere:
        weight, growth = _taper(x, start, end, TAPER * track.approach)
        for part in everywhere:
            here = part.level(x)
            slope = growth * here + weight * part.slope(x)
            level += weight * here
            slope_after += slope[:, :-1]
            slope_before += slope[:, 1:]
    return chain(x, level, slope_after, slope_before)


def _everywhere(irregularity: Irregularity, start: float, end: float) -> list[Level]:
    """What goes on all along the track."""
    parts: list[Level] = []
    if irregularity.harmonic is not None:
        parts.append(Waves(irregularity.harmonic))
    if irregularity.profile is not None:
        parts.append(Measured(irregularity.profile))
    if irregularity.random is not None:
        parts.append(Chained(random_profile(irregularity.random, start, end)))
    return parts


def _points(track: Track, everywhere: list[Level], start: float, end: float) -> Array:
    """Where the cubics meet: at every corner and point of every part, and as often between them as each asks.

    What is a cubic between two of its points is met exactly; of anything else, a wave, half a wave of a bump
    or a taper, there are at least INTERVALS_IN_SHAPE cubics.
    """
    shapes, harmonic = track.irregularity.shapes, track.irregularity.harmonic
    taper = TAPER * track.approach if everywhere else 0.0
    x: Array = np.zeros(0)
    for shape in shapes.values():
        x = _together(x, np.array([shape.at, shape.at + shape.length]), _APART)
    for part in everywhere:
        if isinstance(part, Measured):
            x = _together(x, part.x[(part.x > start) & (part.x < end)], _APART)
    *_, last = (None, *everywhere)
    if isinstance(last, Chained):
        x = _together(x, last.x, _CROWDED * float(last.x[1] - last.x[0]))
    else:
        x = _together(x, np.array([start, start + taper, end - taper, end]), _APART)
    middle, longest = (x[:-1] + x[1:]) / 2, np.full(len(x) - 1, np.inf)

    def resolve(length: float, begin: float, stop: float) -> None:
        within = (middle > begin) & (middle < stop)
        longest[within] = np.minimum(longest[within], length / INTERVALS_IN_SHAPE)

    for shape in shapes.values():
        if not isinstance(shape, Ramp):
            resolve(shape.length, shape.at, shape.at + shape.length)
    if harmonic is not None:
        resolve(harmonic.wavelength, start, end)
    if everywhere:
        resolve(taper, start, start + taper)
        resolve(taper, end - taper, end)
    return _divided(x, longest)


def _divided(x: Array, longest: Array) -> Array:
    """Points x (n + 1,), and between them those that leave no interval longer than `longest` (n,), evenly."""
    length = np.diff(x)
    parts = np.maximum(np.ceil(length / longest - 1e-9), 1.0).astype(np.int64)
    k = np.arange(parts.sum()) - np.repeat(np.cumsum(parts) - parts, parts)
    within: Array = np.repeat(x[:-1], parts) + np.repeat(length / parts, parts) * k
    return np.append(within, x[-1])


def _together(x: Array, more: Array, apart: float) -> Array:
    """Points x (n,), rising, and those of `more` that are not nearer to one of them than `apart`."""
    bounds = np.concatenate([[-np.inf], x, [np.inf]])
    k = np.searchsorted(bounds, more)
    return np.union1d(x, more[np.minimum(more - bounds[k - 1], bounds[k] - more) >= apart])


def _taper(x: Array, start: float, end: float, length: float) -> tuple[Array, Array]:
    """A factor (n,) that grows from 0 to 1 within `length` of the start and falls back before the end.

    It is s^3 (10 - 15 s + 6 s^2), whose slope and curvature are zero at both of its ends; and its derivative.
    """
    near = np.minimum(x - start, end - x) / length
    s = np.clip(near, 0.0, 1.0)
    side = np.where(x - start < end - x, 1.0, -1.0) / length
    return s**3 * (10 + s * (6 * s - 15)), side * 30 * s**2 * (1 - s) ** 2
