#!/usr/bin/env python
"""Fits what Table 1 leaves open to the numbers that the paper reports: an inverse problem.

    python scripts/identify_table1.py                   20 starts for each of the two best combinations
    python scripts/identify_table1.py --quick           few starts, few steps
    python scripts/identify_table1.py --json fit.json   for machines too

First every combination of the discrete unknowns (static load, damping, convective term, geometry) with the
published vehicle, the masses of the two beams by a common factor; then least squares from many starts, the
published vehicle and a Latin hypercube, under the best of the combinations.  See docs/TABLE1.md.
"""

from __future__ import annotations

import argparse
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from identification import telling
from identification.parameters import CHOICES, PARAMETERS, PUBLISHED_CHOICE, published
from identification.search import Fit, Problem, certainty, multi_start
from identification.targets import targets
from identification.trials import Trials


def main() -> int:
    """The exit code."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--starts", type=int, default=20, help="starts for each combination  [20]")
    parser.add_argument("--combinations", type=int, default=2, help="how many combinations are searched  [2]")
    parser.add_argument("--evaluations", type=int, default=12, help="trials of a step from each start  [12]")
    parser.add_argument("--polish", type=int, default=25, help="more from the two best answers  [25]")
    parser.add_argument(
        "--floor", type=float, default=0.02, help="error that every number has at least  [0.02]"
    )
    parser.add_argument("--leave-out", nargs="*", default=[], metavar="ID", help="claims that are not fitted")
    parser.add_argument("--seed", type=int, default=1, help="of the starts  [1]")
    parser.add_argument("--jobs", type=int, default=1, help="threads  [1]")
    parser.add_argument("--quick", action="store_true", help="3 starts, few steps each, one combination")
    parser.add_argument("--json", type=Path, metavar="FILE", help="everything, written there as JSON")
    options = parser.parse_args()
    if options.quick:
        options.starts, options.evaluations, options.polish, options.combinations = 3, 4, 4, 1

    wanted = targets(options.floor, options.leave_out)
    problems = {choice: Problem(Trials(choice, PARAMETERS), wanted) for choice in CHOICES}
    start = published(PARAMETERS)
    as_published = problems[PUBLISHED_CHOICE].at(start)

    with ThreadPoolExecutor(options.jobs) as pool:
        screening = sorted(
            pool.map(lambda problem: problem.scaled(start), problems.values()), key=lambda fit: fit.total
        )
    print(telling.screening(screening, as_published), flush=True)
    found: list[list[Fit]] = []
    for fit in screening[: options.combinations]:
        problem = problems[fit.trials.choice]
        found.append(
            multi_start(
                problem,
                options.starts,
                options.seed,
                options.evaluations,
                options.polish,
                options.jobs,
                lambda fit: print(f"  {fit.total:.1f}", flush=True),
            )
        )
        print(telling.answers(found[-1]), flush=True)
    best = min((fits[0] for fits in found), key=lambda fit: fit.total)
    answers = next(fits for fits in found if fits[0] is best)
    sure = certainty(problems[best.trials.choice], best)
    print(telling.residuals(wanted, as_published, best))
    print(telling.parameters(answers, sure))
    if options.json:
        options.json.write_text(telling.to_json(options, wanted, as_published, screening, found, sure))
    return 0


if __name__ == "__main__":
    sys.exit(main())
