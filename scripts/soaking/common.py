"""What the soak tests share: a folder with the case, commands, and what was counted."""

from __future__ import annotations

import os
import resource
import signal
import subprocess
from pathlib import Path

from tests.cluster.runs import CASE, command

HISTORIES = ("--set", "output.histories={channels: [right_midspan, car_body_y, wheelset_1_y], every: 0.002}")


class Soak:
    """What was counted; `failed` if anything did not hold."""

    def __init__(self, folder: Path, *, short: bool) -> None:
        self.folder, self.short = folder, short
        self.failed = False
        (folder / "case.yaml").write_text(CASE)

    def holds(self, what: str, true: bool) -> None:
        """Prints a line, and remembers if it is bad news."""
        print(f"  {'ok  ' if true else 'FAIL'} {what}", flush=True)
        self.failed |= not true

    def expect(self, what: str, true: bool) -> None:
        """As `holds`, of something so frequent that only bad news is printed."""
        if not true:
            self.holds(what, False)

    def tbi(
        self, *arguments: str, limit: int | None = None, **environment: str
    ) -> subprocess.CompletedProcess[str]:
        """A tbi process to its end; `limit` is the largest file, in bytes, that it may write."""
        done = subprocess.run(
            command(*arguments),
            cwd=self.folder,
            env=os.environ | environment,
            preexec_fn=None if limit is None else lambda: limit_file_size(limit),
            capture_output=True,
            text=True,
            check=False,
        )
        if "Traceback" in done.stderr:
            self.holds(f"no traceback from tbi {' '.join(arguments)}\n{done.stderr}", False)
        return done


def limit_file_size(size: int) -> None:
    """For a process that is about to start: no file larger than that."""
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
