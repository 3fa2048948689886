"""One part of a grid out of several that cost the same: `--shard I/N`."""

from __future__ import annotations

import heapq
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tbi_cli.errors import UserError
from tbi_cli.integrator.arrays import LANES

MOST_SHARDS = 999_999  # of one run


@dataclass(frozen=True)
class Shard:
    """The part `number` of `of` parts, counted from 1."""

    number: int
    of: int

    @classmethod
    def parse(cls, text: str) -> Shard:
        """The shard in a text such as 3/16; raises UserError."""
        match = re.fullmatch(r"([1-9][0-9]{0,5})/([1-9][0-9]{0,5})", text)
        if match is None or int(match[1]) > int(match[2]):
            raise UserError(f"--shard: expected I/N, with I from 1 to N, e.g. 3/16; got {text!r}")
        return cls(int(match[1]), int(match[2]))

    def path(self, results: Path) -> Path:
        """Where this shard of a results file goes, beside it: results.shard-03-of-16.h5."""
        width = len(str(self.of))
        return results.with_name(f"{results.stem}.shard-{self.number:0{width}d}-of-{self.of}{results.suffix}")

    @classmethod
    def of_path(cls, path: Path, results: Path) -> Shard | None:
        """Which shard of a results file a file, or the folder of its parts, is; None if it is none."""
        ends = re.escape(results.stem), re.escape(results.suffix)
        match = re.fullmatch(rf"{ends[0]}\.shard-0*(\d+)-of-(\d+){ends[1]}(\.parts)?", path.name)
        if match is None:
            return None
        try:
            shard = cls.parse(f"{match[1]}/{match[2]}")
        except UserError:
            return None
        return shard if path.name.startswith(shard.path(results).name) else None

    def __str__(self) -> str:
        return f"{self.number}/{self.of}"


def deal(steps: NDArray[np.int64], structure: NDArray[np.int64], of: int) -> NDArray[np.int64]:
    """The number, from 1, of the shard of each scenario, so that every shard takes about as many steps.

    `steps` (n,) is what each scenario costs; scenarios of one `structure` (n,) can be solved side by side.
    Bundles of neighbours in length, which fill the lanes, are dealt, the costliest first, each to the shard
    that has the least so far.  Whole numbers only, so that every machine deals alike.
    """
    order = np.lexsort((np.arange(len(steps)), -steps, structure))
    bundles = _bundles(order, steps, structure, int(steps.sum()) // of)
    costs = [int(steps[bundle].sum()) for bundle in bundles]
    owner = np.zeros(len(steps), dtype=np.int64)
    least = [(0, number) for number in range(1, of + 1)]
    for place in sorted(range(len(bundles)), key=lambda i: -costs[i]):
        cost, number = least[0]
        owner[bundles[place]] = number
        heapq.heapreplace(least, (cost + costs[place], number))
    return owner


def _bundles(
    order: NDArray[np.int64], steps: NDArray[np.int64], structure: NDArray[np.int64], most: int
) -> list[NDArray[np.int64]]:
    """Cuts scenarios into bundles of one structure, of `LANES` at most, and of `most` steps if of several."""
    bundles = []
    start, cost = 0, 0
    for end in range(len(order) + 1):
        if end < len(order):
            own = int(steps[order[end]])
            fits = end - start < LANES and cost + own <= most
            if end == start or (fits and structure[order[end]] == structure[order[start]]):
                cost += own
                continue
        bundles.append(order[start:end])
        start, cost = end, int(steps[order[end]]) if end < len(order) else 0
    return bundles
