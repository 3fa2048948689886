"""Whole case files, and the files that they name, which fuzz.py then breaks."""

from __future__ import annotations

from pathlib import Path

from tbi_cli.case import list_builtin, load_case, starter_case
from tbi_cli.case.builtin import builtin_path

# What no built-in case has: mixed consists, rails as measured, files of one's own, every form of a sweep.
MORE = (
    """\
train:
  consist:
    - {vehicle: {model: moving-load, forces: [1 kN, 2 kN], positions: [0, 3]}, count: 2, spacing: 25 m}
    - {vehicle: {model: axle-forces, forces: [1 kN, 2 kN], positions: [0, 3]}, spacing: 20}
    - {vehicle: {model: hslm-a, number: 3}, count: 1, spacing: 400}
bridge: verification-1
solver: {method: exact, sampling: 0.01}
sweep: {train.consist.0.spacing: [25, 26], velocity: {log: {from: 1, to: 99, count: 3}}}
""",
    """\
train:
  consist:
    - {vehicle: paper, count: 3, spacing: 25 m}
    - {vehicle: &last crh380a, spacing: 25}
    - {vehicle: *last, spacing: 26 m}
bridge: &b paper
contact: {model: hertz, stiffness: 1.4e9}
velocity: 300 km/h
sweep:
  sample:
    {kind: random, count: 5, over: {velocity: {normal: [80, 5], within: [70, 90]}, span: {uniform: [30, 40]}}}
""",
    """\
train: {model: axle-forces, csv: forces.csv}
bridge: verification-2
sweep: {velocity: [10, 20, 10], damping: {from: 0, to: 2, count: 3}, modes: [1], zip: [velocity, damping]}
""",
    """\
train: train.yaml
bridge: bridge.yaml
contact: {model: hertz, damping: 50 kN*s/m}
velocity: 300 km/h
track: {approach: 30 m, irregularity: {profile: {csv: rails.csv}, ramp: {at: 1, length: 2 m, height: 1 mm}}}
output: {coaches: each, histories: {channels: [car_body_y], every: 0.01 s}}
sweep:
  sample:
    kind: sobol
    count: 4
    seed: 7
    over:
      train.car_body.mass: {triangular: [30 t, 40 t, 50 t]}
      bridge.right.youngs_modulus: {loguniform: [30 GPa, 210 GPa]}
""",
    """\
train: {model: hslm-a, number: 1}
bridge: {length: 15, stations: [0, 7.5 m], low_pass: 30 Hz,
  right: {youngs_modulus: 35 GPa, second_moment: 0.563, mass_per_length: 15 t/m, damping: {ratio: 1 %}}}
velocity: 50
studies:
  first: {sweep: {velocity: {from: 40, to: 60, step: 4, refine: resonance, tolerance: 2 %}}}
  second: {train.number: 2, bridge.stations: {fractions: [0.5]}, sweep: {sample: {kind: latin-hypercube,
    count: 3, over: {velocity: {uniform: [40, 50]}}}}}
  third: {train: {model: moving-load, forces: [1 kN]}, bridge: bridge.yaml, bridge.left: null, velocity: 20}
""",
)
# The files that these name, each of which may be the broken one.
BESIDE = {
    "forces.csv": "position,force\n0,1 kN\n3 m,2e3\n",
    "rails.csv": "x [m], right [mm], left [mm]\n-5, 0, 0\n0, 1, 2\n5, 0.5, 1\n10, 0, 0\n",
    "train.yaml": (builtin_path("train", "crh380a") or Path()).read_text(encoding="utf-8"),
    "bridge.yaml": (builtin_path("bridge", "paper") or Path()).read_text(encoding="utf-8"),
}


def corpus() -> list[str]:
    """Real case files: the built-in ones, as written and resolved, starters, and a few more."""
    cases = list_builtin("case")
    written = [case.path.read_text(encoding="utf-8") for case in cases]
    starters = [starter_case(train) for train in ("paper", "velaro-e-8", "hslm-a1")]
    return [*written, *(load_case(case.name).to_yaml() for case in cases), *starters, *MORE]


CORPUS = corpus()
CASE = "case.yaml"
