"""Where the repetition of axles can bring a bridge into resonance.

A force P at x behind the first adds P exp(2 pi i x/lambda) to the vibration that the train leaves in a mode
of frequency f_j, lambda = v/f_j being the way in one of its periods.  So a train is known by its spectrum
|sum P exp(2 pi i x/lambda)|, and resonance is where that peaks: v = f_j lambda.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tbi_cli.case import Case, Consist, FullTrain, HslmA, MovingLoad, RigidBeam
from tbi_cli.system.assembly import System, build_system
from tbi_cli.system.bridge import natural_frequencies
from tbi_cli.system.trains import SIDES

Array = NDArray[np.float64]

# The largest i of v = f_j D/i: beyond it a mode swings so often between two bogies that nothing builds up.
_MOST_PARTS = 6
# At so many points in each of its lobes, which are 1/length wide, a spectrum is looked at.
_SAMPLES = 16
# What share of the weight a wave stands for at least, and its resonance of the strongest one.
_STRONG, _FELT = 0.15, 0.1
# A list of forces repeats itself after the longest wave with such a share, if it does so often enough.
_REPEATS, _OFTEN = 0.4, 3
_MOST_WAVES = 100
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
    """The peaks of the spectrum between two wavelengths (m) that hold enough of the weight, longest first."""
    length = float(np.ptp(positions))
    if length == 0 or np.sum(loads) <= 0:
        return []
    step = 1 / (_SAMPLES * length)
    # Waves in a metre. A wave as long as the train or longer is no repetition.
    numbers = np.arange(max(1 / longest - step, 0.5 / length), 1 / shortest + 2 * step, step)
    if len(numbers) < 3:
        return []
    values = spectrum(positions, loads, 1 / numbers)
    left, mid, right = values[:-2], values[1:-1], values[2:]
    tops = numbers[1:-1][(mid >= left) & (mid > right) & (mid >= 0.9 * _STRONG)]
    # Parabolas through the top and its neighbours, from closer and closer, settle it.
    for apart in (step, step / 16, step / 256):
        left, mid, right = (spectrum(positions, loads, 1 / (tops + by)) for by in (-apart, 0.0, apart))
        tops = tops + apart * np.clip(0.5 * (left - right) / (left - 2 * mid + right), -1, 1)
    shares = spectrum(positions, loads, 1 / tops)
    return [
        Wave(1 / number, share, 0.5 / (number * length))
        for number, share in zip(tops.tolist(), shares.tolist(), strict=True)
        if share >= _STRONG and shortest <= 1 / number <= longest
    ]


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

    They are those of the waves in which 15 % or more of the axles' weight are in step; D, D/2, D/3, ... of
    equal vehicles of length D are among them.  A wave shakes mode j the less the shorter it is beside the
    mode's own, 2 L/j: those that come to less than a tenth of the strongest are left out.
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
    """The ways (m) after which the axles of a train repeat themselves; of one vehicle, first axle to last.

    Of a list of forces it is the longest wave of its spectrum that is strong; none where there is no such.
    """
    train = case.train
    if isinstance(train, Consist):
        return tuple({group.spacing for group in train.consist if group.count > 1})
    if isinstance(train, HslmA):
        return (train.coach_length,)
    if isinstance(train, FullTrain):
        arms = train.geometry
        return (arms.l_b1 + arms.l_w1 + arms.l_b2 + arms.l_w4,)
    if isinstance(train, MovingLoad):
        positions, loads = np.array(train.positions), np.array(train.forces)
        longest = float(positions[-1]) / _OFTEN
        known = waves(positions, loads, longest / _MOST_WAVES, longest) if longest > 0 else []
        return tuple(wave.length for wave in known if wave.share >= _REPEATS)[:1]
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
