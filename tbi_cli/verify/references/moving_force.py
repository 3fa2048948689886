"""Constant forces moving over a simply supported beam: closed forms, exact for every mode.

L. Fryba, Vibration of Solids and Structures under Moving Loads, 3rd ed. (1999), part II. Each mode is a
damped oscillator under A sin(Omega t) while the force is on the beam, Omega = i pi v / L, and free
afterwards. Deflections are positive upwards and forces act downwards, as in the results file.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from tbi_cli.verify.references.parameters import Array, Beam


def critical_speed(beam: Beam) -> float:
    """v_c [m/s] = 2 f_1 L: the force takes half a period of the first mode to cross."""
    return float(beam.omega[0]) / math.pi * beam.length


def forced(t: Array, omega: float, zeta: float, Omega: float) -> tuple[Array, Array]:
    """x and x' of x'' + 2 zeta omega x' + omega^2 x = sin(Omega t) from rest, for zeta other than 1.

    The undamped one is written so that it goes smoothly through the resonance omega = Omega, where it is
    (sin omega t - omega t cos omega t) / (2 omega^2).
    """
    if zeta == 0.0:
        mean, half = (omega + Omega) / 2, (omega - Omega) / 2
        beat = t * np.sinc(half * t / math.pi)
        x = (np.sin(omega * t) - omega * np.cos(mean * t) * beat) / (omega * (omega + Omega))
        # x' = Omega (cos Omega t - cos omega t) / (omega^2 - Omega^2)
        x_t = Omega * np.sin(mean * t) * beat / (omega + Omega)
        return x, x_t
    D = (omega**2 - Omega**2) ** 2 + (2 * zeta * omega * Omega) ** 2
    a, b = (omega**2 - Omega**2) / D, -2 * zeta * omega * Omega / D
    free, free_t = free_vibration(t, omega, zeta, -b, -a * Omega)
    x = a * np.sin(Omega * t) + b * np.cos(Omega * t) + free
    x_t = Omega * (a * np.cos(Omega * t) - b * np.sin(Omega * t)) + free_t
    return x, x_t


def free_vibration(t: Array, omega: float, zeta: float, x0: float, v0: float) -> tuple[Array, Array]:
    """x and x' of x'' + 2 zeta omega x' + omega^2 x = 0 from x0, v0 at t = 0, for zeta other than 1.

    Overdamped, zeta > 1, it is the sum of two motions that die away, exp(-r t).
    """
    if zeta > 1:
        fast = omega * (zeta + math.sqrt(zeta**2 - 1))
        slow = omega**2 / fast
        a, b = (v0 + fast * x0) / (fast - slow), -(v0 + slow * x0) / (fast - slow)
        one, other = a * np.exp(-slow * t), b * np.exp(-fast * t)
        return one + other, -slow * one - fast * other
    omega_d = omega * math.sqrt(1 - zeta**2)
    decay = np.exp(-zeta * omega * t)
    c, s = np.cos(omega_d * t), np.sin(omega_d * t)
    b = (v0 + zeta * omega * x0) / omega_d
    x = decay * (x0 * c + b * s)
    x_t = decay * ((b * omega_d - zeta * omega * x0) * c - (x0 * omega_d + zeta * omega * b) * s)
    return x, x_t


def modal_coordinates(beam: Beam, force: float, velocity: float, t: Array) -> tuple[Array, Array]:
    """q and q' (n, nt) under one force [N] that enters at t = 0; zero before, free after the exit."""
    q, q_t = np.zeros((beam.n, len(t))), np.zeros((beam.n, len(t)))
    exit_time = beam.length / velocity
    on, after = (t >= 0) & (t <= exit_time), t > exit_time
    amplitude = -force * math.sqrt(2 / beam.length) / beam.mu
    for i in range(beam.n):
        omega, Omega = float(beam.omega[i]), float(beam.wave_numbers[i]) * velocity
        zeta = float(beam.c[i]) / (2 * beam.mu * omega)
        q[i, on], q_t[i, on] = forced(t[on], omega, zeta, Omega)
        x0, v0 = forced(np.array([exit_time]), omega, zeta, Omega)
        q[i, after], q_t[i, after] = free_vibration(
            t[after] - exit_time, omega, zeta, float(x0[0]), float(v0[0])
        )
    return amplitude * q, amplitude * q_t


