"""The paper's contact on irregular rails: the 31-DOF crossing with a level r under each wheel, by DOP853."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tbi_cli.verify.references.crossing import CoupledSystem, Motion, channels_of
from tbi_cli.verify.references.energies import KINEMATIC
from tbi_cli.verify.references.parameters import Array, Crossing, crossing_from_case
from tbi_cli.verify.references.rails import Rail, piecewise


@dataclass(frozen=True)
class TaperedSine:
    """Sine waves of a rail that grow within `taper` from `start` and fade before `end` (m).

    r = a s^3 (10 - 15 s + 6 s^2) sin(2 pi x/wavelength), s the share of the taper that is behind or ahead.
    """

    amplitude: float
    wavelength: float
    start: float
    end: float
    taper: float

    def rail(self) -> Rail:
        """Level, slope and curvature as functions of the place."""
        return Rail(lambda x: self._derivatives(x)[0], lambda x: self._derivatives(x)[1])

    def curvature(self, x: float) -> float:
        """r'' (1/m)."""
        return self._derivatives(x)[2]

    def _derivatives(self, x: float) -> tuple[float, float, float]:
        ahead = self.end - x < x - self.start
        s = min(max((self.end - x if ahead else x - self.start) / self.taper, 0.0), 1.0)
        side = (-1.0 if ahead else 1.0) / self.taper
        W, W1, W2 = s**3 * (10 - 15 * s + 6 * s * s), 30 * (s * (1 - s)) ** 2, 60 * s * (1 - s) * (1 - 2 * s)
        W1, W2 = W1 * side, W2 * side * side
        k = 2 * np.pi / self.wavelength
        sine, cosine = self.amplitude * np.sin(k * x), self.amplitude * k * np.cos(k * x)
        return W * sine, W1 * sine + W * cosine, W2 * sine + 2 * W1 * cosine - W * k * k * sine


class RoughSystem(CoupledSystem):
    """The coupled equations with s = (..) - w - r and s' = (..) - w' - v r' at every wheel."""

    def __init__(self, crossing: Crossing, waves: tuple[TaperedSine, TaperedSine]) -> None:
        super().__init__(crossing)
        self.waves = waves
        self.rails = tuple(wave.rail() for wave in waves)

    def wheel_forces(self, time: float, x: Array, x_t: Array, on: Array) -> tuple[Array, Array, Array]:
        """phi (8, 2n), stretch (8,) and force k s + c s' (8,) of the primary vertical springs."""
        phi, s, force = super().wheel_forces(time, x, x_t, on)
        xi = self.positions(time)
        r = np.array([rail.level(place) for rail in self.rails for place in xi])
        rate = self.crossing.velocity * np.array([rail.slope(place) for rail in self.rails for place in xi])
        return phi, s - r, force - self.matrices.wheel_k * r - self.matrices.wheel_c * rate

    def integrate(self, times: Array, rtol: float = 1e-10, atol: float = 1e-14) -> tuple[Array, Array]:
        """x and x' (27 + 2n, nt) at increasing `times`, from rest at the first of them."""
        size = self.size

        def rate(t: float, state: Array, inside: float) -> Array:
            x, x_t = state[:size], state[size:]
            return np.concatenate([x_t, self.acceleration(t, x, x_t, self.axles_on(inside))])

        state, _ = piecewise(rate, 2 * size, list(self.events()), times)
        return state[:size], state[size:]

    def motion(self, times: Array, **tolerances: float) -> Motion:
        """The motion, the wheelsets' y with the mean of the rails under their wheels."""
        motion = super().motion(times, **tolerances)
        v, xi = self.crossing.velocity, self.positions(times)

        def mean(of: Callable[[TaperedSine, float], float]) -> Array:
            levels = np.array([[[of(wave, x) for x in row] for row in xi] for wave in self.waves])
            found: Array = levels.mean(axis=0)
            return found

        u, u_t, u_tt = motion.u.copy(), motion.u_t.copy(), motion.u_tt.copy()
        rows = list(KINEMATIC)
        u[rows] += mean(lambda wave, x: wave.rail().level(x))
        u_t[rows] += v * mean(lambda wave, x: wave.rail().slope(x))
        u_tt[rows] += v * v * mean(lambda wave, x: wave.curvature(x))
        return replace(motion, u=u, u_t=u_t, u_tt=u_tt)


def rough_channels(
    case: Mapping[str, Any], times: Array, waves: tuple[TaperedSine, TaperedSine]
) -> dict[str, Array]:
    """Channels of the results file for a case with the contact `paper`, at `times` from the start."""
    system = RoughSystem(crossing_from_case(case), waves)
    return channels_of(system, system.motion(np.asarray(times, dtype=float)))
