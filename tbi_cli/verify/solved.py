"""Case file -> results file -> reader: the path that every verification case takes, as a user's does."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tbi_cli.verify.check import Outcome
from tbi_cli.verify.references.parameters import Array, Crossing, crossing_from_case


@dataclass(frozen=True)
class Verification:
    """One group of verification cases.

    `cases`: the case files by name, as text; `compare` takes what they gave, by the same names.
    """

    number: int
    title: str
    about: str
    cases: Mapping[str, str]
    compare: Callable[[Mapping[str, Solved]], Outcome]


class Solved:
    """A results file, read back through the package's own reader.

    case: its case file as it was written, of plain mappings and SI numbers where a reference looks into it.
    References go by that and not by what the results file says, so that they do not share a mistake in
    reading a case: a default, a unit, one bogie for the other.
    """

    def __init__(self, path: Path, case: Mapping[str, Any]) -> None:
        from tbi_cli.store import open_results

        self._results = open_results(path)
        self.case = case

    def close(self) -> None:
        """Close the file."""
        self._results.close()

    @property
    def crossing(self) -> Crossing:
        """The reference's own parameters of that case (31-degree-of-freedom train)."""
        return crossing_from_case(self.case)

    def axis(self, name: str) -> Array:
        """Coordinate values of a swept axis."""
        return next(d.values for d in self._results.dims if d.name == name)

    @property
    def table_channels(self) -> list[str]:
        """Names of the channels of the tables."""
        return [v.name for v in self._results.channels]

    def table(self, group: str, channel: str) -> Array:
        """One table over the grid."""
        return self._results.table(group, channel)

    @property
    def history_units(self) -> dict[str, str]:
        """Units of the stored channels."""
        return {v.name: v.units for v in self._results.history_channels}

    def history(self, *index: int) -> dict[str, Array]:
        """The stored histories of the case at a grid index: channel -> (nt,), and `time`."""
        flat = int(np.ravel_multi_index(index, self._results.shape)) if index else 0
        found = self._results.history(flat)
        names = [v.name for v in self._results.history_channels]
        return {"time": found.time, **dict(zip(names, found.values, strict=True))}


class CaseFailedError(Exception):
    """A verification case that the package could not solve; the text says which and why."""


def solve(case: str, name: str, folder: Path) -> Solved:
    """Write the case file, run it as `tbi run` does, and open the results file.

    Raises CaseFailedError for a case that is refused or fails.
    """
    import yaml

    from tbi_cli.case import load_case
    from tbi_cli.errors import UserError
    from tbi_cli.runner import Options, run

    case_file, results_file = folder / f"{name}.yaml", folder / f"{name}.h5"
    case_file.write_text(case, encoding="utf-8")
    try:
        summary = run(load_case(case_file), Options(output=results_file, overwrite=True))
    except UserError as error:
        raise CaseFailedError(f"{name}: {error}") from error
    if summary.failed or summary.left:
        raise CaseFailedError(f"{name}: {'; '.join(summary.messages) or 'not all scenarios were solved'}")
    return Solved(results_file, yaml.safe_load(case))
