"""What one scenario of a run took to solve."""

from __future__ import annotations

from tbi_cli.report.study import Place, Study
from tbi_cli.system.assembly import build_system
from tbi_cli.timegrid import pace_of, time_grid


def solve_seconds(study: Study, place: Place) -> float | None:
    """A scenario's part of its run's solution time (s), by its Runge-Kutta steps.

    Scenarios are solved side by side, so a time of its own does not exist.  None if the file does not tell.
    """
    case = study.case_at(place)
    seconds, steps = (study.results.attributes.get(key) for key in ("solve_seconds", "case_steps"))
    if (
        case is None
        or not isinstance(seconds, int | float)
        or not isinstance(steps, int | float)
        or not steps
    ):
        return None
    return float(seconds) / float(steps) * time_grid(case, pace_of(build_system(case))).steps
