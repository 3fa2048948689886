"""Static deflection at mid-span under forces as they cross at crawling speed: influence lines."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from tbi_cli.verify.references.parameters import Array, Beam


def influence_line(beam: Beam, x: Array) -> Array:
    """Mid-span deflection [m/N] under a unit force at x [m]: exact, zero off the beam.

    x (3 L^2 - 4 x^2) / 48 EI for x <= L/2, and its mirror image.
    """
    L = beam.length
    near = np.minimum(x, L - x)
    line: Array = np.where(near > 0, near * (3 * L**2 - 4 * near**2) / (48 * beam.EI), 0.0)
    return line


def modal_influence_line(beam: Beam, x: Array) -> Array:
    """The same with the beam's n modes: sum of 2 L^3 / (EI (i pi)^4) sin(i pi / 2) sin(i pi x / L)."""
    L = beam.length
    line = np.zeros(np.shape(x))
    for i in range(1, beam.n + 1):
        flexibility = 2 * L**3 / (beam.EI * (i * math.pi) ** 4)
        line += flexibility * math.sin(i * math.pi / 2) * np.sin(i * math.pi * x / L)
    return np.where((x > 0) & (x < L), line, 0.0)


def static_deflection(
    beam: Beam, loads: Sequence[float], distances: Sequence[float], first: Array, exact: bool = False
) -> Array:
    """Mid-span deflection [m], negative downwards, under `loads` [N] each `distances` [m] behind the first.

    `first` (nt,): position of the first load [m]; `exact` takes the exact line, else the one with n modes.
    """
    line = influence_line if exact else modal_influence_line
    w = np.zeros(np.shape(first))
    for load, behind in zip(loads, distances, strict=True):
        w -= load * line(beam, first - behind)
    return w
