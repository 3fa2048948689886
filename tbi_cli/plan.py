"""Which scenarios are solved together, and in which order."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tbi_cli.integrator.arrays import LANES
from tbi_cli.scenarios import Scenarios
from tbi_cli.shards import deal
from tbi_cli.timegrid import TimeGridError, time_grid

# A batch ends at so many scenarios, at its share of all steps, or at so many bytes of histories.
_LARGEST_BATCH = 8 * LANES
_LEAST_BATCHES = 32
_HISTORY_BYTES = 128 * 2**20


@dataclass(frozen=True, eq=False)
class Plan:
    """What a run does: its batches, the costliest first.

    `steps` and `sizes` (n,) are the Runge-Kutta steps and the bytes of history of each scenario in the
    batches, else 0.
    """

    batches: list[NDArray[np.int64]]
    steps: NDArray[np.int64]
    sizes: NDArray[np.int64]


def make_plan(
    scenarios: Scenarios, wanted: NDArray[np.bool_], history_channels: int, every: float | None
) -> Plan:
    """Groups the wanted scenarios (n,) into batches of one structure and like length.

    Lanes of like length enter and leave the bridge together and end together, so that none idles.
    Raises RunError where a scenario's step cannot be stable.
    """
    costs = costs_of(scenarios, np.flatnonzero(wanted), history_channels, every)
    steps, sizes = np.where(wanted, costs.steps, 0), np.where(wanted, costs.sizes, 0)
    share = int(steps.sum()) // _LEAST_BATCHES
    batches: list[NDArray[np.int64]] = []
    for structure in np.unique(costs.structure[wanted]):
        members = np.flatnonzero(wanted & (costs.structure == structure))
        members = members[np.argsort(-steps[members], kind="stable")]
        batches += _cut(members, steps, sizes, share)
    batches.sort(key=lambda batch: -int(steps[batch].sum()))
    return Plan(batches, steps, sizes)


def joined(plans: Sequence[Plan]) -> Plan:
    """One plan for several grids, whose scenarios stand one behind the other."""
    ends = np.cumsum([len(plan.steps) for plan in plans])
    moved = [
        batch + (end - len(plan.steps))
        for plan, end in zip(plans, ends, strict=True)
        for batch in plan.batches
    ]
    steps, sizes = (np.concatenate([getattr(plan, name) for plan in plans]) for name in ("steps", "sizes"))
    return Plan(sorted(moved, key=lambda batch: -int(steps[batch].sum())), steps, sizes)


def dealt(grids: Mapping[str, Scenarios], of: int) -> dict[str, NDArray[np.int64]]:
    """The number, from 1, of the shard of each scenario of some grids, which are dealt as one.

    The whole grids are looked at, so that every shard cuts them alike.  Raises RunError where
    a scenario's step cannot be stable.
    """
    steps, structures, kinds = [], [], 0
    for scenarios in grids.values():
        costs = costs_of(scenarios, np.arange(len(scenarios)), 0, None)
        steps.append(costs.steps)
        structures.append(costs.structure + kinds)
        kinds += int(costs.structure.max()) + 1
    if not grids:
        return {}
    owners = deal(np.concatenate(steps), np.concatenate(structures), of)
    ends = np.cumsum([len(part) for part in steps])
    return dict(zip(grids, np.split(owners, ends[:-1]), strict=True))


@dataclass(frozen=True, eq=False)
class Costs:
    """Of each scenario: steps, bytes of its history, and which others it can be solved side by side with."""

    steps: NDArray[np.int64]
    sizes: NDArray[np.int64]
    structure: NDArray[np.int64]


def costs_of(
    scenarios: Scenarios, indices: NDArray[np.int64], history_channels: int, every: float | None
) -> Costs:
    """The costs of some scenarios; zero for the others.

    Raises RunError where a scenario's step cannot be stable.
    """
    costs = Costs(*(np.zeros(len(scenarios), dtype=np.int64) for _ in range(3)))
    structures: dict[tuple[object, ...], int] = {}
    for index, case, pace in scenarios.paces(indices.tolist()):
        try:
            grid = time_grid(case, pace)
        except TimeGridError as error:
            raise scenarios.case.refused(error.key, str(error), scenarios.describe(index)) from None
        costs.steps[index] = grid.steps
        stride = 1 if every is None else grid.stride
        columns = history_channels + 1 if history_channels else 0  # the times are one more
        costs.sizes[index] = 8 * columns * (grid.last // stride + 1)
        key = (case.bridge.modes, grid.substeps, pace.shape)
        costs.structure[index] = structures.setdefault(key, len(structures))
    return costs


def _cut(
    members: NDArray[np.int64], steps: NDArray[np.int64], sizes: NDArray[np.int64], share: int
) -> list[NDArray[np.int64]]:
    """Cuts scenarios, the longest first, into batches of full lanes; smaller where histories are large."""
    batches = []
    start = 0
    while start < len(members):
        end, cost, size = start, 0, 0
        while end < len(members) and end - start < _LARGEST_BATCH:
            if end > start and (end - start) % LANES == 0 and cost >= share:
                break
            if end > start and size + sizes[members[end]] > _HISTORY_BYTES:
                break
            cost += steps[members[end]]
            size += sizes[members[end]]
            end += 1
        batches.append(members[start:end])
        start = end
    return batches
