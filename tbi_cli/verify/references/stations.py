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


def counted_by_en_1990(beam: Beam) -> float:
    """EN 1990, A2.4.4.2.1 (4): the largest of 30 Hz, 1.5 f1 and f3 [Hz]; the beam has three modes."""
    f1, _, f3 = beam.omega[:3] / (2 * math.pi)
    return max(30.0, 1.5 * float(f1), float(f3))


def modal_shares(y: Array, x: Array, beam: Beam, modes: Array, times: Array) -> Array:
    """How much of the free vibration of some modes (n, of bool) in x (nt,) is in y (nt,), mode by mode.

    Both are fitted by decaying cosines and sines of the beam's natural frequencies, over times [s] (nt,).
    """
    decay = (beam.c / (2 * beam.mu))[modes]
    damped = np.sqrt(beam.omega[modes] ** 2 - decay**2)
    swing = np.exp((-decay + 1j * damped) * (times - times[0])[:, None])
    basis = np.hstack([swing.real, swing.imag])
    sizes = []
    for signal in (y, x):
        found = np.linalg.lstsq(basis, signal, rcond=None)[0]
        sizes.append(np.hypot(*np.split(found, 2)))
    shares: Array = sizes[0] / sizes[1]
    return shares


def low_passed(y: Array, cut_off: float, interval: float) -> Array:
    """A history behind scipy's digital Butterworth filter of fourth order."""
    from scipy.signal import butter, sosfilt

    filtered: Array = sosfilt(butter(4, cut_off, fs=1 / interval, output="sos"), y)
    return filtered
