"""Properties that hold for every vehicle, bridge and speed, each run from case file to results file."""

from __future__ import annotations

import copy
import tempfile
from collections.abc import Mapping
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
from hypothesis import HealthCheck, given, settings

from tbi_cli.verify.cases.full_train import text
from tbi_cli.verify.references.balance import energy_balance, lateral_momentum, roll_momentum
from tbi_cli.verify.references.crossing import crossing_channels
from tbi_cli.verify.references.parameters import Array, crossing_from_case
from tbi_cli.verify.references.sampled import with_modal_rates
from tbi_cli.verify.references.scaling import mirror_sign, mirrored
from tbi_cli.verify.solved import solve
from tests.verify.strategies import cases, full_trains, moving_loads, rigid_beams, sprung_masses

GROUPS = ("peak", "max", "min", "rms", "time_of_peak")
few = settings(
    max_examples=12,
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
)


class Run:
    """A case that was solved through its files: tables (channel -> value) and histories."""

    def __init__(self, case: Mapping[str, Any]) -> None:
        with (
            tempfile.TemporaryDirectory() as folder,
            closing(solve(text(case, "random"), "case", Path(folder))) as s,
        ):
            self.tables = {g: {c: s.table(g, c).ravel() for c in s.table_channels} for g in GROUPS}
            self.h = s.history() if case["output"]["histories"] != "none" else {}


def changed(case: Mapping[str, Any], **values: Any) -> dict[str, Any]:
    return {**copy.deepcopy(dict(case)), **values}


def scale_of(h: Mapping[str, Array]) -> dict[str, float]:
    """The size of each kind of motion: the largest of all channels of the same kind.

    Roll, yaw and lateral motions are differences of vertical ones: those times 1e-3 are the least size.
    """
    kinds: dict[str, float] = {}
    for name, y in h.items():
        kinds[_kind(name)] = max(kinds.get(_kind(name), 0.0), float(np.abs(y).max()))
    for kind in kinds:
        for sideways in ("_roll", "_yaw", "_z"):
            if kind.startswith(sideways):
                kinds[kind] = max(kinds[kind], 1e-3 * kinds["_y" + kind.removeprefix(sideways)])
    return kinds


def _kind(name: str) -> str:
    rate = next((r for r in ("_velocity", "_acceleration") if name.endswith(r)), "")
    stem = name.removesuffix(rate)
    for ending in ("_roll", "_yaw", "_pitch", "_z", "_force"):
        if stem.endswith(ending):
            return ending + rate
    return ("mode" if "_mode_" in stem else "_y") + rate


def check_tables(run: Run, window: float) -> None:
    t = run.tables
    for name in t["peak"]:
        values = np.concatenate([t[g][name] for g in GROUPS])
        assert np.isfinite(values).all(), name
        peak, highest, lowest, rms, when = values
        assert peak == max(abs(highest), abs(lowest))
        assert highest >= lowest
        # the mean square of samples none of which is above the peak, rounded
        assert peak * (1 + 1e-12) >= rms
        assert 0 <= when <= window * (1 + 1e-12)
        if name in run.h:
            y = run.h[name]
            assert (y.max(), y.min()) == (highest, lowest)
            assert abs(y[np.searchsorted(run.h["time"], when - 1e-9)]) == peak


