"""Bending moments and shear forces of a simply supported beam, from its deflection and not from inertia.

M = EI w_xx, sagging positive with w upwards, and V = M_x.  A sum over modes of what the deflection lacks to
that at rest is added to the influence lines, which are exact:
    M = sum F m(x, xi) + EI sum_i phi_i'' (q_i - q_i,rest),    q_i,rest = -sum F phi_i(xi) / (EI k_i^4).
"""

from __future__ import annotations

import math

import numpy as np

from tbi_cli.verify.references.parameters import Array, Beam


def moment_line(length: float, x: float, xi: Array) -> Array:
    """Moment [m] at x under a unit force at xi: (L - x) xi/L before x, x (L - xi)/L behind; 0 elsewhere."""
    line = np.where(xi < x, (length - x) * xi, x * (length - xi)) / length
    return np.where((xi >= 0) & (xi <= length), line, 0.0)


def shear_line(length: float, x: float, xi: Array) -> Array:
    """Shear force at x under a unit force at xi: -xi/L before x, 1 - xi/L from there on; 0 off the beam.

    At the end of the beam, x = L, it is the support's push throughout.
    """
    line = np.where((xi < x) | (x == length), -xi, length - xi) / length
    return np.where((xi >= 0) & (xi <= length), line, 0.0)


def moment_and_shear(beam: Beam, x: float, q: Array, forces: Array, places: Array) -> tuple[Array, Array]:
    """M and V (nt,) at x from modal coordinates q (n, nt) under forces (axles, nt) at places (axles, nt)."""
    k, amplitude, length = beam.wave_numbers, math.sqrt(2 / beam.length), beam.length
    on = (places >= 0) & (places <= length)
    shapes = amplitude * np.sin(k[:, None, None] * places) * on
    rest = -np.sum(forces * shapes, axis=1) / (beam.EI * k[:, None] ** 4)
    curvature = -amplitude * k**2 * np.sin(k * x)
    slope = -amplitude * k**3 * np.cos(k * x)
    moment: Array = np.sum(forces * moment_line(length, x, places), axis=0) + beam.EI * curvature @ (q - rest)
    shear: Array = np.sum(forces * shear_line(length, x, places), axis=0) + beam.EI * slope @ (q - rest)
    return moment, shear


def en_1990_cut_off(beam: Beam) -> float:
    """EN 1990, A2.4.4.2.1 (4): the largest of 30 Hz, 1.5 f1 and f3 [Hz]."""
    f1 = float(beam.omega[0]) / (2 * math.pi)
    return max(30.0, 1.5 * f1, 9 * f1)


def low_passed(y: Array, cut_off: float, interval: float) -> Array:
    """A history behind scipy's digital Butterworth filter of fourth order."""
    from scipy.signal import butter, sosfilt

    filtered: Array = sosfilt(butter(4, cut_off, fs=1 / interval, output="sos"), y)
    return filtered
