"""A Dask cluster of a scheduler and two workers, each a process of its own on the loopback interface."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import time
from pathlib import Path

SECONDS = 60.0


class DaskHere:
    """The scheduler at `address` and its workers; what they say goes into files in `folder`."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self.scheduler = self._start("scheduler", "--port", "0")
        self.address = self._wait_for("scheduler", r"Scheduler at:\s+(tcp://\S+)")
        self.workers = [
            self._start("worker", self.address, "--nthreads", "1", "--no-nanny") for _ in range(2)
        ]
        for number in range(2):
            self._wait_for(f"worker-{number}", "Registered to:")

    def _start(self, kind: str, *arguments: str) -> subprocess.Popen[bytes]:
        name = kind if kind == "scheduler" else f"worker-{len(list(self._folder.glob('worker-*')))}"
        command = [sys.executable, "-m", f"distributed.cli.dask_{kind}", *arguments]
        with (self._folder / name).open("wb") as log:
            return subprocess.Popen(
                [*command, "--host", "127.0.0.1", "--no-dashboard"],
                cwd=self._folder,
                env=os.environ | {"DASK_TEMPORARY_DIRECTORY": str(self._folder)},
                stdout=log,
                stderr=log,
            )

    def _wait_for(self, name: str, pattern: str) -> str:
        end = time.monotonic() + SECONDS
        while time.monotonic() < end:
            if found := re.search(pattern, (self._folder / name).read_text()):
                return found[found.lastindex or 0]
            time.sleep(0.05)
        raise TimeoutError((self._folder / name).read_text())

    def stop(self) -> None:
        """Ends the processes."""
        for process in (*self.workers, self.scheduler):
            process.kill()
            process.wait()