@few
@given(cases(full_trains()))
def test_full_train(case: dict[str, Any]) -> None:
    run = Run(case)
    c = crossing_from_case(case)
    t = run.h["time"]
    window = 1.3 * (c.right.length + c.train.axle_distances[-1]) / c.velocity
    check_tables(run, window)

    # Energy: Runge-Kutta at omega h <= 0.05 loses (omega h)^6/72 = 2e-10 of the fastest motion's energy a
    # step, 1e-5 over the longest window, and that motion holds a hundredth of the energy at most.
    energy = energy_balance(c, t, with_modal_rates(c, t, run.h))
    assert np.abs(energy.error).max() < 1e-7 * energy.stored.max()
    rounding = 1e-13 * c.train.car_mass * float(np.abs(run.h["front_bogie_y_velocity"]).max())
    for momentum, scale in (lateral_momentum(c, run.h), roll_momentum(c, run.h)):
        # linear invariants: rounding over some thousand steps; two equal beams leave nothing but rounding
        assert np.abs(momentum).max() <= 1e-10 * scale + rounding

    # An independent assembly and integrator: phase error omega T (omega h)^4/120 of the fastest motion, below
    # 1e-4 of it, and it is a small part of every channel's kind.
    reference = crossing_channels(c, t)
    sizes = scale_of({name: reference[name] for name in run.h if name != "time"})
    for name, y in run.h.items():
        if name != "time":
            assert np.abs(y - reference[name]).max() <= 1e-5 * sizes[_kind(name)], name


@few
@given(cases(full_trains()))
def test_full_train_in_the_mirror_and_under_half_the_gravity(case: dict[str, Any]) -> None:
    base, mirror = Run(case), Run(mirrored(case))
    half = Run(changed(case, gravity=9.81 / 2))
    sizes = scale_of({name: y for name, y in base.h.items() if name != "time"})
    for name, y in base.h.items():
        if name == "time":
            continue
        image, sign = mirror_sign(name)
        # rounding of the deflections, in motions that come from differences of them
        assert np.abs(mirror.h[image] - sign * y).max() <= 1e-9 * sizes[_kind(name)], name
        # halving is exact, and so is every operation that follows
        np.testing.assert_array_equal(half.h[name], 0.5 * y, err_msg=name)


@few
@given(cases(sprung_masses() | rigid_beams()))
def test_simple_vehicles(case: dict[str, Any]) -> None:
    run, half = Run(case), Run(changed(case, gravity=9.81 / 2))
    length, v = case["bridge"]["length"], case["velocity"]
    check_tables(run, 1.3 * (length + case["train"].get("support_distance", 0.0)) / v)
    for name, y in run.h.items():
        if name != "time":
            np.testing.assert_array_equal(half.h[name], 0.5 * y, err_msg=name)


@few
@given(cases(moving_loads()))
def test_moving_loads_add_up(case: dict[str, Any]) -> None:
    run = Run(case)
    train, v = case["train"], case["velocity"]
    offsets = [position - train["positions"][0] for position in train["positions"]]
    check_tables(run, 1.3 * (case["bridge"]["length"] + offsets[-1]) / v)
    summed = np.zeros(len(run.h["time"]))
    window = run.h["time"][-1]
    for force, behind in zip(train["forces"], offsets, strict=True):
        single = changed(case, train={"model": "moving-load", "forces": [force], "positions": [0.0]})
        single["solver"]["duration"] = max(1.0, float(window) * v / case["bridge"]["length"])
        w = Run(single).h["right_midspan"]
        lag = round(behind / v / case["solver"]["sampling"])
        summed += np.concatenate([np.zeros(lag), w, np.zeros(len(summed))])[: len(summed)]
    # rounding: Runge-Kutta is linear in the load, and the entries fall on samples
    np.testing.assert_allclose(run.h["right_midspan"], summed, atol=1e-11 * np.abs(summed).max(), rtol=0)


@settings(few, max_examples=8)
@given(cases(full_trains()))
def test_results_do_not_depend_on_the_grid(case: dict[str, Any]) -> None:
    mass, v = case["train"]["car_body"]["mass"], case["velocity"]
    bare = changed(case, output={"histories": "none"})
    bare["solver"] = {"sampling": 2e-3, "substeps": 4, "duration": 1.3}
    alone = Run(bare).tables
    swept = changed(bare, sweep={"car_body_mass": [0.7 * mass, mass], "velocity": [0.9 * v, v, 1.2 * v]})
    grid = Run(swept).tables
    for group in GROUPS:
        for name, value in alone[group].items():
            assert grid[group][name].reshape(2, 3)[1, 1] == value[0], (group, name)
