"""The rails that a study ran on, and their spectrum beside the one that they were made from."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from tbi_cli.case import Case, Random, Track
from tbi_cli.case.track import INTERVALS_IN_WAVE
from tbi_cli.report.ensembles import seeds_of
from tbi_cli.report.plot import Array, Axis, Curve, Mark, Panel, Plot
from tbi_cli.report.study import Study
from tbi_cli.track import SPECTRA, rail_profile

PLACE = Axis("place along the track", "m")
LEVEL = Axis("level of the rail", "m")
WAVELENGTH = Axis("wavelength", "m", logarithmic=True)
DENSITY = Axis("spectral density", "m2/(rad/m)", logarithmic=True)
_POINTS = 4000
_MOST_SEEDS = 40


def track_figures(study: Study, select: Mapping[str, int]) -> Iterator[Plot]:
    """One figure: both rails along the track; with random rails, their spectrum too."""
    case = study.case_at(dict(select))
    if case is None or case.track is None:
        return
    panels = [_rails(case, case.track)]
    random = case.track.irregularity.random
    sentences = [study.title, "Thin lines: the ends of the bridge"]
    if random is not None:
        cases = [case]
        seeds = seeds_of(study)
        if seeds is not None and seeds.name not in select:
            members = range(min(len(seeds.values), _MOST_SEEDS))
            at = [study.case_at({**select, seeds.name: member}) for member in members]
            cases = [found for found in at if found is not None]
        panels.append(_spectrum(random, cases))
        what = "its periodogram" if len(cases) == 1 else f"the mean of {len(cases)} seeds' periodograms"
        sentences += [f"{SPECTRA[random.spectrum].title}, seed {random.seed}", f"Right rail: {what}"]
    yield Plot(
        name=f"{study.name}-track",
        heading="Irregularity of the rails",
        caption=". ".join(sentences) + ".",
        panels=tuple(panels),
        study=study.name,
    )


def _rails(case: Case, track: Track) -> Panel:
    profile = rail_profile(track, case.bridge.length)
    x = np.linspace(profile.x[0], profile.x[-1], _POINTS)
    right, left = profile.level(x)
    curves = [Curve("right rail", x, right, 0)]
    if case.bridge.left is not None and not np.array_equal(right, left):
        curves.append(Curve("left rail", x, left, 1))
    bridge = Mark("bridge", ((0.0, ""), (case.bridge.length, "")))
    return Panel("along the track", PLACE, LEVEL, tuple(curves), marks=(bridge,))


def _spectrum(random: Random, cases: list[Case]) -> Panel:
    """Periodograms between the tapers, under Hann's window, and the density that was asked for."""
    found = [_periodogram(random, case) for case in cases]
    wavenumber = found[0][0]
    mean: Array = np.mean([density for _, density in found], axis=0)
    kept = (wavenumber >= 2 * np.pi / random.longest_wavelength) & (
        wavenumber <= 2 * np.pi / random.shortest_wavelength
    )
    band = np.geomspace(2 * np.pi / random.longest_wavelength, 2 * np.pi / random.shortest_wavelength, 200)
    spectrum = SPECTRA[random.spectrum]
    asked = spectrum.vertical(band)
    if random.coherence == "cross-level":
        asked = asked + spectrum.cross_level(band) / 4
    curves = (
        Curve("the profile's own", 2 * np.pi / wavenumber[kept][::-1], mean[kept][::-1], 0),
        Curve("asked for", 2 * np.pi / band[::-1], asked[::-1], 1),
    )
    return Panel("spectrum of the right rail", WAVELENGTH, DENSITY, curves)


def _periodogram(random: Random, case: Case) -> tuple[Array, Array]:
    """Wavenumbers (rad/m) and the one-sided density (m2/(rad/m)) of the right rail between its tapers."""
    assert case.track is not None
    profile = rail_profile(case.track, case.bridge.length)
    reach, spacing = 0.75 * case.track.approach, random.shortest_wavelength / INTERVALS_IN_WAVE
    count = int((case.bridge.length + 2 * reach) / spacing)
    x: Array = -reach + spacing * np.arange(count, dtype=np.float64)
    window = np.hanning(count)
    lines = np.abs(np.fft.rfft(window * profile.level(x)[0])) ** 2
    density: Array = lines * spacing / np.sum(window**2) / np.pi
    wavenumber: Array = 2 * np.pi * np.arange(len(lines), dtype=np.float64) / (count * spacing)
    return wavenumber[1:], density[1:]
