"""Closed forms on rigid, irregular track: a sprung mass over a ramp and over waves, a wheel in flight."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from tbi_cli.verify.references.parameters import Array
from tbi_cli.verify.references.simple_vehicles import SprungMass


def over_a_ramp(vehicle: SprungMass, rise_rate: float, begin: float, end: float, times: Array) -> Array:
    """y (nt,) of a sprung mass whose base rises at `rise_rate` (m/s) from time `begin` to `end`.

    A corner of the base gives the stretch an initial rate: y = y_base -+ rate/omega_d exp(-zeta omega t)
    sin(omega_d t) from it on.
    """
    omega = math.sqrt(vehicle.stiffness / vehicle.mass)
    decay = vehicle.damping / (2 * vehicle.mass)
    damped = math.sqrt(omega**2 - decay**2)

    def ringing(t: Array) -> Array:
        after = np.maximum(t, 0.0)
        found: Array = np.exp(-decay * after) * np.sin(damped * after) / damped
        return found

    base = rise_rate * (np.clip(times, begin, end) - begin)
    found: Array = base - rise_rate * (ringing(times - begin) - ringing(times - end))
    return found


def steady_sine(vehicle: SprungMass, amplitude: float, frequency: float, times: Array) -> Array:
    """y (nt,) of a sprung mass on a base amplitude sin(frequency t), long after it began (rad/s)."""
    k, c, m = vehicle.stiffness, vehicle.damping, vehicle.mass
    transfer = (k + 1j * c * frequency) / (k - m * frequency**2 + 1j * c * frequency)
    found: Array = amplitude * np.imag(transfer * np.exp(1j * frequency * times))
    return found


@dataclass(frozen=True)
class Flight:
    """A mass pressed down by a constant force onto a contact spring, its base falling away at a rate.

    mass (kg) of one wheel, load (N) on it, stiffness (N/m) and damping (N s/m) of its contact; it leaves its
    base with the relative upward velocity `rate` (m/s) from the static compression.
    """

    mass: float
    load: float
    stiffness: float
    damping: float
    rate: float

    @property
    def _ringing(self) -> tuple[float, float]:
        decay = self.damping / (2 * self.mass)
        return decay, math.sqrt(self.stiffness / self.mass - decay**2)

    def pressed(self, t: Array) -> tuple[Array, Array]:
        """Height above the static place and its rate while the wheel touches."""
        decay, damped = self._ringing
        height = self.rate / damped * np.exp(-decay * t) * np.sin(damped * t)
        speed = self.rate * np.exp(-decay * t) * np.cos(damped * t) - decay * height
        return height, speed

    @property
    def lift_off(self) -> float:
        """When the force of the contact is spent (s): load = k z + c z'."""
        from scipy.optimize import brentq

        def force(t: float) -> float:
            height, speed = self.pressed(np.array(t))
            return self.load - self.stiffness * float(height) - self.damping * float(speed)

        _, damped = self._ringing
        return float(brentq(force, 0.0, math.pi / 2 / damped, xtol=1e-15))

    def flying(self, t: Array) -> Array:
        """Height after the lift-off: a parabola under weight and load, whose sum is the static load."""
        height, speed = self.pressed(np.array(self.lift_off))
        since = t - self.lift_off
        found: Array = float(height) + float(speed) * since - self.load / self.mass * since**2 / 2
        return found

    @property
    def landing(self) -> float:
        """When the contact closes again (s): load = k z + c z' for the second time."""
        _, speed = self.pressed(np.array(self.lift_off))
        duration = 2 * float(speed) * self.mass / self.load - 2 * self.damping / self.stiffness
        return self.lift_off + duration
