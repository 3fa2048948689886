"""Every key of a case file at the ends of what it takes, alone: read, planned, and solved where short.

Keys and ends come from the models that validate case files, so that a new key need not be named here.
"""

from __future__ import annotations

import tempfile
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tbi_cli.case import Case, load_case
from tbi_cli.case.fields import Accepts, Choice, Quantity, Switch, Whole
from tbi_cli.case.keys import accepts, fields_of, is_list, part_of
from tbi_cli.case.part import Part
from tbi_cli.errors import UserError
from tbi_cli.rounds import Rounds
from tbi_cli.runner import plan_of
from tbi_cli.solve import Solver
from tbi_cli.store.records import DONE, FAILED

# Together they have every key; short, so that most of what can be solved is.
BASES = {
    "full": """\
train: paper
bridge: {length: 20 m, modes: 2, low_pass: 40 Hz, stations: [0, 5],
  right: {youngs_modulus: 207 GPa, second_moment: 0.2, mass_per_length: 20e3, damping: 1e4},
  left: {youngs_modulus: 200 GPa, second_moment: 0.2, mass_per_length: 18e3, damping: {ratio: 1 %}}}
velocity: 60
gravity: 9.81
contact: {convective: true}
solver: {duration: 0.3, sampling: 2 ms}
output: {histories: {channels: [right_midspan], every: 4 ms}}
""",
    "hertz": """\
train: paper
bridge: paper
velocity: 60
contact: {model: hertz, damping: 50e3}
solver: {duration: 0.2}
""",
    "rails": """\
train: paper
bridge: paper
velocity: 60
contact: {model: paper}
solver: {duration: 0.2}
track:
  approach: 10 m
  irregularity:
    ramp: {at: -5, length: 2, height: 1 mm}
    dip: {at: 0, length: 2, depth: 1 mm}
    half_sine: {at: 3, length: 2, height: 1 mm}
    harmonic: {amplitude: 1 mm, wavelength: 10 m}
    random: {spectrum: german-low, seed: 1}
    profile: {x: [-5, 0, 5], right: [0, 1 mm, 0], left: [0, 0, 0]}
""",
    "row": """\
train:
  consist:
    - {vehicle: {model: rigid-beam, mass: 30 t, pitch_inertia: 1e6, support_distance: 12,
       stiffness: 4e6, damping: 0},
       front_overhang: 2, rear_overhang: 3}
    - {vehicle: {model: sprung-mass, mass: 8 t, stiffness: 2e6, damping: 2e4}, count: 2, spacing: 6}
    - {vehicle: {model: moving-load, forces: [90 kN, 60 kN], positions: [0, 2]}, count: 1, spacing: 5}
    - {vehicle: {model: hslm-a, number: 3}, spacing: 400}
bridge: {length: 20, modes: 2,
  right: {youngs_modulus: 30e9, second_moment: 0.3, mass_per_length: 10e3, damping: {first_mode_ratio: 1 %}}}
velocity: 60
solver: {duration: 0.3, sampling: 2 ms}
output: {coaches: each}
""",
    "forces": """\
train: {model: axle-forces, forces: [90 kN, 60 kN], positions: [0, 2]}
bridge: {length: 20, modes: 3, stations: {fractions: [0.5]},
  right: {youngs_modulus: 30e9, second_moment: 0.3, mass_per_length: 10e3, damping: 0}}
velocity: 60
solver: {method: exact, duration: 1.2, sampling: 2 ms}
""",
}
# Where a base differs from the first one; of a base that is not here all keys are tried.
_OWN_KEYS = {
    "hertz": ("contact.", "gravity", "train.wheelset.", "train.primary.", "train.geometry.", "bridge.right."),
    "rails": ("track.", "velocity", "solver.", "bridge.length"),
}
# Beyond so many steps a case is planned alone.
_MOST_STEPS = 200_000


def trials() -> Iterator[tuple[str, str]]:
    """The name of a base and an override, KEY=VALUE: each key of each base at each of its ends, and swept."""
    for name, text in BASES.items():
        case = _case(text)
        for key, field, values in _leaves(type(case), case, ""):
            if not key.startswith(_OWN_KEYS.get(name, "")):
                continue
            ends = list(_ends(field))
            for end in ends:
                yield name, f"{key}={end}" if values is None else f"{key}=[{', '.join([end, *values[1:]])}]"
            if values is None and isinstance(field, Quantity | Whole):
                yield name, f"sweep.{key}=[{', '.join(ends)}]"


def check_ends(folder: Path, base: str, override: str) -> str:
    """What came of it: "a message", "planned" or "solved". Raises what should never be."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            case = _case(BASES[base], override, folder=folder)
            solver = Solver(case)
            plan = plan_of(solver, Rounds(solver).first())
            if int(plan.steps.sum()) > _MOST_STEPS:
                return "planned"
            for batch in plan.batches:
                _check_solved(solver, batch)
        except UserError as error:
            assert str(error), "a message without words"
            return "a message"
    return "solved"


def _check_solved(solver: Solver, batch: NDArray[np.int64]) -> None:
    """Every number of a scenario is one, or the scenario has failed and says why."""
    result = solver.solve(batch)
    assert result is not None
    for status, message in zip(result.status, result.messages, strict=True):
        assert (status == FAILED) == bool(message), f"status {status}, message {message!r}"
    # NaN is for the own channels of coaches that a scenario lacks.
    named = [k for k, channel in enumerate(solver.tables) if not channel.name.startswith("coach_")]
    for group, values in result.tables.items():
        found = values[result.status == DONE][:, named]
        assert np.isfinite(found).all(), f"{group} is not finite, status {DONE}"


def _case(text: str, *overrides: str, folder: Path | None = None) -> Case:
    with tempfile.TemporaryDirectory(dir=folder) as place:
        path = Path(place) / "case.yaml"
        path.write_text(text, encoding="utf-8")
        return load_case(path, overrides=overrides)


def _leaves(part: type[Part], values: Any, before: str) -> Iterator[tuple[str, Accepts, list[str] | None]]:
    """Dotted key, what it takes, and the values of a list, of all that a mapping can hold."""
    for key, (name, info) in fields_of(part).items():
        value, field = getattr(values, name, None), accepts(info)
        if isinstance(value, tuple) and value and isinstance(value[0], Part):
            for number, item in enumerate(value):
                yield from _leaves(type(item), item, f"{before}{key}.{number}.")
        elif isinstance(value, Part) or (value is None and part_of(info, None)):
            inner = type(value) if isinstance(value, Part) else part_of(info, None)
            assert inner is not None
            yield from _leaves(inner, value, f"{before}{key}.")
        elif field is not None and is_list(info):
            yield before + key, field, [repr(item) for item in value or (0.0,)]
        elif field is not None:
            yield before + key, field, None


def _ends(field: Accepts) -> Iterator[str]:
    """The least and the largest that a key takes, zero where it is between them, and its words."""
    if isinstance(field, Quantity):
        if field.sign == "any":
            yield repr(-field.largest)
        if field.sign != "positive":
            yield "0"
        yield from (repr(field.smallest), repr(field.largest))
    elif isinstance(field, Whole):
        yield from (str(field.low), str(field.high))
    elif isinstance(field, Switch):
        yield from ("false", "true")
    if isinstance(field, Quantity | Whole | Choice):
        yield from field.words
