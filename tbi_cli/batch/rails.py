"""The rails under the scenarios of a batch."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tbi_cli.integrator.arrays import LEVEL_RAILS
from tbi_cli.track import RailProfile


class Rails:
    """Each profile once, its intervals one after the other.

    intervals (any, 3, 4), see `integrator.rails`.  Of each scenario: first, the number of its first interval;
    begin, where its rails begin (m); lead, the length of the level interval before (m).
    """

    def __init__(self, of: Sequence[RailProfile | None]) -> None:
        profiles = list({id(profile): profile for profile in of if profile is not None}.values())
        self.irregular = bool(profiles)
        parts = [LEVEL_RAILS, *map(_intervals, profiles)]
        self.intervals = np.concatenate(parts)
        begins = np.cumsum([len(part) for part in parts])
        begin = {id(profile): number for profile, number in zip(profiles, begins, strict=False)}
        self.first = np.array([0.0 if p is None else float(begin[id(p)]) for p in of])
        self.begin = np.array([0.0 if p is None else float(p.x[0]) for p in of])
        self.lead = np.array([0.0 if p is None else float(p.x[1] - p.x[0]) for p in of])


def _intervals(profile: RailProfile) -> np.ndarray:
    """The intervals of a profile, with two level ones before it and one behind.

    Where it begins another interval ends, so that a corner there is a corner like others.
    """
    count, place = profile.cubics.shape[1], profile.x - profile.x[0] + (profile.x[1] - profile.x[0])
    found = np.zeros((count + 3, 3, 4))
    found[:2, :2, 0] = profile.cubics[:, 0, 0]
    found[2:-1, :2] = profile.cubics.swapaxes(0, 1)
    found[-1, :2, 0] = profile.cubics[:, -1].sum(axis=-1)
    found[1:-1, 2, 0] = np.append(0.0, place[:-1])
    found[1:-1, 2, 1] = np.append(0.0, 1 / np.diff(profile.x))
    found[1:-1, 2, 2] = place
    found[-1, 2, 2] = np.inf
    found[1:-1, 2, 3] = profile.corners
    return found
