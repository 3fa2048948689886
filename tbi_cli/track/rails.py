"""The rails of a case: everything that its irregularity names, added up."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from tbi_cli.case import Irregularity, Track
from tbi_cli.case.track import TAPER
from tbi_cli.track.profile import Array, RailProfile, chain
from tbi_cli.track.random_profile import random_profile
from tbi_cli.track.shapes import Chained, Level, Measured, Shape


def rail_profile(track: Track, span: float) -> RailProfile:
    """Both rails from -approach to span + approach (m), or to the end of the last shape.

    Sine waves, random and measured rails are tapered at both ends, so that a train starts on level rails;
    shapes stand where they stand, and a ramp leads to a level that is kept.
    """
    irregularity, shapes = track.irregularity, track.irregularity.shapes
    start, end = -track.approach, span + track.approach
    last = max((end, *(shape.at + shape.length for shape in shapes.values())))
    everywhere = _everywhere(irregularity, start, end)
    # One part of it has points of the chain where it has its own: the first shape, which has corners at both
    # ends, or else the measured rails, or the random ones.
    whole, anchor = track.spacing, 0.0
    if shapes:
        first = next(iter(shapes.values()))
        whole, anchor = first.length, first.at
    elif irregularity.profile is not None:
        whole, anchor = min(b - a for a, b in pairwise(irregularity.profile.x)), irregularity.profile.x[0]
    elif isinstance(everywhere[-1], Chained):
        whole = everywhere[-1].spacing
    spacing = whole / float(np.ceil(whole / track.spacing - 1e-9))
    before, after = (np.ceil(way / spacing - 1e-9) for way in (anchor - start, last - anchor))
    x: Array = anchor + spacing * np.arange(-before, after + 1)
    middle = (x[:-1] + x[1:]) / 2
    level = np.zeros((2, len(x)))
    slope_after, slope_before = np.zeros((2, len(middle))), np.zeros((2, len(middle)))
    for shape in map(Shape, shapes.values()):
        level += shape.level(x)
        slope_after += shape.slope(x[:-1], middle)
        slope_before += shape.slope(x[1:], middle)
    if everywhere:
        weight, growth = _taper(x, start, end, TAPER * track.approach)
        for part in everywhere:
            here = part.level(x)
            level += weight * here
            slope_after += (growth * here)[:, :-1] + weight[:-1] * part.slope(x[:-1], middle)
            slope_before += (growth * here)[:, 1:] + weight[1:] * part.slope(x[1:], middle)
    return chain(float(x[0]), spacing, level, slope_after, slope_before)


def _everywhere(irregularity: Irregularity, start: float, end: float) -> list[Level]:
    """What goes on all along the track."""
    parts: list[Level] = []
    if irregularity.harmonic is not None:
        parts.append(Shape(irregularity.harmonic))
    if irregularity.profile is not None:
        parts.append(Measured(irregularity.profile))
    if irregularity.random is not None:
        parts.append(Chained(random_profile(irregularity.random, start, end)))
    return parts


def _taper(x: Array, start: float, end: float, length: float) -> tuple[Array, Array]:
    """A factor (n,) that grows from 0 to 1 within `length` of the start and falls back before the end.

    It is s^3 (10 - 15 s + 6 s^2), whose slope and curvature are zero at both of its ends; and its derivative.
    """
    near = np.minimum(x - start, end - x) / length
    s = np.clip(near, 0.0, 1.0)
    side = np.where(x - start < end - x, 1.0, -1.0) / length
    return s**3 * (10 + s * (6 * s - 15)), side * 30 * s**2 * (1 - s) ** 2
