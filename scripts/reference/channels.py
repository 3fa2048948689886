"""The channels of every kind of train, from their declarations."""

from __future__ import annotations

from scripts.reference.markdown import code, table
from tbi_cli.case import load_case
from tbi_cli.responses import Channel, channels
from tbi_cli.system.assembly import build_system

_HEAD = """# Channels

What a results file holds of a crossing. Every table group (`peak`, `max`, `min`, `rms`, `time_of_peak`) has
one variable per channel over the swept axes; `histories` may hold a channel over time. A channel with
*derivatives* has two more beside it: `..._acceleration`, in tables and histories, and `..._velocity`, in
histories only. Modal coordinates are for histories only. Signs and axes are those of the
[conventions](../conventions.md).
"""
_STATIONS = """
## With `bridge.stations` and `bridge.low_pass`

Of each beam and station, here the first one at 5 m; see [the bridge's own quantities](../BRIDGE-OUTPUTS.md).

"""
_CONSIST = """
## Trains of several vehicles

Of a `consist`, what one vehicle calls `car_body_y` is the extreme over all vehicles that have it: the largest
maximum, RMS and peak (with its time), the smallest minimum. Each vehicle's own channels are named after it,
counted from the front: `coach_1_car_body_y`, `coach_2_car_body_y`. They can be stored as histories, and stand
in the tables too with `output: {coaches: each}`.
"""
_SECTIONS = {
    "full-31dof": ("paper", ()),
    "full-31dof, contact: hertz (those that the contact adds)": (
        "paper",
        ("contact={model: hertz}",),
    ),
    "sprung-mass": ("paper/verification-1", ()),
    "rigid-beam": ("paper/verification-2", ()),
    "moving-load, axle-forces, hslm-a": ("paper/verification-1-moving-load", ()),
}


def page() -> str:
    """The page of all channels."""
    text, full = _HEAD, set[str]()
    for heading, (name, overrides) in _SECTIONS.items():
        found = _channels(name, overrides)
        if "hertz" in heading:
            found = [channel for channel in found if channel.name not in full]
        full = full or {channel.name for channel in found}
        text += f"\n## {heading}\n\n{table(['name', 'unit', 'what', 'derivatives', 'in'], _rows(found))}"
    along = _channels("paper", ("bridge.stations=[5]", "bridge.low_pass=en-1990"))
    along = [channel for channel in along if channel.name not in full and "right" in channel.name]
    return f"{text}{_STATIONS}{table(['name', 'unit', 'what', 'derivatives', 'in'], _rows(along))}{_CONSIST}"


def _channels(name: str, overrides: tuple[str, ...]) -> list[Channel]:
    case = load_case(name, overrides=[*overrides, "sweep=null"])
    return channels(case, build_system(case))


def _rows(found: list[Channel]) -> list[list[str]]:
    names = {channel.name for channel in found}
    rows = []
    for channel in found:
        base = channel.name.removesuffix("_velocity").removesuffix("_acceleration")
        if base != channel.name and base in names:
            continue
        derived = "yes" if f"{channel.name}_acceleration" in names else ""
        where = "tables, histories" if channel.in_tables else "histories"
        rows.append([code(channel.name), channel.units, channel.long_name, derived, where])
    return rows
