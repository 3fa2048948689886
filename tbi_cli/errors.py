"""What a user can do wrong, and what can go wrong around a run."""

from typing import ClassVar


class UserError(Exception):
    """A mistake in the input or its surroundings.  Its text is the complete message."""

    exit_code: ClassVar[int] = 2


class RunFailedError(UserError):
    """A run that was made as asked and could not be finished."""

    exit_code: ClassVar[int] = 1
