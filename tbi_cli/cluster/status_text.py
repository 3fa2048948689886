"""The status of a run in words."""

from __future__ import annotations

from collections import Counter

from tbi_cli.cluster.status import FileStatus, RunStatus

# More files than this are counted, not listed, unless asked for.
_LISTED = 20


def status_lines(status: RunStatus, *, verbose: bool = False) -> list[str]:
    """Lines for people: how much is done, failed and missing, by file if there are few, and what is left."""
    missing = status.scenarios - status.done - status.failed
    lines = []
    for name, study in status.studies.items():
        lines += [f"study      {name}", _counts(study)]
    lines += ["all studies"] if lines else []
    lines.append(_counts(status))
    if len(status.files) > 1:
        states = Counter(file.state for file in status.files)
        lines.append(
            f"shards     {len(status.files)}: " + ", ".join(f"{n} {state}" for state, n in states.items())
        )
    listed = verbose or len(status.files) <= _LISTED
    lines += [_line(file) for file in status.files if listed or file.state == "running"]
    return [*lines, *_left(status, missing)]


def _counts(status: RunStatus) -> str:
    missing = status.scenarios - status.done - status.failed
    least = "at least " if status.growing else ""
    return f"scenarios  {least}{status.scenarios}: {status.done} done, {status.failed} failed, " + (
        f"{least}{missing} missing" if missing or not least else "none missing so far"
    )


def _line(file: FileStatus) -> str:
    name = f"shard {file.shard}" if file.shard is not None else str(file.path)
    text = f"{name}: {file.state}"
    if file.where:
        text += f" by {file.where}"
    text += f", {file.done} of {file.scenarios} done"
    if file.failed:
        text += f", {file.failed} failed"
    return text


def _left(status: RunStatus, missing: int) -> list[str]:
    if status.growing and not missing:
        return ["time left  unknown: the sweep may add scenarios where it is refined"]
    if not missing:
        return []
    about = "at least" if status.growing else "about"
    if status.seconds_left is not None:
        return [f"time left  {about} {duration(status.seconds_left)} at the present pace"]
    if status.processor_seconds_left is not None:
        return [f"time left  {about} {duration(status.processor_seconds_left)} of one processor"]
    return ["time left  unknown: no batch is finished yet"]


def duration(seconds: float) -> str:
    """A time in words, rounded: 45 s, 12 min, 3.5 h, 2.1 days."""
    for limit, length, unit in ((120, 1, "s"), (7200, 60, "min"), (172800, 3600, "h")):
        if seconds < limit:
            return f"{seconds / length:.0f} {unit}" if length < 3600 else f"{seconds / length:.1f} {unit}"
    return f"{seconds / 86400:.1f} days"
