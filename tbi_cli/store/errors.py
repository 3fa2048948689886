"""The one exception that the store raises for anything that a user can mend."""

from __future__ import annotations

import os

from tbi_cli.errors import UserError


class StoreError(UserError):
    """A results file cannot be written or read; ``str(error)`` is the whole message, on one line."""

    @classmethod
    def from_os(cls, path: str | os.PathLike[str], error: OSError, advice: str = "") -> StoreError:
        """The message for a failed operation on ``path``, e.g. ``out.h5: No space left on device``."""
        reason = os.strerror(error.errno) if error.errno else one_line(str(error))
        return cls(f"{os.fspath(path)}: {reason}" + (f"; {advice}" if advice else ""))


def one_line(text: str) -> str:
    """``text`` with everything that would break or garble a line of a terminal replaced by spaces."""
    return " ".join("".join(c if c.isprintable() else " " for c in text).split())
