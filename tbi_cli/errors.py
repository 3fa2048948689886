"""What a user can do wrong, and what can go wrong around a run."""

from __future__ import annotations

import os
from typing import ClassVar, Self

from tbi_cli.printable import printable


class UserError(Exception):
    """A mistake in the input or its surroundings.  Its text, made printable, is the complete message.

    A message is one line; one of several is given as so many arguments.
    """

    exit_code: ClassVar[int] = 2
    #: Whether what was finished is kept and the run can go on: whoever knows the command then says so.
    goes_on: bool = False

    def __init__(self, *lines: str) -> None:
        super().__init__("\n".join(map(printable, lines)))

    def kept(self) -> Self:
        """The same error, of a run that can go on."""
        self.goes_on = True
        return self

    @classmethod
    def from_os(cls, path: str | os.PathLike[str], error: OSError, advice: str = "") -> Self:
        """The message for a failed operation on ``path``, e.g. ``out.h5: No space left on device``."""
        reason = os.strerror(error.errno) if error.errno else str(error)
        return cls(f"{os.fspath(path)}: {reason}" + (f"; {advice}" if advice else ""))


class RunFailedError(UserError):
    """A run that was made as asked and could not be finished."""

    exit_code: ClassVar[int] = 1
