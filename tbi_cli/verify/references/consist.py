"""Full trains one behind the other over the same two beams, integrated with DOP853.

Every coach obeys the equations of `crossing` by itself, as late as its first axle is behind the train's; what
joins them is the beams alone, which all of them push.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from tbi_cli.verify.references.crossing import CoupledSystem, channels_of
from tbi_cli.verify.references.parameters import Array, crossing_from_case
from tbi_cli.verify.references.piecewise import integrate_between_events


def coach_fronts(groups: Sequence[Mapping[str, Any]], wheelbases: Sequence[float]) -> list[float]:
    """Distance (m) of each coach's first axle behind the train's, one group of the case file for each.

    Walks along the train, from a first axle to the last one, to the coupler, to the next first axle.
    """
    fronts, place = [], 0.0
    for group, wheelbase in zip(groups, wheelbases, strict=True):
        ahead, behind = _overhangs(group, wheelbase)
        place += ahead
        fronts.append(place)
        place += wheelbase + behind
    return [front - fronts[0] for front in fronts]


def _overhangs(group: Mapping[str, Any], wheelbase: float) -> tuple[float, float]:
    """From the coupler to the first axle, and from the last one to the coupler (m)."""
    given = {key: float(group[key]) for key in ("front_overhang", "rear_overhang", "spacing") if key in group}
    if len(given) > 1:
        front = given.get(
            "front_overhang", given.get("spacing", 0.0) - wheelbase - given.get("rear_overhang", 0.0)
        )
        return front, given.get("rear_overhang", given.get("spacing", 0.0) - wheelbase - front)
    return (given["spacing"] - wheelbase) / 2, (given["spacing"] - wheelbase) / 2


class ConsistSystem:
    """M x'' = F(t, x, x') with x = (27 of every coach, 2n modal)."""

    def __init__(self, case: Mapping[str, Any]) -> None:
        groups = [group for group in case["train"]["consist"] for _ in range(int(group.get("count", 1)))]
        self.coaches = [CoupledSystem(crossing_from_case({**case, "train": g["vehicle"]})) for g in groups]
        wheelbases = [float(coach.distances[-1]) for coach in self.coaches]
        self.fronts = coach_fronts(groups, wheelbases)
        first = self.coaches[0]
        self.velocity, self.n, self.own = first.crossing.velocity, first.n, first.n_train
        self.beams = slice(self.own * len(self.coaches), self.own * len(self.coaches) + 2 * self.n)

    def events(self) -> Array:
        """Times (s) at which an axle enters or leaves."""
        shifted = zip(self.coaches, self.fronts, strict=True)
        return np.concatenate([coach.events() + front / self.velocity for coach, front in shifted])

    def late(self, time: Array | float, number: int) -> Array:
        """A time as a coach counts it, from the entry of its own first axle."""
        return np.asarray(time - self.fronts[number] / self.velocity)

    def rows(self, number: int) -> Array:
        """Where the coordinates of a coach and of the beams are."""
        own = np.arange(number * self.own, (number + 1) * self.own)
        return np.concatenate([own, np.arange(self.beams.start, self.beams.stop)])

    def acceleration(self, time: float, x: Array, x_t: Array, on: Sequence[Array]) -> Array:
        """x'' with the axles `on` (4,) of every coach on the bridge."""
        out = np.zeros_like(x)
        for number, coach in enumerate(self.coaches):
            rows = self.rows(number)
            alone = coach.acceleration(float(self.late(time, number)), x[rows], x_t[rows], on[number])
            # Every coach alone has the beams' own stiffness and damping in it; they count once.
            idle = np.zeros(len(rows)) if number == 0 else self._own_of_beams(coach, x[rows], x_t[rows])
            out[rows] += alone - idle
        return out

    def _own_of_beams(self, coach: CoupledSystem, x: Array, x_t: Array) -> Array:
        forces = -coach.K @ x - coach.C @ x_t
        forces[: self.own] = 0.0
        result: Array = forces / coach.mass
        return result

    def integrate(self, times: Array) -> tuple[Array, Array]:
        """x and x' at increasing `times` >= 0, from rest at t = 0."""
        size = self.beams.stop

        def rate_between(start: float, stop: float) -> Callable[[float, Array], Array]:
            middle = 0.5 * (start + stop)
            on = [coach.axles_on(self.late(middle, i)) for i, coach in enumerate(self.coaches)]

            def rate(t: float, state: Array) -> Array:
                x, x_t = state[:size], state[size:]
                return np.concatenate([x_t, self.acceleration(t, x, x_t, on)])

            return rate

        state = integrate_between_events(rate_between, 2 * size, self.events(), times)
        return state[:size], state[size:]


def consist_channels(case: Mapping[str, Any], times: Array) -> dict[str, Array]:
    """Every channel of every coach (`coach_3_car_body_y`) and of the beams at `times`: name -> (nt,)."""
    system = ConsistSystem(case)
    x, x_t = system.integrate(times)
    on = [coach.axles_on(system.late(times, i)) for i, coach in enumerate(system.coaches)]
    x_tt = np.array(
        [
            system.acceleration(float(t), x[:, j], x_t[:, j], [axles[:, j] for axles in on])
            for j, t in enumerate(times)
        ]
    ).T
    out: dict[str, Array] = {}
    for number, coach in enumerate(system.coaches):
        rows, late = system.rows(number), system.late(times, number)
        motion = replace(coach.motion_of(late, x[rows], x_t[rows], x_tt[rows]), time=times)
        for name, values in channels_of(coach, motion).items():
            of_beam = name.startswith(("right_", "left_"))
            out[name if of_beam else f"coach_{number + 1}_{name}"] = values
    return out
