"""What scenarios solved side by side may not share: filters, steps, rails, entries of their matrices."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tbi_cli.case import Case
from tbi_cli.integrator.arrays import LANES
from tbi_cli.plan import make_plan
from tbi_cli.solve import Solver
from tests.core.crossings import case_from, paper

FORCES = """
train: {model: moving-load, forces: [100 kN, 60 kN], positions: [0, 3.7]}
bridge:
  length: 20 m
  modes: 3
  low_pass: 25 Hz
  right: {youngs_modulus: 30e9, second_moment: 0.3, mass_per_length: 10e3, damping: {ratio: 1 %}}
velocity: 50
solver: {method: exact, sampling: 2e-3, duration: 1.2}
sweep: {velocity: {from: 31, to: 91, step: 5}}
"""


def bits(case: Case, batches: list[list[int]]) -> dict[int, bytes]:
    """Every table of each scenario, solved in these batches."""
    found = {}
    for batch in batches:
        result = Solver(case).solve(batch)
        assert result is not None
        for place, index in enumerate(batch):
            found[index] = b"".join(values[place].tobytes() for values in result.tables.values())
    return found


def as_planned_and_alone(case: Case) -> None:
    """A scenario has the bits that it has by itself, as the plan of a run puts them together."""
    scenarios = Solver(case).scenarios
    count = len(scenarios)
    plan = make_plan(scenarios, np.ones(count, dtype=bool), 0, None)
    together = bits(case, [batch.tolist() for batch in plan.batches])
    assert together == bits(case, [[index] for index in range(count)])
    assert len(set(together.values())) == count


def test_low_pass_filters_begin_at_rest(tmp_path: Path) -> None:
    """More scenarios than lanes: those of the second block come after others."""
    case = case_from(FORCES, tmp_path)
    count = len(Solver(case).scenarios)
    assert count > LANES
    assert bits(case, [list(range(count))]) == bits(case, [[index] for index in range(count)])


def test_scenarios_of_unlike_steps() -> None:
    """Stiffer and stiffer primary springs need more and more steps between two samples."""
    as_planned_and_alone(
        paper(
            "sweep={train.primary.vertical.stiffness: [0.3e6, 1.2e6, 40e6, 200e6]}",
            "solver={sampling: 0.01, substeps: auto, duration: 1}",
        )
    )


def test_random_rails_of_unlike_spans() -> None:
    """The rails behind a longer bridge go on for longer, and fade out further on."""
    as_planned_and_alone(
        paper(
            "contact={model: paper, static_load: physical}",
            "track={approach: 30, irregularity: {random: {spectrum: fra-4, coherence: cross-level}}}",
            "sweep={span: [61, 17, 33.5]}",
            "solver={sampling: 0.002, substeps: 2, duration: 1.2}",
        )
    )


def test_matrices_with_as_many_entries_in_other_places() -> None:
    """Two vehicles, one without lateral dampers above its front bogie, the other above its rear one."""
    ends = ("front", "rear")
    keys = [f"train.{end}_bogie.secondary.lateral.damping" for end in ends]
    given = [f"train.{end}_bogie={{secondary: {{lateral: {{damping: 1e4}}}}}}" for end in ends]
    sweep = f"sweep={{{keys[0]}: [0, 6e4], {keys[1]}: [4e4, 0], zip: [{', '.join(keys)}]}}"
    case = paper(*given, sweep, "solver={sampling: 0.002, substeps: 1, duration: 1}")
    one, other = (Solver(case).scenarios.model(index).matrix for index in (0, 1))
    assert len(one.column) == len(other.column)
    assert not np.array_equal(one.column, other.column)
    assert bits(case, [[0, 1]]) == bits(case, [[0], [1]])
