"""`tbi` and `python -m tbi_cli`."""

from __future__ import annotations

import gc
import sys


def main() -> None:
    """Runs the command line and ends the process with its exit code."""
    # The hundred thousand objects that imports make are there to stay.  To look through them again and again
    # for garbage takes a tenth of a second, and to do so once more at the end another two.
    gc.set_threshold(100_000)
    from tbi_cli.cli import run_command_line

    code = run_command_line(sys.argv[1:])
    gc.freeze()
    sys.exit(code)


if __name__ == "__main__":
    main()
