"""Where the integrator finds what a channel is made of."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tbi_cli.batch.model import Model
from tbi_cli.responses import Signal


class SignalRows:
    """The rows of the signal array, in the order of `tbi_cli.integrator.arrays`.

    Each of the `wanted` channels (by their place in the models, which differ in numbers only) is a plain
    signal, a weighted sum of signals, or one of these low-passed; `row_of` says in which row it is.
    """

    def __init__(self, models: Sequence[Model], wanted: Sequence[int]) -> None:
        system = models[0].system
        nd = len(system.coordinates) + len(system.beams) * len(system.beams[0].omega)
        wheels, stations = len(system.wheel_axle), len(system.beams) * len(system.stations)
        wheel_blocks = ("P", "w", "dw", "ddw", "aloft")
        self._first = {kind: (i * nd, 1) for i, kind in enumerate(("x", "v", "a"))}
        self._first |= {kind: (3 * nd + i * wheels, 1) for i, kind in enumerate(wheel_blocks)}
        self.static = 3 * nd + 5 * wheels
        self._first |= {"M": (self.static, 2), "V": (self.static + 1, 2)}
        self.sums = self.static + 2 * stations

        self.row_of: dict[int, int] = {}
        summed: list[int] = []
        for c in wanted:
            versions = [model.channels[c] for model in models]
            signal = versions[0].terms[0][0]
            if all(channel.terms == ((signal, 1.0),) and channel.offset == 0.0 for channel in versions):
                self.row_of[c] = self.row(signal)
            else:
                self.row_of[c] = self.sums + len(summed)
                summed.append(c)
        terms = [models[0].channels[c].terms for c in summed]
        lengths = np.array([len(some) for some in terms], dtype=np.int64)
        self.end = np.cumsum(lengths, dtype=np.int64)
        self.begin = self.end - lengths
        self.col = np.array([self.row(signal) for some in terms for signal, _ in some], dtype=np.int64)
        self.offset = np.array([[model.channels[c].offset for c in summed] for model in models])
        coef = [[value for c in summed for _, value in model.channels[c].terms] for model in models]
        self.coef = np.array(coef, dtype=np.float64).reshape(len(models), -1)
        self.filters = self.sums + len(summed)
        passed = [c for c in wanted if models[0].channels[c].low_pass is not None]
        self.filter_col = np.array([self.row_of[c] for c in passed], dtype=np.int64)
        self.filter_beam = np.array([models[0].channels[c].low_pass for c in passed], dtype=np.int64)
        self.row_of |= {c: self.filters + f for f, c in enumerate(passed)}
        self.stages = self.filters + len(passed)
        kinds = {signal[0] for c in wanted for signal, _ in models[0].channels[c].terms}
        self.of_stations = not kinds.isdisjoint("MV")
        self.of_wheels = not kinds.isdisjoint(wheel_blocks)

    def row(self, signal: Signal) -> int:
        """The row of a signal."""
        first, step = self._first[signal[0]]
        return first + step * signal[1]
