"""Which of the rails a train meets: from the beginning of the approach to where its first axle comes last."""

from __future__ import annotations

from collections.abc import Iterator

from tbi_cli.case.messages import plain_number
from tbi_cli.case.model import Case
from tbi_cli.case.track import Profile

Finding = tuple[str, str]
_KEY = "track.irregularity"


def unmet(case: Case) -> Iterator[Finding]:
    """Key and message for each part of the irregularity of which no wheel ever meets anything."""
    if case.track is None:
        return
    come = case.way
    for name, shape in case.track.irregularity.shapes.items():
        if shape.at >= come:
            yield f"{_KEY}.{name}.at", f"expected a place before {_end(come)}, got {plain_number(shape.at)} m"
    profile = case.track.irregularity.profile
    if profile is None:
        return
    (first, last), (begin, end) = _stretch(case), profile.ends
    if end <= first or begin >= last:
        text = f"expected points between {_between(profile, first, last, 'and')}, where a train meets them"
        cure = "start is the x at which the bridge begins"
        yield f"{_KEY}.profile", f"{text}, got {_between(profile, begin, end, 'to')}; {cure}"


def partly_met(case: Case) -> Iterator[Finding]:
    """Key and message for each part of the irregularity of which a piece is never met."""
    if case.track is None:
        return
    come = case.way
    for name, shape in case.track.irregularity.shapes.items():
        end = shape.at + shape.length
        if shape.at < come < end * (1 - 1e-9):
            text = f"met only in part: it ends at {plain_number(end)} m, behind {_end(come)}"
            yield f"{_KEY}.{name}", text
    profile = case.track.irregularity.profile
    if profile is None:
        return
    (first, last), (begin, end) = _stretch(case), profile.ends
    room = 1e-9 * (abs(begin) + abs(end))
    if begin < first - room or end > last + room:
        text = f"met only in part: its points go from {_between(profile, begin, end, 'to')}"
        yield f"{_KEY}.profile", f"{text}, the train from {_between(profile, first, last, 'to')}"


def _end(come: float) -> str:
    return f"{plain_number(come)} m, as far as the first axle comes (solver.duration)"


def _stretch(case: Case) -> tuple[float, float]:
    """Between which places (m) measured rails are met: beyond the track they have faded."""
    assert case.track is not None
    return -case.track.approach, min(case.bridge.length + case.track.approach, case.way)


def _between(profile: Profile, first: float, last: float, word: str) -> str:
    """Two places, as the points count them."""
    begin = profile.start or 0.0
    return f"{_metres(begin + first)} {word} {_metres(begin + last)} m"


def _metres(x: float) -> str:
    """A place along a line of many kilometres, to the millimetre."""
    return f"{x:.3f}".rstrip("0").rstrip(".")
