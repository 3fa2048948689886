"""Signals kept waiting while HDF5 writes.

Python runs signal handlers wherever it happens to be, and HDF5 calls back into Python to write: an exception
raised there leaves HDF5 with half a file in its hands, which it does not survive every time.
"""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable
from types import FrameType, TracebackType

_SIGNALS = [
    getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGUSR1", "SIGHUP") if hasattr(signal, name)
]


class Interrupts:
    """While the ``with`` block runs, signals wait until `deliver` or the end of the block.

    Their handlers (Ctrl-C's raises KeyboardInterrupt) run there.  Handlers run in the main thread only, so
    there is nothing to do in another one.
    """

    def __init__(self) -> None:
        self._waiting: list[int] = []
        self._handlers: dict[int, Callable[[int, FrameType | None], object]] = {}

    def __enter__(self) -> Interrupts:
        if threading.current_thread() is threading.main_thread():
            for number in _SIGNALS:
                handler = signal.getsignal(number)
                if callable(handler):
                    self._handlers[number] = handler
                    signal.signal(number, self._keep_waiting)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        for number, handler in self._handlers.items():
            signal.signal(number, handler)
        if error is None:
            self.deliver()

    def _keep_waiting(self, number: int, frame: FrameType | None) -> None:
        self._waiting.append(number)

    def deliver(self) -> None:
        """Let the signals that came so far have their effect, now that it can do no harm."""
        while self._waiting:
            number = self._waiting.pop(0)
            self._handlers[number](number, None)
