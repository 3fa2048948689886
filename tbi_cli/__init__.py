"""tbi: the dynamic interaction of a train and the bridge that it crosses.

    from tbi_cli import load_case, open_results, run

    summary = run(load_case("case.yaml"))
    with open_results(summary.path) as results:
        results.table("peak", "right_midspan")

The same path as the command line: `load_case` reads and validates, `run` solves and writes, `open_results`
reads.  Each is imported when it is first used.
"""

from __future__ import annotations

TYPE_CHECKING = False  # typing's own takes long to import
if TYPE_CHECKING:
    from typing import Any

    from tbi_cli.case import Case, load_case
    from tbi_cli.runner import Options, Summary, run
    from tbi_cli.store import Results, open_results, studies_of

__version__ = "0.2.0.dev0"

_PLACES = {
    "Case": "tbi_cli.case",
    "load_case": "tbi_cli.case",
    "Options": "tbi_cli.runner",
    "Summary": "tbi_cli.runner",
    "run": "tbi_cli.runner",
    "Results": "tbi_cli.store",
    "open_results": "tbi_cli.store",
    "studies_of": "tbi_cli.store",
}

__all__ = ["Case", "Options", "Results", "Summary", "load_case", "open_results", "run", "studies_of"]


def __getattr__(name: str) -> Any:
    if name not in _PLACES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    return getattr(import_module(_PLACES[name]), name)
