"""Takes many scenarios through the lanes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from tbi_cli.integrator import kernel_cache
from tbi_cli.integrator.arrays import (
    LANES,
    LEVEL_RAILS,
    Crossing,
    Topology,
    Work,
    lane_zeros,
    put_to_rest,
    work_space,
)
from tbi_cli.integrator.kernels import Call

# Steps in one call of the kernel: some tens of milliseconds, after which a stop is noticed.
_STEPS_PER_CALL = 16384
_SAMPLES_RECORDED_PER_CALL = 512


class StoppedError(Exception):
    """The integration was told to stop before its end."""


@dataclass
class Reduced:
    """Reductions over the samples of each scenario: arrays of shape (channels, scenarios)."""

    square_sum: NDArray[np.float64]
    maximum: NDArray[np.float64]
    minimum: NDArray[np.float64]
    step_of_maximum: NDArray[np.float64]
    step_of_minimum: NDArray[np.float64]
    failed_at: NDArray[np.float64]  # sample by which a scenario was found not finite; NaN where it never was
    histories: dict[int, NDArray[np.float64]] = field(default_factory=dict)  # (channels kept, samples kept)
    kernel_calls: int = 0


def integrate(
    topology: Topology,
    crossing: Crossing,
    last: NDArray[np.int64],
    substeps: int,
    *,
    every: NDArray[np.int64] | None = None,
    rails: NDArray[np.float64] = LEVEL_RAILS,
    stopped: Callable[[], bool] = lambda: False,
) -> Reduced:
    """Integrates each scenario from rest over its samples 0 .. last and reduces its channels.

    `crossing` has the scenarios in its last axis.  With `every`, each scenario's history keeps every so many
    samples.  `rails` (intervals, 3, 4) are all that any scenario has, see `rails`.  A scenario whose
    state stops being finite ends there; the others go on.  A scenario's numbers do not depend on which others
    there are.  Raises StoppedError soon after `stopped()` turns true.
    """
    scenarios, channels = len(last), topology.channel.size
    nan = np.full((channels, scenarios), np.nan)
    result = Reduced(nan, nan.copy(), nan.copy(), nan.copy(), nan.copy(), np.full(scenarios, np.nan))
    kept = topology.history.size if every is not None else 0
    if every is not None:
        result.histories = {s: np.empty((kept, last[s] // every[s] + 1)) for s in range(scenarios)}

    most = _SAMPLES_RECORDED_PER_CALL if kept else max(1, _STEPS_PER_CALL // substeps)
    record = lane_zeros(most if kept else 0, kept)
    lanes = Crossing(*(lane_zeros(len(rows)) for rows in crossing))
    work = work_space(topology, rails)
    advance = _kernel(topology, lanes, work, substeps, record)
    order = np.argsort(
        -last, kind="stable"
    )  # like lengths side by side: they enter and leave the bridge together
    for first in range(0, scenarios, LANES):
        group = order[first : first + LANES]
        # A lane with nothing to do repeats the shortest scenario, unseen.
        filled = np.concatenate([group, np.full(LANES - len(group), group[-1])])
        for rows, values in zip(lanes, crossing, strict=True):
            rows[:] = values[:, filled]
        put_to_rest(work)
        taken, ending = 0, last[group] + 1
        busy = np.ones(len(group), dtype=bool)
        while busy.any():
            if stopped():
                raise StoppedError
            samples = min(int(ending[busy].min()) - taken, most)
            advance(samples)
            result.kernel_calls += 1
            finite = np.asarray(np.isfinite(work.state).all(axis=0))
            for lane in np.flatnonzero(busy).tolist():
                scenario = int(group[lane])
                if every is not None:
                    _keep(result.histories[scenario], record[:samples, :, lane], taken, every[scenario])
                if not finite[lane]:
                    result.failed_at[scenario] = taken + samples
                elif taken + samples == ending[lane]:
                    reduced = work.reduced[:, lane].reshape(channels, 5).T
                    (
                        result.square_sum[:, scenario],
                        result.maximum[:, scenario],
                        result.minimum[:, scenario],
                        result.step_of_maximum[:, scenario],
                        result.step_of_minimum[:, scenario],
                    ) = reduced
                else:
                    continue
                busy[lane] = False
            taken = taken + samples
    return result


def _kernel(
    topology: Topology, crossing: Crossing, work: Work, substeps: int, record: NDArray[np.float64]
) -> Call:
    """What takes so many samples of these lanes."""
    if len(crossing.exact):
        return kernel_cache.call("advance_exactly", topology, crossing, work, record)
    name = "advance_forces" if topology.forces else "advance"
    return kernel_cache.call(name, topology, crossing, work, substeps, record)


def _keep(history: NDArray[np.float64], samples: NDArray[np.float64], first: int, every: int) -> None:
    """Copies the samples (numbers first, first + 1, ..) that are multiples of `every` to their places."""
    skip = -first % every
    chosen = samples[skip::every]
    start = (first + skip) // every
    history[:, start : start + len(chosen)] = chosen.T
