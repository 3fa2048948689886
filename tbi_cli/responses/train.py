"""All channels of a case, train-wide and coach by coach."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from tbi_cli.case import Case, Consist
from tbi_cli.responses.bridge import midspan_channels, mode_channels, station_channels
from tbi_cli.responses.channel import Channel
from tbi_cli.responses.vehicle import force_channels, motion_channels
from tbi_cli.system.assembly import Coach, System, coach_name


def channels(case: Case, system: System) -> list[Channel]:
    """Every channel of a case, in the order of the results file: vehicle, bridge, forces, modes.

    Of a consist, what one vehicle calls `car_body_y` is the extreme over all vehicles that have it; each
    vehicle's own is `coach_3_car_body_y`, the coaches counted from 1 at the front.
    """
    bridge = midspan_channels(system) + station_channels(case.bridge, system)
    train = case.train
    if not isinstance(train, Consist):
        motions, forces = motion_channels(train, system), force_channels(train, system, case.gravity)
        return motions + bridge + forces + mode_channels(system)
    vehicles = [group.vehicle for group in train.consist for _ in range(group.count)]
    own: dict[int, tuple[list[Channel], list[Channel]]] = {}
    alike: tuple[dict[str, list[Channel]], dict[str, list[Channel]]] = ({}, {})
    for number, (coach, vehicle) in enumerate(zip(system.coaches, vehicles, strict=True)):
        one = coach.system
        if id(one) not in own:
            own[id(one)] = motion_channels(vehicle, one), force_channels(vehicle, one, case.gravity)
        for found, group in zip(own[id(one)], alike, strict=True):
            for channel in found:
                group.setdefault(channel.name, []).append(_of_coach(channel, coach, number))
    motions, forces = (
        [_extreme(n, group) for n, group in some.items() if group[0].in_tables] for some in alike
    )
    each = [channel for some in alike for group in some.values() for channel in group]
    if case.output.coaches == "extremes":
        each = [replace(channel, in_tables=False) for channel in each]
    return motions + bridge + forces + each + mode_channels(system)


def _extreme(name: str, group: Sequence[Channel]) -> Channel:
    """The train-wide extreme of a channel that several coaches have."""
    first = group[0]
    long_name = f"{first.long_name.rpartition(',')[0]}, largest of all coaches"
    return Channel(name, first.units, long_name, (), members=tuple(channel.name for channel in group))


def _of_coach(channel: Channel, coach: Coach, number: int) -> Channel:
    """A channel of a vehicle by itself as that of a coach of the train."""
    terms = tuple(
        ((kind, i + (coach.first_coordinate if kind in ("x", "v", "a") else coach.first_wheel)), value)
        for (kind, i), value in channel.terms
    )
    name, long_name = f"{coach_name(number)}_{channel.name}", f"{channel.long_name}, coach {number + 1}"
    return Channel(name, channel.units, long_name, terms, channel.offset, channel.in_tables)
