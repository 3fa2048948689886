"""Runs the verification: every group's cases are solved, read back and compared."""

from __future__ import annotations

import math
import tempfile
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, closing, contextmanager
from dataclasses import dataclass
from pathlib import Path

from tbi_cli.errors import UserError
from tbi_cli.scratch import scratch_folder
from tbi_cli.verify.check import Check, Outcome, Tolerance
from tbi_cli.verify.solved import CaseFailedError, Solved, Verification, solve


@dataclass(frozen=True)
class Group:
    """A group of verification cases, what came out of it, and how long one had to wait for it."""

    verification: Verification
    outcome: Outcome
    seconds: float

    @property
    def passed(self) -> bool:
        """True if there are checks and every one passed."""
        return bool(self.outcome.checks) and all(check.passed for check in self.outcome.checks)


@contextmanager
def case_folder(keep: Path | None) -> Iterator[Path]:
    """The folder for case files and results files: `keep`, made if need be, or one removed afterwards.

    Raises UserError where `keep` cannot be made or is a folder with something in it.
    """
    if keep is None:
        with scratch_folder(Path(tempfile.gettempdir()), "tbi-verify-") as folder:
            yield folder
        return
    try:
        keep.mkdir(parents=True, exist_ok=True)
        if any(keep.iterdir()):
            raise UserError(f"--keep: expected a new or an empty folder, got {keep}, which holds files")
    except OSError as error:
        raise UserError(f"--keep: {keep}: {error.strerror}") from error
    yield keep


def run_verification(folder: Path, verifications: Sequence[Verification] | None = None) -> Iterator[Group]:
    """Solve and compare one group after another; `folder` keeps the case files and the results files.

    While a group is compared, the next ones are being solved.  A case that cannot be solved is a check that
    failed.
    """
    if verifications is None:
        from tbi_cli.verify.cases import VERIFICATIONS

        verifications = VERIFICATIONS
    with ThreadPoolExecutor(max_workers=1) as solver:
        runs = [solver.submit(_solve, v, folder) for v in verifications]
        try:
            for verification, run in zip(verifications, runs, strict=True):
                begin = time.perf_counter()
                try:
                    opened, solved = run.result()
                    with opened:
                        outcome = verification.compare(solved)
                except CaseFailedError as error:
                    outcome = _failed(str(error))
                yield Group(verification, outcome, time.perf_counter() - begin)
        finally:
            for run in runs:
                run.cancel()


def _solve(verification: Verification, folder: Path) -> tuple[ExitStack, dict[str, Solved]]:
    """The results of a group's cases, and what closes them.

    Raises CaseFailedError for the first case that fails.
    """
    with ExitStack() as opened:
        solved = {
            name: opened.enter_context(closing(solve(case, name, folder)))
            for name, case in verification.cases.items()
        }
        return opened.pop_all(), solved


def _failed(message: str) -> Outcome:
    """A single check that failed, with the message in place of a case."""
    nothing = Tolerance(0.0, "the case must be solved")
    check = Check(message, "solved", "1", 1.0, "-", 0.0, math.inf, nothing)
    return Outcome(checks=[check])
