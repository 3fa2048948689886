"""Whether two runs may share a results file, and if not, what tells them apart."""

from __future__ import annotations

from collections.abc import Mapping

from tbi_cli.advice import ANOTHER_FILE
from tbi_cli.printable import one_line
from tbi_cli.store.errors import StoreError
from tbi_cli.store.layout import Scalar

_SHOWN = 5  # changed keys named in a message


def refuse_other_run(
    where: str, old: Mapping[str, Scalar], new: Mapping[str, Scalar], advice: str = ANOTHER_FILE
) -> None:
    """Raise `StoreError` if two sets of root attributes are of different cases, versions or shards.

    ``where`` names the file that holds ``old``; ``advice`` ends the message.
    """
    if old.get("case_sha256") != new.get("case_sha256"):
        changes = changed_keys(str(old.get("case", "")), str(new.get("case", "")))
        raise StoreError(f"{where}: holds another case ({changes}); {advice}")
    for key, words in (
        ("tbi_version", "was written by tbi {}, this is {}"),
        ("shard", "is shard {}, not {}"),
    ):
        a, b = str(old.get(key, "none")), str(new.get(key, "none"))
        if a != b:
            raise StoreError(f"{where}: {words.format(one_line(a), one_line(b))}; {advice}")


def changed_keys(old: str, new: str) -> str:
    """The keys of two resolved cases whose values differ, with both values, for a message."""
    from tbi_cli.case import CaseError
    from tbi_cli.case.leaves import leaves_of

    try:
        a, b = leaves_of(old), leaves_of(new)
    except CaseError:
        return "which cannot be compared"
    keys = [key for key in dict.fromkeys([*a, *b]) if a.get(key, "absent") != b.get(key, "absent")]
    if not keys:
        return "which differs in its checksum only"
    shown = [
        f"{key}: {in_short(a.get(key, 'absent'))}, now {in_short(b.get(key, 'absent'))}"
        for key in keys[:_SHOWN]
    ]
    if len(keys) > _SHOWN:
        shown.append(f"and {len(keys) - _SHOWN} more keys")
    return "; ".join(shown)


def in_short(value: object) -> str:
    """A value of a case in a few characters."""
    if isinstance(value, list | dict):
        return f"{len(value)} values" if len(value) > 4 else one_line(str(value))[:60]
    return one_line(str(value))[:60]
