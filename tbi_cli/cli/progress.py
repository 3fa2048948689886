"""How far a run is: a bar on a terminal, a plain line now and then elsewhere."""

from __future__ import annotations

import sys
import time

from tbi_cli.printable import bare

_SECONDS_BETWEEN_LINES = 10.0


class Terminal:
    """Lines and a bar on standard error."""

    def say(self, text: str) -> None:
        """A line for the user."""
        print(text, file=sys.stderr, flush=True)

    def start(self, scenarios: int, steps: int, done: int) -> None:
        """Shows the bar.  It moves by Runge-Kutta steps, which is what takes the time."""
        from tqdm import tqdm

        self._scenarios, self._done = scenarios, done
        self._last = time.monotonic()
        self._plain = not sys.stderr.isatty()
        self._bar = tqdm(
            file=bare(sys.stderr),
            total=steps,
            unit="step",
            unit_scale=True,
            disable=self._plain,
            bar_format="{percentage:3.0f}% |{bar}| {postfix}{rate_fmt}, {remaining} left",
            dynamic_ncols=True,
        )
        self._begin, self._steps, self._total = self._last, 0, steps
        self._show()

    def advance(self, scenarios: int, steps: int) -> None:
        """Moves the bar."""
        self._done += scenarios
        self._steps += steps
        self._show()
        self._bar.update(steps)
        if self._plain and time.monotonic() - self._last > _SECONDS_BETWEEN_LINES:
            self._last = time.monotonic()
            rate = self._steps / (self._last - self._begin)
            self.say(
                f"{self._done} of {self._scenarios} scenarios, {rate / 1e6:.2f} million steps a second, "
                f"{(self._total - self._steps) / rate:.0f} s left"
            )

    def _show(self) -> None:
        self._bar.set_postfix_str(f"{self._done}/{self._scenarios} scenarios, ", refresh=False)

    def end(self) -> None:
        """Takes the bar away."""
        self._bar.close()
