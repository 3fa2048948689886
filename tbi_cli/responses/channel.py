"""A channel: what a results file holds of a crossing over time, declared once.

A channel is a weighted sum of signals.  A signal is what the integrator knows at every sample:

    ("x" | "v" | "a", coordinate)    displacement, velocity, acceleration of a coordinate or modal amplitude
    ("P", wheel)                     force of a wheel's suspension, tension positive (N)
    ("w" | "dw" | "ddw", wheel)      level under a wheel and its total time derivatives
    ("aloft", wheel)                 time without contact so far (s)
    ("M" | "V", station)             moment over L, and shear force, that the wheels' forces would cause at
                                     rest (N); the stations of the right beam first
"""

from __future__ import annotations

from dataclasses import dataclass

Signal = tuple[str, int]
Terms = tuple[tuple[Signal, float], ...]

DERIVATIVES = {"x": ("", ""), "v": ("_velocity", "/s"), "a": ("_acceleration", "/s2")}


@dataclass(frozen=True)
class Channel:
    """One quantity over time: name, units, long name, and how it is formed.

    `in_tables` is false for what only histories may hold.  One with `members`, the names of other channels,
    is their extreme, and for tables only: the largest maximum, RMS and peak (with its time), the smallest
    minimum.  `low_pass` is the number of the beam by whose low-pass filter it has passed.
    """

    name: str
    units: str
    long_name: str
    terms: Terms
    offset: float = 0.0
    in_tables: bool = True
    members: tuple[str, ...] = ()
    low_pass: int | None = None

    @property
    def in_histories(self) -> bool:
        """Whether there is a history of it."""
        return not self.members


def derivatives(name: str, units: str, long_name: str, terms: dict[str, Terms]) -> list[Channel]:
    """A displacement or rotation with its velocity (histories only) and acceleration."""
    words = {"x": long_name, "v": f"{long_name}, velocity", "a": f"{long_name}, acceleration"}
    made = []
    for kind, (suffix, per) in DERIVATIVES.items():
        made.append(Channel(name + suffix, units + per, words[kind], terms[kind], in_tables=kind != "v"))
    return made
