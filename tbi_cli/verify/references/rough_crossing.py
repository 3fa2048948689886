"""The paper's contact on irregular rails: the 31-DOF crossing with a level r under each wheel, by DOP853."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from tbi_cli.verify.references.crossing import CoupledSystem, Motion, channels_of
from tbi_cli.verify.references.energies import KINEMATIC
from tbi_cli.verify.references.parameters import Array, Crossing, crossing_from_case
from tbi_cli.verify.references.rail_shapes import BESIDE, Rail
from tbi_cli.verify.references.rails import piecewise


class RoughSystem(CoupledSystem):
    """The coupled equations with s = (..) - w - r and s' = (..) - w' - v r' at every wheel."""

    def __init__(self, crossing: Crossing, rails: tuple[Rail, Rail]) -> None:
        super().__init__(crossing)
        self.rails = rails
        # Which side of a corner is meant: where the wheels are so many metres further.
        self._beside = BESIDE

    def wheel_forces(self, time: float, x: Array, x_t: Array, on: Array) -> tuple[Array, Array, Array]:
        """phi (8, 2n), stretch (8,) and force k s + c s' (8,) of the primary vertical springs."""
        phi, s, force = super().wheel_forces(time, x, x_t, on)
        xi = self.positions(time)
        r = np.concatenate([rail.level(xi) for rail in self.rails])
        slope = np.concatenate([rail.slope(xi + self._beside) for rail in self.rails])
        rate = self.crossing.velocity * slope
        return phi, s - r, force - self.matrices.wheel_k * r - self.matrices.wheel_c * rate

    def integrate(self, times: Array, rtol: float = 1e-10, atol: float = 1e-14) -> tuple[Array, Array]:
        """x and x' (27 + 2n, nt) at increasing `times`, from rest at the first of them."""
        size = self.size

        def rate(t: float, state: Array, inside: float) -> Array:
            x, x_t = state[:size], state[size:]
            self._beside = BESIDE if t < inside else -BESIDE
            return np.concatenate([x_t, self.acceleration(t, x, x_t, self.axles_on(inside))])

        corners = np.unique([x for rail in self.rails for x in rail.corners])
        passing = np.add.outer(corners, self.distances).ravel() / self.crossing.velocity
        state, _ = piecewise(rate, 2 * size, [*self.events(), *passing], times)
        self._beside = BESIDE
        return state[:size], state[size:]

    def motion(self, times: Array, **tolerances: float) -> Motion:
        """The motion, the wheelsets' y with the mean of the rails under their wheels."""
        motion = super().motion(times, **tolerances)
        v, xi = self.crossing.velocity, self.positions(times) + BESIDE
        u, u_t, u_tt = motion.u.copy(), motion.u_t.copy(), motion.u_tt.copy()
        rows = list(KINEMATIC)
        u[rows] += np.mean([rail.level(xi) for rail in self.rails], axis=0)
        u_t[rows] += v * np.mean([rail.slope(xi) for rail in self.rails], axis=0)
        u_tt[rows] += v * v * np.mean([rail.curvature(xi) for rail in self.rails], axis=0)
        return replace(motion, u=u, u_t=u_t, u_tt=u_tt)


def rough_channels(case: Mapping[str, Any], times: Array, rails: tuple[Rail, Rail]) -> dict[str, Array]:
    """Channels of the results file for a case with the contact `paper`, at `times` from the start."""
    system = RoughSystem(crossing_from_case(case), rails)
    return channels_of(system, system.motion(np.asarray(times, dtype=float)))
