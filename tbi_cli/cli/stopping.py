"""Signals that end a run early, with nothing lost."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

INTERRUPTED, RESUME_ME = 130, 75


class Stop(threading.Event):
    """Set by the first signal.

    `exit_code` says which kind it was, `time_is_nearly_up` whether it was SIGUSR1.
    """

    exit_code = 0
    time_is_nearly_up = False

    def caught(self, number: int, frame: FrameType | None) -> None:
        """The signal handler.  A second Ctrl-C ends the process at once."""
        if not self.is_set():
            self.exit_code = INTERRUPTED if number == signal.SIGINT else RESUME_ME
            self.time_is_nearly_up = signal.Signals(number).name == "SIGUSR1"
        signal.signal(signal.SIGINT, signal.default_int_handler)
        self.set()


@contextmanager
def stop_on_signals() -> Iterator[Stop]:
    """Catches SIGINT, SIGTERM and SIGUSR1 (a batch system's warning that time is nearly up)."""
    stop = Stop()
    wanted = [signal.SIGINT, signal.SIGTERM, *([signal.SIGUSR1] if hasattr(signal, "SIGUSR1") else [])]
    before = {number: signal.signal(number, stop.caught) for number in wanted}
    try:
        yield stop
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
