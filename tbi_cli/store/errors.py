"""The one exception that the store raises for anything that a user can mend."""

from __future__ import annotations

import errno

from tbi_cli.errors import UserError
from tbi_cli.printable import one_line

__all__ = ["ExistsError", "PlaceError", "StoreError", "is_missing", "one_line"]

_MISSING = (errno.ENOENT, errno.ENOTDIR, errno.ENAMETOOLONG)


class StoreError(UserError):
    """A results file cannot be written or read; ``str(error)`` is the whole message, on one line."""


class ExistsError(StoreError):
    """A results file, or an unfinished run, is there already."""


class PlaceError(StoreError):
    """A results file cannot be where it was asked for."""


def is_missing(error: OSError) -> bool:
    """Whether it says that there is no such file: none of that name, or no name that a file can have."""
    return error.errno in _MISSING