def deflection(
    beam: Beam,
    forces: Sequence[float],
    positions: Sequence[float],
    velocity: float,
    t: Array,
    x: float | None = None,
) -> Array:
    """Deflection [m] (nt,) at x (mid-span by default) under forces [N] at `positions` [m] behind the first.

    The sum of the closed forms of the single forces.
    """
    place = beam.length / 2 if x is None else x
    shape = math.sqrt(2 / beam.length) * np.sin(beam.wave_numbers * place)
    w = np.zeros(len(t))
    for force, behind in zip(forces, positions, strict=True):
        w += shape @ modal_coordinates(beam, force, velocity, t - behind / velocity)[0]
    return w


def resonant_speed(beam: Beam, spacing: float, i: int) -> float:
    """v [m/s] = f_1 D / i: a force enters every i periods of the first mode."""
    return float(beam.omega[0]) / (2 * math.pi) * spacing / i


def cancellation_speed(beam: Beam, i: int) -> float:
    """v [m/s] = v_c / (2 i + 1), i >= 1: without damping one force leaves every mode still."""
    return critical_speed(beam) / (2 * i + 1)


def spacing_cancellation_speed(beam: Beam, spacing: float, count: int, m: int) -> float:
    """v [m/s] = N f_1 D / m, m no multiple of N: N forces together leave the undamped first mode still."""
    if m % count == 0:
        raise ValueError(f"m = {m} is a multiple of N = {count}: that speed is resonant")
    return count * float(beam.omega[0]) / (2 * math.pi) * spacing / m


def equal_forces_deflection(
    beam: Beam, force: float, spacing: float, count: int, velocity: float, t: Array
) -> Array:
    """Mid-span deflection [m] (nt,) under `count` equal forces, from the sum of a geometric series.

    For spacing >= L, so that one force at most is on the beam. A force that entered at t = 0 leaves the
    free vibration Re(Z exp(lambda t)), lambda = -zeta omega + i omega_d; k of them, the time spacing / v
    apart, leave Re(Z exp(lambda t) (1 - r^k) / (1 - r)) with r = exp(-lambda spacing / v).
    """
    if spacing < beam.length:
        raise ValueError(f"spacing {spacing} m is shorter than the beam's {beam.length} m")
    gap, exit_time = spacing / velocity, beam.length / velocity
    shape = math.sqrt(2 / beam.length) * np.sin(beam.wave_numbers * beam.length / 2)
    # forces that have left at each time, and the time since the youngest force on the beam came in
    gone = np.clip(np.floor((t - exit_time) / gap) + 1, 0, count)
    entered = np.clip(np.floor(t / gap) + 1, 0, count)
    q, _ = modal_coordinates(beam, force, velocity, np.where(entered > gone, t - gone * gap, -1.0))
    w: Array = shape @ q
    at_exit, at_exit_t = modal_coordinates(beam, force, velocity, np.array([exit_time]))
    for i in range(beam.n):
        omega = float(beam.omega[i])
        zeta = float(beam.c[i]) / (2 * beam.mu * omega)
        lam = complex(-zeta * omega, omega * math.sqrt(1 - zeta**2))
        # x = Re(z), x' = Re(lambda z) at the exit
        x0, v0 = float(at_exit[i, 0]), float(at_exit_t[i, 0])
        z = complex(x0, -(v0 - lam.real * x0) / lam.imag)
        # measured from the exit of the last force gone: 1 + e + e^2 + ..., e = exp(lambda gap), |e| <= 1
        e = np.exp(lam * gap)
        series = gone if abs(1 - e) < 1e-12 else (1 - e**gone) / (1 - e)
        since = np.where(gone > 0, t - exit_time - (gone - 1) * gap, 0.0)
        w += shape[i] * np.real(z * np.exp(lam * since) * series)
    return w
