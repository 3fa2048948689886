"""`tbi validate`."""

from __future__ import annotations

import sys

from tbi_cli.cli import options


def validate(
    case: options.CaseFile,
    set_: options.Set = None,
    strict: options.Strict = False,
) -> None:
    """Check a case file and say what it would cost; solve nothing."""
    from tbi_cli.case import load_case
    from tbi_cli.estimate import estimate

    loaded = load_case(case, overrides=set_ or (), strict=strict)
    for warning in loaded.warnings:
        print(warning, file=sys.stderr)
    for line in estimate(loaded):
        print(line)
