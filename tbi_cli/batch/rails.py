"""The rails under the scenarios of a batch."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tbi_cli.integrator.arrays import LEVEL_RAILS
from tbi_cli.track import RailProfile


class Rails:
    """Each profile once, with a level interval at either end."""

    def __init__(self, of: Sequence[RailProfile | None]) -> None:
        profiles = list({id(profile): profile for profile in of if profile is not None}.values())
        self.irregular = bool(profiles)
        self.cubics, number = LEVEL_RAILS, {id(profile): k for k, profile in enumerate(profiles)}
        if profiles:
            most = max(p.cubics.shape[1] for p in profiles)
            self.cubics = np.zeros((len(profiles), 2, most + 2, 4))
        for k, profile in enumerate(profiles):
            last = profile.cubics.shape[1]
            self.cubics[k, :, 0, 0] = profile.cubics[:, 0, 0]
            self.cubics[k, :, 1 : last + 1] = profile.cubics
            self.cubics[k, :, last + 1 :, 0] = profile.cubics[:, -1].sum(axis=-1)[:, None]
        cubics = 2.0 * self.cubics.shape[2]
        rails = [
            (0.0, 0.0, 0.0) if p is None else (p.first, 1 / p.spacing, cubics * number[id(p)]) for p in of
        ]
        self.first, self.density, self.cubic = np.array(rails).T
