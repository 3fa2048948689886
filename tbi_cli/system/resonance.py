"""Where the repetition of axles can bring a bridge into resonance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tbi_cli.case import Case, Consist, FullTrain, HslmA, RigidBeam
from tbi_cli.system.assembly import System, build_system
from tbi_cli.system.bridge import natural_frequencies
from tbi_cli.system.trains import SIDES

Array = NDArray[np.float64]

# The largest i of v = f_j D/i: beyond it a mode swings so often between two bogies that nothing builds up.
_MOST_PARTS = 6
# The finest part of a spectrum's own period, the whole length of the train, at which it is looked at.
_SAMPLES = 8
# How strong a wave of the spectrum is, and what its resonance would come to beside the strongest.
_STRONG, _FELT = 0.15, 0.1
_PIECE = 1 << 20  # numbers at once


@dataclass(frozen=True)
class Wave:
    """A wavelength (m) with which axles are in step, and the share of the weight that is.

    `width` is how much longer or shorter, relative to it, a wave is that half of the axles' length takes out
    of step: half of the way to the first zero of sin x/x.
    """

    length: float
    share: float
    width: float


def spectrum(positions: Array, loads: Array, wavelengths: Array) -> Array:
    """The share |sum P exp(2 pi i x/lambda)| / sum P of the loads that is in step with waves.

    EN 1991-2, annex E, (E.4), without damping; positions and wavelengths in m.
    """
    total = float(np.sum(loads))
    found = np.empty(len(wavelengths))
    at_once = max(1, _PIECE // len(positions))
    for first in range(0, len(wavelengths), at_once):
        phase = 2 * np.pi * positions / wavelengths[first : first + at_once, None]
        found[first : first + at_once] = np.abs(np.exp(1j * phase) @ loads) / total
    return found


def waves(positions: Array, loads: Array, shortest: float, longest: float) -> list[Wave]:
    """The peaks of the spectrum between two wavelengths that stand for a quarter of the weight or more."""
    length = float(np.ptp(positions))
    if length == 0 or np.sum(loads) <= 0:
        return []
    step = 1 / (_SAMPLES * length)
    low, high = max(1 / longest, 0.5 / length), 1 / shortest
    if high <= low:
        return []
    numbers = np.arange(low - step, high + 2 * step, step)  # waves in a metre
    numbers = numbers[numbers > 0.25 / length]
    values = spectrum(positions, loads, 1 / numbers)
    left, mid, right = values[:-2], values[1:-1], values[2:]
    top = np.flatnonzero((mid >= left) & (mid > right) & (mid >= _STRONG))
    found = []
    for k in top.tolist():
        bend = left[k] - 2 * mid[k] + right[k]
        number = numbers[k + 1] + step * 0.5 * (left[k] - right[k]) / bend
        found.append(Wave(float(1 / number), float(mid[k]), float(0.5 / (number * length))))
    return found


@dataclass(frozen=True)
class Resonance:
    """A speed (m/s) at which axles are in step with mode `mode` of the beam on a side: v = f_j lambda.

    A peak is about as wide as `width`, relative to the speed, to either side.
    """

    side: str
    mode: int
    wave: Wave
    speed: float
    width: float


def resonances(case: Case, slowest: float, fastest: float) -> list[Resonance]:
    """The speeds of resonance between two speeds (m/s) of the train and bridge of a case without sweep.

    They are those of the waves in which a quarter or more of the axles' weight is in step.  A wave shakes
    mode j the less the shorter it is beside the mode's own, 2 L/j: those that come to less than a tenth of
    the strongest are left out.
    """
    system = build_system(case)
    found = []
    for b, side in enumerate(SIDES[: len(system.beams)]):
        beam = system.beams[b]
        positions, loads = _loads(system, b)
        frequencies = beam.omega / (2 * np.pi)
        known = waves(positions, loads, slowest / float(frequencies[-1]), fastest / float(frequencies[0]))
        for j, frequency in enumerate(frequencies.tolist(), 1):
            ratio = float(beam.damping[j - 1] / (2 * beam.omega[j - 1]))
            for wave in known:
                if slowest <= frequency * wave.length <= fastest:
                    width = max(wave.width, ratio)
                    felt = wave.share * min(1.0, j * wave.length / (2 * beam.length))
                    found.append((felt, Resonance(side, j, wave, frequency * wave.length, width)))
    most = max((felt for felt, _ in found), default=0.0)
    return [resonance for felt, resonance in found if felt >= _FELT * most]


def _loads(system: System, beam: int) -> tuple[Array, Array]:
    """Positions (m) and static loads (N) of the wheels on a beam."""
    on = system.wheel_beam == beam
    return system.axle_offsets[system.wheel_axle[on]], system.wheel_load[on]


def repeats_after(case: Case) -> tuple[float, ...]:
    """The ways (m) after which the axles of a train repeat themselves; of one vehicle, first axle to last."""
    train = case.train
    if isinstance(train, Consist):
        return tuple({group.spacing for group in train.consist if group.count > 1})
    if isinstance(train, HslmA):
        return (train.coach_length,)
    if isinstance(train, FullTrain):
        arms = train.geometry
        return (arms.l_b1 + arms.l_w1 + arms.l_b2 + arms.l_w4,)
    return (train.support_distance,) if isinstance(train, RigidBeam) else ()


def resonant_speeds(case: Case) -> list[tuple[str, int, int, float]]:
    """Side of the beam, mode j, part i and speed (m/s) of every v = f_j D/i of a case, the fastest first."""
    found = []
    for side, beam in (("right", case.bridge.right), ("left", case.bridge.left)):
        if beam is None:
            continue
        for j, omega in enumerate(natural_frequencies(case.bridge, beam), 1):
            for way in repeats_after(case):
                for i in range(1, _MOST_PARTS + 1):
                    found.append((side, j, i, float(omega) * way / (2 * np.pi * i)))
    return sorted(found, key=lambda speed: -speed[3])
