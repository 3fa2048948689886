"""What is wrong between keys, each of which is right by itself; and what is odd but not impossible."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator
from itertools import product
from math import prod
from typing import Any

from tbi_cli.case.axes import Axis
from tbi_cli.case.axle_forces import HslmA
from tbi_cli.case.bridge import USUAL_RATIO, Beam
from tbi_cli.case.consist import Consist
from tbi_cli.case.fields import BadValueError, Quantity
from tbi_cli.case.full_train import FullTrain
from tbi_cli.case.keys import accepts, fields_of, find_number
from tbi_cli.case.messages import of_many, plain_number
from tbi_cli.case.met_rails import partly_met, unmet
from tbi_cli.case.model import Case
from tbi_cli.case.part import Part
from tbi_cli.case.settings import HERTZ_SPRING
from tbi_cli.case.simple_vehicles import MovingLoad
from tbi_cli.case.train import VEHICLES

Finding = tuple[str, str]
_MOST_CORNERS = 10_000
_GEOMETRY = re.compile(r"train\..*(geometry\.|spacing|overhang|support_distance|positions\.)")
_WINDOW = re.compile(
    r"velocity|bridge\.length|solver\.duration|track\.approach|train\..*(geometry|spacing|overhang|count)"
)
_TRACK = re.compile(
    r"track\.(?!.*\.seed)|bridge\.length|solver\.duration"
    r"|train\..*(geometry\.|spacing|overhang|support_distance)"
)
FORCES = [model for model, part in VEHICLES.items() if issubclass(part, MovingLoad | HslmA)]


def contradictions(case: dict[str, Any]) -> Iterator[Finding]:
    """Key and message for keys of a case (as plain values) that do not go together."""
    train, bridge, contact, solver = (case.get(key) for key in ("train", "bridge", "contact", "solver"))
    models = _models(train)
    if not models or not isinstance(train, dict):
        return
    two_beams = models[0] == "full-31dof"
    for number, model in enumerate(models):
        if (model == "full-31dof") != two_beams:
            beams = ("both beams", "bridge.right alone")
            first, other = beams if two_beams else beams[::-1]
            text = f"the first vehicle runs on {first}, a {model} on {other}; they cannot run in one train"
            yield f"train.consist.{number}.vehicle.model", text
    article = "an" if models[0] in ("axle-forces", "hslm-a") else "a"
    named = f"{article} {models[0]} train"
    if train["model"] == "consist":
        named = f"a consist of {models[0]} vehicles"
    if isinstance(bridge, dict) and not two_beams and bridge.get("left") is not None:
        yield "bridge.left", f"not for {named}, which runs on one beam, bridge.right"
    if isinstance(bridge, dict) and two_beams and bridge.get("left") is None:
        yield "bridge.left", f"missing; {named} needs both beams"
    if isinstance(contact, dict):
        yield from _contact_contradictions(contact, named, two_beams, train["model"])
    if case.get("track") is not None and all(model in FORCES for model in models):
        yield "track", f"not for {named}, whose forces do not feel the rails"
    if isinstance(solver, dict) and solver.get("method") == "exact":
        yield from _exact_contradictions(solver, models)


def _models(train: Any) -> list[str]:
    """The model of a train, or of each group of vehicles of a consist; empty if they are not all known."""
    model = train.get("model") if isinstance(train, dict) else None
    models = [model]
    if model == "consist":
        groups = train.get("consist")
        listed = [group for group in groups if isinstance(group, dict)] if isinstance(groups, list) else []
        vehicles = [group.get("vehicle") for group in listed]
        models = [vehicle.get("model") for vehicle in vehicles if isinstance(vehicle, dict)]
    known = [name for name in models if isinstance(name, str) and name in VEHICLES]
    return known if len(known) == len(models) else []


def _contact_contradictions(
    contact: dict[str, Any], named: str, wheelsets: bool, model: str
) -> Iterator[Finding]:
    if contact.get("model") == "hertz":
        if not wheelsets:
            yield "contact.model", f"expected paper, got hertz ({named} has no wheelsets)"
        if contact.get("static_load") == "paper":
            yield "contact.static_load", "expected physical, got paper (Eq. 13a is for the contact paper)"
    else:
        for key in HERTZ_SPRING:
            if key in contact:
                yield f"contact.{key}", "only for the contact model hertz"
    if model != "full-31dof" and contact.get("static_load") == "paper":
        yield (
            "contact.static_load",
            f"expected physical, got paper (Eq. 13a is for full-31dof, not for {model})",
        )


def _exact_contradictions(solver: dict[str, Any], models: list[str]) -> Iterator[Finding]:
    """The exact solution is that of constant forces, and its steps have no error to make smaller."""
    other = next((model for model in models if model not in FORCES), None)
    if other is not None:
        yield "solver.method", f"expected rk4, got exact (exact is for {', '.join(FORCES)}, not for {other})"
    if solver.get("substeps", "auto") != "auto":
        yield "solver.substeps", "expected auto, as the steps of the method exact have no error"


def sweep_contradictions(case: Case, axes: tuple[Axis, ...]) -> Iterator[Finding]:
    """Key and message for values of the sweep, or of solver and output, that do not go together."""
    every, sampling = case.output.histories.every, case.solver.sampling
    if every is not None:
        axis = next((axis for axis in axes if "solver.sampling" in axis.paths), None)
        samplings = axis.values if axis else () if isinstance(sampling, str) else (sampling,)
        bad = next((dt for dt in samplings if not _is_multiple(every, dt)), None)
        if bad is not None:
            text = f"expected a multiple of the sampling interval, {plain_number(bad)} s"
            yield "output.histories.every", f"{text}, got {plain_number(every)} s"
    spans = [v for axis in axes for path, v in _values_of(axis) if path == "bridge.length"]
    farthest = max(case.bridge.stations.positions, default=0.0)
    if farthest > min(spans or [case.bridge.length]):
        span, got = plain_number(min(spans or [case.bridge.length])), plain_number(farthest)
        yield "bridge.stations", f"expected positions on the span of {span} m, got {got} m"
    if isinstance(case.train, FullTrain | Consist | MovingLoad):
        yield from _geometry_contradictions(case, axes)
    if case.track is not None:
        yield from _on_the_track(case, axes, _track_contradictions)


def _values_of(axis: Axis) -> Iterator[tuple[str, float]]:
    """Every dotted key that an axis sets, with every value that it sets it to."""
    for column in axis.members or (axis,):
        yield from ((path, value) for path in column.paths for value in column.values)


def _is_multiple(every: float, sampling: float) -> bool:
    ratio = every / sampling
    return round(ratio) >= 1 and abs(ratio - round(ratio)) <= 1e-6 * ratio


def _geometry_contradictions(case: Case, axes: tuple[Axis, ...]) -> Iterator[Finding]:
    """Arms, spacings and positions over the corners of the swept distances, on which they depend linearly.

    Axes that move together are tried value by value; where these are too many, a train whose arms do not go
    together is found when the run is planned.
    """
    for point, key in _corners(case, axes, _GEOMETRY):
        try:
            check_train(point)
        except BadValueError as error:
            yield key, str(error)
            return


def check_train(case: Case) -> None:
    """Raises BadValueError where arms, spacings or positions of the train do not go together."""
    groups = case.train.consist if isinstance(case.train, Consist) else ()
    for vehicle in (case.train, *(group.vehicle for group in groups)):
        if isinstance(vehicle, FullTrain):
            _ = vehicle.geometry.arms
        elif isinstance(vehicle, MovingLoad):
            vehicle.check()
    for group in groups:
        group.check()


def _on_the_track(
    case: Case, axes: tuple[Axis, ...], said_of: Callable[[Case], Iterable[Finding]]
) -> Iterator[Finding]:
    """What is said of the track, or first said of it at a corner of the swept lengths and places."""
    swept = any(_TRACK.match(path) for axis in axes for path in axis.paths)
    for point, sweep_key in _corners(case, axes, _TRACK) if swept else iter([(case, "")]):
        try:
            found = list(said_of(point))
        except BadValueError:
            continue  # arms that do not go together are said of their own keys
        if found:
            yield from [(sweep_key, f"{found[0][0]}: {found[0][1]}")] if sweep_key else found
            return


def _track_contradictions(case: Case) -> Iterator[Finding]:
    assert case.track is not None
    yield from case.track.contradictions(case.bridge.length)
    yield from unmet(case)


def _corners(case: Case, axes: tuple[Axis, ...], wanted: re.Pattern[str]) -> Iterator[tuple[Case, str]]:
    """The cases at the ends of the axes whose keys match, and the key of the first of these axes."""
    swept = [axis for axis in axes if any(wanted.match(path) for path in axis.paths)]
    if not swept:
        return
    grid = case.swept(tuple(swept))
    ends = [axis.values if axis.members else sorted({min(axis.values), max(axis.values)}) for axis in swept]
    if prod(len(values) for values in ends) > _MOST_CORNERS:
        return
    for corner in product(*ends):
        point = grid.at(dict(zip((axis.name for axis in swept), corner, strict=True)))
        yield point, f"sweep.{swept[0].key}"


def oddities(case: Case, axes: tuple[Axis, ...], has_unit: Callable[[str], bool]) -> Iterator[Finding]:
    """Key and message for numbers outside of the range that is usual for them.

    `has_unit` tells of a key whether its value was written with a unit.
    """
    swept = {path for axis in axes for path in axis.paths}
    bridge_is_odd = False
    for paths, field, values in _numbers(case, ""):
        numbers = [(path, value) for path, value in zip(paths, values, strict=True) if path not in swept]
        odd = [(path, value) for path, value in numbers if field.odd(value, has_unit=True)]
        if odd:
            path, value = odd[0]
            bridge_is_odd |= path.startswith("bridge.")
            yield path, of_many(field.odd(value, has_unit(path)), len(odd))
    plain_case = case.resolved()
    for axis in [column for whole in axes for column in whole.members or (whole,)]:
        leaf, _ = find_number(axis.paths[0], plain_case, case.train.model)
        if isinstance(leaf, Quantity):
            key = f"sweep.{axis.key}"
            said = next((text for value in axis.values if (text := leaf.odd(value, has_unit(key)))), "")
            if said:
                yield key, said
    yield from _odd_damping(case, bridge_is_odd)
    yield from _odd_interval(case, axes)
    if isinstance(case.train, MovingLoad):
        yield from ((f"train.{key}", text) for key, text in case.train.oddities())
    if case.track is not None:
        yield from case.track.oddities()
        yield from _on_the_track(case, axes, partly_met)


def _numbers(part: Part, before: str) -> Iterator[tuple[list[str], Quantity, list[float]]]:
    """The dotted keys of each number, or of all numbers in a list, what they take, and the numbers."""
    for key, (name, info) in fields_of(type(part)).items():
        value, field = getattr(part, name), accepts(info)
        if isinstance(value, Part):
            yield from _numbers(value, f"{before}{key}.")
        elif isinstance(value, tuple) and value and isinstance(value[0], Part):
            for number, part in enumerate(value):
                yield from _numbers(part, f"{before}{key}.{number}.")
        elif isinstance(field, Quantity):
            listed = isinstance(value, tuple)
            numbers = [float(one) for one in (value if listed else (value,)) if isinstance(one, int | float)]
            paths = (
                [f"{before}{key}.{number}" for number in range(len(numbers))] if listed else [before + key]
            )
            if numbers:
                yield paths, field, numbers


def _odd_damping(case: Case, bridge_is_odd: bool) -> Iterator[Finding]:
    """Beams oddly damped in their first mode; of an odd bridge only where the ratio itself is given."""
    beams: Iterable[tuple[str, Beam | None]] = (("right", case.bridge.right), ("left", case.bridge.left))
    for side, beam in beams:
        if beam is None or beam.damping.value == 0 or beam.damping.form == "ratio":
            continue
        if bridge_is_odd and beam.damping.form == "coefficient":
            continue
        ratio = beam.first_mode_damping_ratio(case.bridge.length)
        if not USUAL_RATIO[0] <= ratio <= USUAL_RATIO[1]:
            low, high = (f"{100 * bound:g}" for bound in USUAL_RATIO)
            key = f"bridge.{side}.damping"
            yield (
                key,
                f"{100 * ratio:.3g} % of critical in the first mode is outside the usual {low} to {high} %",
            )


def _odd_interval(case: Case, axes: tuple[Axis, ...]) -> Iterator[Finding]:
    """An interval of stored samples that is longer than the shortest window."""
    every = case.output.histories.every
    if every is None:
        return
    points = [point for point, _ in _corners(case, axes, _WINDOW)] or [case]
    shortest = min(points, key=lambda point: point.window)
    if every > shortest.window:
        text = f"{plain_number(every)} s is longer than the {shortest.window:.4g} s"
        where = f"of a crossing at {plain_number(shortest.velocity)} m/s"
        yield "output.histories.every", f"{text} {where}: its history holds nothing but its first sample"
