"""Simply supported Euler-Bernoulli beams in their sine modes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tbi_cli.case import Beam, Bridge

# A filter has lost 29 % at its cut-off.  So far above the highest frequency that counts, Butterworth's of
# fourth order loses 1.9 % there, 1 - 1/sqrt(1 + 1.5^-8), and nothing to speak of below.
_ABOVE_WHAT_COUNTS = 1.5


def natural_frequencies(bridge: Bridge, beam: Beam) -> NDArray[np.float64]:
    """Circular natural frequencies (rad/s) of the modes 1..n: Eq. (14)."""
    j = np.arange(1, bridge.modes + 1)
    stiffness = beam.youngs_modulus * beam.second_moment
    omega: NDArray[np.float64] = (j * np.pi / bridge.length) ** 2 * np.sqrt(stiffness / beam.mass_per_length)
    return omega


def critical_velocities(bridge: Bridge, beam: Beam, axle_distance: float) -> NDArray[np.float64]:
    """Velocities (m/s) at which the train's length over its speed is the period of a mode: Eq. (16), i = 1.

    `axle_distance` (m) is from the first axle to the last.
    """
    return axle_distance * natural_frequencies(bridge, beam) / (2 * np.pi)


def modal_damping(bridge: Bridge, beam: Beam) -> NDArray[np.float64]:
    """c/mu of each mode (1/s), from any of the three ways in which a case gives it."""
    omega = natural_frequencies(bridge, beam)
    damping = beam.damping
    if damping.form == "coefficient":
        return np.full(bridge.modes, damping.value / beam.mass_per_length)
    if damping.form == "first_mode_ratio":
        return np.full(bridge.modes, 2 * damping.value * omega[0])
    return 2 * damping.value * omega


@dataclass(frozen=True)
class BeamModes:
    """One beam in modal amplitudes A_i, w(x, t) = sum A_i(t) sin(i pi x/L).

    The paper's coordinate of Eq. (5) is q_i = sqrt(L/2) A_i.  `low_pass` (Hz) is the cut-off for the beam's
    low-passed accelerations, 0 for none.
    """

    length: float
    bending_stiffness: float
    mass_per_length: float
    omega: NDArray[np.float64]
    damping: NDArray[np.float64]
    low_pass: float = 0.0

    @property
    def gain(self) -> float:
        """What a unit force at an antinode adds to the acceleration of an amplitude: 2/(mu L)."""
        return 2 / (self.mass_per_length * self.length)

    def static_deflection(self, force: float) -> float:
        """Largest deflection (m) under one force at mid-span: F L^3/(48 EI), section 3.6."""
        return force * self.length**3 / (48 * self.bending_stiffness)

    def crawling_deflection(self, loads: NDArray[np.float64], offsets: NDArray[np.float64]) -> float:
        """Largest mid-span deflection (m) under axle loads that cross at crawling speed, with these modes.

        A scan of the first axle's position over the whole crossing brackets the largest, ever finer ones
        between its neighbours settle it to the last digits.
        """
        i = np.arange(1, len(self.omega) + 1)
        amplitude = self.gain / self.omega**2 * np.sin(i * np.pi / 2)

        def deflection(position: NDArray[np.float64]) -> NDArray[np.float64]:
            x = np.asarray(position)[..., None] - offsets
            on = (x >= 0) & (x <= self.length)
            shapes = np.sin(i * np.pi * x[..., None] / self.length) @ amplitude
            total: NDArray[np.float64] = np.abs(np.sum(loads * on * shapes, axis=-1))
            return total

        low, high = 0.0, self.length + float(offsets[-1])
        scan = np.linspace(low, high, 1001)
        for _ in range(7):
            values = deflection(scan)
            best = int(np.argmax(values))
            low, high = scan[max(best - 1, 0)], scan[min(best + 1, len(scan) - 1)]
            scan = np.linspace(low, high, 33)
        return float(np.max(values))


def beam_modes(bridge: Bridge, beam: Beam) -> BeamModes:
    """A beam of a case in modal form."""
    return BeamModes(
        length=bridge.length,
        bending_stiffness=beam.youngs_modulus * beam.second_moment,
        mass_per_length=beam.mass_per_length,
        omega=natural_frequencies(bridge, beam),
        damping=modal_damping(bridge, beam),
        low_pass=low_pass_frequency(bridge, beam),
    )


def low_pass_frequency(bridge: Bridge, beam: Beam) -> float:
    """Cut-off (Hz) of the filter for accelerations; 0 where none is asked for.

    EN 1990, A2.4.4.2.1 (4), counts frequencies up to 30 Hz, 1.5 times the first natural frequency or the
    third one, whichever is largest.
    """
    if bridge.low_pass == "none":
        return 0.0
    if bridge.low_pass != "en-1990":
        return float(bridge.low_pass)
    first = (
        (np.pi / bridge.length) ** 2
        * np.sqrt(beam.youngs_modulus * beam.second_moment / beam.mass_per_length)
        / (2 * np.pi)
    )
    return _ABOVE_WHAT_COUNTS * float(max(30.0, 1.5 * first, 9 * first))
