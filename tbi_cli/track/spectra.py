"""Spectra of track irregularity: one-sided power spectral densities over the circular wavenumber.

S(W) has the unit m^2/(rad/m); the variance of a profile with wavelengths from l1 to l2 is the integral of S
from W = 2 pi/l2 to 2 pi/l1.  `vertical` is the spectrum of the profile of a rail, or of the mean of both;
`cross_level` that of the height of the right rail over the left one.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Spectrum:
    """The spectrum of a kind of track: its title, and the densities (m^2/(rad/m)) at wavenumbers (rad/m)."""

    title: str
    vertical: Callable[[Array], Array]
    cross_level: Callable[[Array], Array]


def german(roughness: float, title: str) -> Spectrum:
    """The German spectra of ORE (later ERRI) question B 176.

        S_v = A W_c^2 / ((W^2 + W_r^2) (W^2 + W_c^2))
        S_c = 4 A W_c^2 W^2 / ((W^2 + W_r^2) (W^2 + W_c^2) (W^2 + W_s^2))

    with W_c = 0.8246, W_r = 0.0206, W_s = 0.4380 rad/m; A = `roughness` = 4.032e-7 m rad for low and 1.080e-6
    m rad for high disturbance.  As the source gives it, S_c is that of the cross-level's angle, S_v's A over
    b^2 with half the distance of the running circles b; here it is the height 2 b times the angle, which
    leaves the factor 4 and no b.  One-sided.  Valid from 3 to 150 m.

    Source: ORE, question B 176, Bogies with steered or steering wheelsets, report 1, Utrecht 1989; in this
    form H. Claus, W. Schiehlen, Modeling and simulation of railway bogie structural vibrations, Vehicle
    System Dynamics 29 (1998) S1, 538-552; the band with which W. W. Guo, H. Xia, G. De Roeck, K. Liu use it,
    Computers & Structures 112-113 (2012) 205-216.
    """
    corner, low, cross = 0.8246**2, 0.0206**2, 0.4380**2

    def vertical(wavenumber: Array) -> Array:
        squared = wavenumber**2
        density: Array = roughness * corner / ((squared + low) * (squared + corner))
        return density

    def cross_level(wavenumber: Array) -> Array:
        squared = wavenumber**2
        return 4 * vertical(wavenumber) * squared / (squared + cross)

    return Spectrum(title, vertical, cross_level)


def fra(roughness: float, cross: float, title: str) -> Spectrum:
    """The spectra of the classes 1 to 6 of the Federal Railroad Administration (USA).

        S_v = k A W_c^2 / (W^2 (W^2 + W_c^2))
        S_c = 4 k A W_c^2 / ((W^2 + W_c^2) (W^2 + W_s^2))

    with k = 0.25 and W_c = 0.8245 rad/m.  `roughness` A_v (cm^2 rad/m) is 1.2107, 1.0181, 0.6816, 0.5376,
    0.2095, 0.0339 and `cross` W_s (rad/m) 0.6046, 0.9308, 0.8520, 1.1312, 0.8209, 0.4380 for the classes 1 to
    6; the higher the class, the better the track.  One-sided.  Valid from 5 to 1000 ft (1.524 to 304.8 m).

    Source: A. Hamid, K. Rasmussen, M. Baluja, T.-L. Yang, Analytical descriptions of track geometry
    variations, FRA/ORD-83/03.1, Washington 1983; in this form R. H. Fries, B. M. Coffey, A state-space
    approach to the synthesis of random vertical and crosslevel rail irregularities, J. Dyn. Sys., Meas.,
    Control 112 (1990) 83-87.
    """
    corner, amplitude = 0.8245**2, 0.25 * roughness * 1e-4

    def vertical(wavenumber: Array) -> Array:
        squared = wavenumber**2
        density: Array = amplitude * corner / (squared * (squared + corner))
        return density

    def cross_level(wavenumber: Array) -> Array:
        squared = wavenumber**2
        density: Array = 4 * amplitude * corner / ((squared + corner) * (squared + cross**2))
        return density

    return Spectrum(title, vertical, cross_level)


_FRA = (
    (1.2107, 0.6046),
    (1.0181, 0.9308),
    (0.6816, 0.8520),
    (0.5376, 1.1312),
    (0.2095, 0.8209),
    (0.0339, 0.4380),
)

#: The spectra by their names in a case file.
SPECTRA = {
    "german-low": german(4.032e-7, "German spectrum, low disturbance"),
    "german-high": german(1.080e-6, "German spectrum, high disturbance"),
    **{f"fra-{k}": fra(A, cross, f"FRA class {k}") for k, (A, cross) in enumerate(_FRA, 1)},
}
