"""Shards to one results file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tbi_cli.runner import this_command
from tbi_cli.store import DONE, FAILED, merge, open_results, provenance, studies_of


def join_shards(shards: Sequence[Path], output: Path, *, partial: bool, overwrite: bool) -> list[str]:
    """Merges shards and says in lines what came of it.  Raises StoreError for shards that do not fit."""
    here = provenance(case_yaml="", case_sha256="", command=this_command())
    path = merge(shards, output, partial=partial, overwrite=overwrite, attributes=here)
    status = statuses(path)
    done, failed = int(np.sum(status == DONE)), int(np.sum(status == FAILED))
    left = status.size - done - failed
    counts = f"{status.size} scenarios: {done} done, {failed} failed" + (f", {left} to do" if left else "")
    return [f"{len(shards)} shards joined, {counts}", f"results: {path}"]


def statuses(path: Path) -> NDArray[np.int8]:
    """The status of every scenario of a results file, study after study, (n,)."""
    found = []
    for study in studies_of(path) or ("",):
        with open_results(path, study=study) as results:
            found.append(results.status.ravel())
    return np.concatenate(found)
