"""When a crossing is sampled, and in how many steps: sampling interval, substeps, window, stability."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from tbi_cli.case import Case
from tbi_cli.system.assembly import Matrix, System, build_system, equal_coaches

# The classical Runge-Kutta method multiplies a mode exp(lambda t) by R(z) = 1 + z + z^2/2 + z^3/6 + z^4/24 in
# a step, z = lambda h.  |R| <= 1 up to 2.785 on the real axis and 2.828 on the imaginary one; every z with a
# negative real part inside the circle of this radius is stable too.
_SAFE_RADIUS = 2.6
# `substeps: auto` keeps |lambda| h below this for the fastest mode, whose phase is then wrong by less than
# z^4/120 = 7e-5 of a radian per radian.
_ACCURATE_RADIUS = 0.3
# Wheels that lift off make kinks inside of steps: forces of impacts are good to 1 % with this one (docs).
_ACCURATE_RADIUS_OF_CONTACT = 0.15
_SAMPLES_ON_BRIDGE = 4000
_SAMPLES_PER_PERIOD = 60
_LONGEST_INTERVAL = 1e-3


# The method `exact` takes a step for each radian of a sampling interval, once: beyond so many rounding shows.
_MOST_SWING = 1e5
# Of one scenario: days on one processor; and so that the sums over a grid are whole numbers of 64 bits.
_MOST_STEPS = 10**12
# A low-pass filter needs so many samples in a period of its cut-off.
_SAMPLES_PER_CUT_OFF = 4


class TimeGridError(ValueError):
    """A time grid that cannot be; the text says what the limit is, `key` what to change."""

    key = "solver.sampling"


class UnstableStepError(TimeGridError):
    """A step outside the stability region of the Runge-Kutta method."""

    key = "solver.substeps"


class TooManyStepsError(TimeGridError):
    """A scenario that would not come to its end."""

    key = "solver"


@dataclass(frozen=True)
class TimeGrid:
    """Samples at t = start, start + sampling, .., `last` of them after the first.

    Between two samples there are `substeps` Runge-Kutta steps of length h.  A history keeps the first sample
    and every `stride`th from it.  The first axle enters at t = 0.
    """

    sampling: float
    substeps: int
    last: int
    start: float = 0.0
    stride: int = 1

    @property
    def h(self) -> float:
        """Length of a Runge-Kutta step (s)."""
        return self.sampling / self.substeps

    @property
    def steps(self) -> int:
        """Runge-Kutta steps of the whole window."""
        return self.last * self.substeps


@dataclass(frozen=True)
class Pace:
    """What the time grid of a crossing needs to know of the system.

    way: of the last axle's exit, from the first one's entry (m); shortest_period: of the beams' modes, and of
    wheelsets on their contact springs (s); fastest: an upper bound of |lambda| (1/s); cut_off: the highest of
    the beams' low-pass filters (Hz), 0 for none.  Scenarios of one `shape`, coordinates and axles of every
    vehicle, and as many modes can be solved side by side.
    """

    way: float
    shortest_period: float
    fastest: float
    cut_off: float
    shape: tuple[tuple[int, int], ...]


def pace_of(system: System) -> Pace:
    """The pace of a system."""
    return Pace(
        way=system.length + system.axle_distance,
        shortest_period=2 * math.pi / max(contact_rate(system), *(float(b.omega[-1]) for b in system.beams)),
        fastest=fastest_rate(system),
        cut_off=max(beam.low_pass for beam in system.beams),
        shape=tuple(
            (len(one.coordinates), len(one.axle_offsets))
            for one in ([coach.system for coach in system.coaches] or [system])
        ),
    )


def time_grid(case: Case, pace: Pace) -> TimeGrid:
    """The time grid of a case without sweep (model.md, Integration).

    On irregular rails it begins with the first axle at the beginning of the approach.  Raises TimeGridError
    where the substeps asked for cannot be stable, the samples are too few for a low-pass filter, or the steps
    are too many.
    """
    crossing = pace.way / case.velocity
    shortest, fastest, approach = pace.shortest_period, pace.fastest, 0.0
    if case.track is not None:
        approach = case.track.approach / case.velocity
        wave = case.track.shortest_wave / case.velocity
        shortest, fastest = min(shortest, wave), max(fastest, 2 * math.pi / wave)
    fine = min(_LONGEST_INTERVAL, crossing / _SAMPLES_ON_BRIDGE, shortest / _SAMPLES_PER_PERIOD)
    if pace.cut_off:
        widest = 1 / (_SAMPLES_PER_CUT_OFF * pace.cut_off)
        fine = min(fine, widest)
        if case.solver.sampling != "auto" and case.solver.sampling > widest * (1 + 1e-9):
            raise TimeGridError(
                f"expected at most {_floor(widest)} s, {_SAMPLES_PER_CUT_OFF} samples in a period of "
                f"{pace.cut_off:.4g} Hz (bridge.low_pass), got {case.solver.sampling:.4g} s"
            )
    sampling = fine if case.solver.sampling == "auto" else case.solver.sampling
    every = case.output.histories.every
    if case.solver.sampling == "auto" and every is not None:
        # The samples that a history keeps are `every` apart, so that many whole intervals make one of it.
        sampling = every / math.ceil(every / fine * (1 - 1e-12))
    if case.solver.method == "exact":
        substeps = 1
        swing = max(fastest, case.bridge.modes * math.pi * case.velocity / case.bridge.length)
        if sampling * swing > _MOST_SWING:
            raise TimeGridError(
                f"expected at most {_MOST_SWING / swing:.4g} s for the method exact, {_MOST_SWING:g} radians "
                f"of the fastest mode, got {sampling:.4g} s"
            )
    elif case.solver.substeps == "auto":
        radius = _ACCURATE_RADIUS_OF_CONTACT if case.contact.model == "hertz" else _ACCURATE_RADIUS
        substeps = max(math.ceil(sampling * fastest / radius - 1e-9), 1)
    else:
        substeps = case.solver.substeps
        if sampling / substeps * pace.fastest > _SAFE_RADIUS:
            _refuse_unstable(build_system(case), sampling, substeps)
    window = approach + case.solver.duration * crossing
    last = math.floor(window / sampling + 1e-9)
    if last < 1:
        raise TimeGridError(f"expected at most {window:.4g} s, the whole window, got {sampling:.4g} s")
    if last * substeps > _MOST_STEPS:
        raise TooManyStepsError(
            f"expected at most {_MOST_STEPS:.0e} steps in one scenario, got {float(last):.3g} samples of "
            f"{sampling:.3g} s with {float(substeps):.3g} steps in each"
        )
    # One that is longer than the window keeps the first sample alone.
    stride = 1 if every is None else round(min(every / sampling, float(last + 1)))
    return TimeGrid(sampling, substeps, last, 0.0 - approach, max(stride, 1))


def contact_rate(system: System) -> float:
    """The fastest circular frequency (rad/s) of a wheelset on its contact springs; 0 without any.

    The springs of one axle share its wheelset: sqrt(k_i k_j) g_i M^-1 g_j over them has the same eigenvalues.
    """
    if not system.unilateral:
        return 0.0
    found = 0.0
    for one, _ in equal_coaches(system):
        for axle in range(len(one.axle_offsets)):
            wheels = one.wheel_axle == axle
            rows = np.sqrt(one.wheel_stiffness[wheels])[:, None] * one.wheel_rows[wheels]
            found = max(found, float(np.linalg.eigvalsh((rows / one.M) @ rows.T)[-1]))
    return math.sqrt(found)


def fastest_rate(system: System) -> float:
    """An upper bound of |lambda| (1/s) over all eigenvalues, wherever the wheels stand.

    A mode of lambda^2 + d lambda + k = 0 with k <= k_max and d <= d_max has |lambda| <= d/2 + sqrt(d^2/4 +
    k). The bounds are the largest eigenvalues of K and C scaled by the masses, wheels at antinodes of every
    mode.
    """
    stiffness, damping = _worst_matrices(system)
    k = float(np.linalg.eigvalsh(stiffness)[-1])
    d = float(np.linalg.eigvalsh(damping)[-1])
    return d / 2 + math.sqrt(d * d / 4 + k)


def _worst_matrices(system: System, position: float | None = None) -> tuple[Matrix, Matrix]:
    """Mass-scaled stiffness and damping of vehicle and bridge together, symmetric.

    With the first axle at `position` (m), or with every wheel at an antinode of all modes of its beam.  Equal
    vehicles of a train move alike and stand at the same place: their largest eigenvalue together, and one of
    them, pressing on the beam as if they were that many, has it too.
    """
    n = len(system.beams[0].omega)
    groups = equal_coaches(system)
    nv = sum(len(one.coordinates) for one, _ in groups)
    size = nv + n * len(system.beams)
    K, C = np.zeros((size, size)), np.zeros((size, size))
    for b, beam in enumerate(system.beams):
        rows = np.arange(nv + b * n, nv + (b + 1) * n)
        K[rows, rows] = beam.omega**2
        C[rows, rows] = beam.damping
    first = 0
    for one, count in groups:
        own = slice(first, first + len(one.coordinates))
        first = own.stop
        scale = 1 / np.sqrt(one.M)
        K[own, own] = one.K * np.outer(scale, scale)
        C[own, own] = one.C * np.outer(scale, scale)
        for wheel, row in enumerate(one.wheel_rows):
            if not (one.wheel_stiffness[wheel] or one.wheel_damping[wheel]):
                continue
            g = np.zeros(size)
            modes = slice(nv + one.wheel_beam[wheel] * n, nv + (one.wheel_beam[wheel] + 1) * n)
            beam = one.beams[one.wheel_beam[wheel]]
            if position is None:
                shape = np.ones(n)
            else:
                x = position - one.axle_offsets[one.wheel_axle[wheel]]
                shape = np.sin(np.arange(1, n + 1) * np.pi * x / beam.length) * (0 <= x <= beam.length)
            free = np.zeros(size)
            free[own] = row * scale
            g[own], g[modes] = free[own], -shape * math.sqrt(beam.gain * count)
            # K already holds the wheel's spring against rigid track.
            K += one.wheel_stiffness[wheel] * (np.outer(g, g) - np.outer(free, free))
            C += one.wheel_damping[wheel] * (np.outer(g, g) - np.outer(free, free))
    return K, C


def _refuse_unstable(system: System, sampling: float, substeps: int) -> None:
    """Raises UnstableStepError if the step is outside the stability region at some place of the train."""
    h = sampling / substeps
    end = system.length + max(one.axle_distance for one, _ in equal_coaches(system))
    eigenvalues = np.concatenate(
        [_eigenvalues(*_worst_matrices(system, position)) for position in np.linspace(-1.0, end, 25)]
    )
    if _amplification(eigenvalues * h) <= 1 + 1e-9:
        return
    low, high = 0.0, h
    for _ in range(50):
        middle = (low + high) / 2
        low, high = (middle, high) if _amplification(eigenvalues * middle) <= 1 + 1e-9 else (low, middle)
    needed = math.ceil(sampling / low)
    raise UnstableStepError(
        f"expected a stable step: at most {_floor(low)} s for this train and bridge, "
        f"got {h:.4g} s (sampling {sampling:.4g} s in {substeps} substeps); "
        f"use at least {needed} substeps, or auto"
    )


def _floor(limit: float) -> str:
    """A limit to four digits, itself within it."""
    unit = 10.0 ** (math.floor(math.log10(limit)) - 3)
    return f"{math.floor(limit / unit * (1 + 1e-12)) * unit:.4g}"


def _eigenvalues(K: Matrix, C: Matrix) -> np.ndarray:
    size = len(K)
    return np.linalg.eigvals(np.block([[np.zeros((size, size)), np.eye(size)], [-K, -C]]))


def _amplification(z: np.ndarray) -> float:
    """Largest |R(z)| of the Runge-Kutta method over the modes that do not grow by themselves."""
    # Free motions (no creep forces: lateral and yaw of the whole vehicle) sit at zero to rounding.
    z = z[(z.real <= 0) & (np.abs(z) > 1e-6)]
    return float(np.max(np.abs(1 + z * (1 + z / 2 * (1 + z / 3 * (1 + z / 4)))), initial=0.0))
