"""`tbi` and `python -m tbi_cli`."""

from __future__ import annotations

import os
import sys
from signal import SIG_IGN, SIGINT, getsignal, signal
from types import FrameType


def main() -> None:
    """Runs the command line and ends the process with its exit code."""
    interrupt = getsignal(SIGINT)
    if interrupt != SIG_IGN:  # as in a script's background
        signal(SIGINT, _end_at_once)
    import gc

    # The hundred thousand objects that imports make are there to stay.  To look through them again and again
    # for garbage takes a tenth of a second, and to do so once more at the end another two.
    gc.set_threshold(100_000)
    from tbi_cli.cli import run_command_line
    from tbi_cli.cli.environment import settle_environment
    from tbi_cli.cli.streams import let_go_of_output, set_up_streams

    set_up_streams()
    settle_environment()
    signal(SIGINT, interrupt)
    code = run_command_line(sys.argv[1:])
    let_go_of_output()
    if interrupt != SIG_IGN:
        signal(SIGINT, _end_at_once)
    gc.freeze()
    sys.exit(code)


def _end_at_once(number: int, frame: FrameType | None) -> None:
    """Ctrl-C while Python imports, or ends: there is nothing to lose, and where it is need not be told."""
    os._exit(130)


if __name__ == "__main__":
    main()
