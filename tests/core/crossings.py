"""Cases for the tests of the core, and their histories through the code that users run."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tbi_cli.case import Case, load_case
from tbi_cli.solve import Solver

Histories = dict[str, NDArray[np.float64]]


def case_from(text: str, folder: Path, *overrides: str) -> Case:
    """A case from the text of a case file."""
    path = folder / "case.yaml"
    path.write_text(text)
    return load_case(path, overrides=overrides)


def paper(*overrides: str) -> Case:
    """The paper's case at 300 km/h with changes."""
    return load_case("paper", overrides=overrides)


def histories(case: Case, index: int = 0) -> Histories:
    """Every channel over time, and `time` itself."""
    solver = Solver(case)
    result = solver.solve([index])
    assert result is not None
    assert result.status[0] == 1, result.messages
    history = result.histories[index]
    return {"time": history.time} | {c.name: v for c, v in zip(solver.histories, history.values, strict=True)}


def tables(case: Case, indices: list[int] | None = None) -> dict[str, dict[str, NDArray[np.float64]]]:
    """Table -> channel -> value per scenario."""
    solver = Solver(case)
    chosen = list(range(len(solver.scenarios))) if indices is None else indices
    result = solver.solve(chosen)
    assert result is not None
    return {
        table: {c.name: values[:, k] for k, c in enumerate(solver.tables)}
        for table, values in result.tables.items()
    }
