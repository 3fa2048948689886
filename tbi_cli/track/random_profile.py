"""Random rails of a given spectrum: sums of many cosine waves with random phases.

Spectral representation (M. Shinozuka, C.-M. Jan, Digital simulation of random processes and its applications,
Journal of Sound and Vibration 25 (1972) 111-128):

    r(x) = sum_k sqrt(2 S(W_k) dW) cos(W_k x + phi_k),   W_k = k dW,

over the wavenumbers of the band, phi_k evenly spread over a turn.  Such a sum repeats itself after 2 pi/dW.
So the track is made in blocks, each with phases of its own, which fade into each other with weights whose
squares add up to one, so that variance and spectrum are the same everywhere.  The blocks lie where they lie
whatever bridge and approach there are: a seed makes the same rail at the same place.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from tbi_cli.case import Random
from tbi_cli.case.track import INTERVALS_IN_WAVE
from tbi_cli.track.profile import Array, RailProfile, chain
from tbi_cli.track.spectra import SPECTRA

Waves = tuple[Array, Array]  # level and slope
# A sum repeats itself after so many metres; twice, four times .. as many for long waves, which would be few
# in it, and for bands so narrow that few waves would be in them.
_PERIOD = 2048.0
_LEAST_WAVES = 6
_LEAST_LINES = 32
# Of the period: how far from its middle a block is there alone, and how far at all.
_ALONE, _REACH = 0.25, 0.5
_VERTICAL, _OTHER = 0, 1


def random_profile(random: Random, start: float, end: float) -> RailProfile:
    """The random rails from `start` to `end` (m) and a little beyond, before any taper."""
    shortest, longest = random.shortest_wavelength, random.longest_wavelength
    least = max(_LEAST_WAVES * longest, _LEAST_LINES / (1 / shortest - 1 / longest))
    period = _PERIOD
    while period < least:
        period *= 2
    points = 2
    while period / points > shortest / INTERVALS_IN_WAVE:
        points *= 2
    spacing = period / points
    numbers = np.arange(int(np.floor(start / spacing)), int(np.ceil(end / spacing)) + 1)
    x: Array = spacing * numbers.astype(np.float64)
    spectrum = SPECTRA[random.spectrum]

    def rail(density: Callable[[Array], Array], stream: int) -> Waves:
        level, slope = np.zeros(len(numbers)), np.zeros(len(numbers))
        for block, weight, growth in _blocks(x, period):
            waves, rise = _waves(random, density, (stream, block), period, points)
            # The sum is periodic: what lies before its beginning is found at its end.
            here, there = waves[numbers % points], rise[numbers % points]
            level += weight * here
            slope += weight * there + growth * here
        return level, slope

    right = left = rail(spectrum.vertical, _VERTICAL)
    if random.coherence == "independent":
        left = rail(spectrum.vertical, _OTHER)
    if random.coherence == "cross-level":
        cross = rail(spectrum.cross_level, _OTHER)
        mean = right
        right, left = ((mean[0] + side * cross[0] / 2, mean[1] + side * cross[1] / 2) for side in (1, -1))
    level, slope = np.array([right[0], left[0]]), np.array([right[1], left[1]])
    return chain(x, level, slope[:, :-1], slope[:, 1:])


def _blocks(x: Array, period: float) -> Iterator[tuple[int, Array, Array]]:
    """Number of each block that reaches into x (n,), with its weight there and the weight's derivative."""
    alone, fading = _ALONE * period, (_REACH - _ALONE) * period
    apart = (_ALONE + _REACH) * period
    first, last = (round(float(place) / apart) for place in (x[0], x[-1]))
    for block in range(first - 1, last + 2):
        away = x - block * apart
        u = np.clip((np.abs(away) - alone) / fading, 0.0, 1.0)
        angle = np.pi / 2 * u * u * (3 - 2 * u)
        weight: Array = np.where(u < 1, np.cos(angle), 0.0)
        if weight.any():
            turn = np.pi / 2 * 6 * u * (1 - u) / fading * np.sign(away)
            yield block, weight, -np.sin(angle) * turn


def _waves(
    random: Random, density: Callable[[Array], Array], which: tuple[int, int], period: float, points: int
) -> Waves:
    """Level and slope (points,) of the sum of waves of one block over one period, from x = 0."""
    stream, block = which
    step = 2 * np.pi / period
    first = int(np.ceil(2 * np.pi / random.longest_wavelength / step - 1e-9))
    last = int(np.floor(2 * np.pi / random.shortest_wavelength / step + 1e-9))
    wavenumber: Array = step * np.arange(first, last + 1, dtype=np.float64)
    amplitude = np.sqrt(2 * density(wavenumber) * step)
    # A bit generator's raw numbers are the same on every machine and in every version of numpy.
    seeds = (random.seed, stream, 2 * block if block >= 0 else -2 * block - 1)
    raw = np.random.PCG64(np.random.SeedSequence(seeds)).random_raw(last + 1)[first:]
    phase = 2 * np.pi * ((raw >> np.uint64(11)) * 2.0**-53)
    lines = np.zeros(points // 2 + 1, dtype=complex)
    lines[first : last + 1] = amplitude * np.exp(1j * phase) * (points / 2)
    level: Array = np.fft.irfft(lines, points)
    lines[first : last + 1] *= 1j * wavenumber
    slope: Array = np.fft.irfft(lines, points)
    return level, slope
