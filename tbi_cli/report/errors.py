"""The one exception of this package."""

from __future__ import annotations

from tbi_cli.errors import UserError


class ReportError(UserError):
    """A report that cannot be made as asked; ``str(error)`` is the whole message."""
