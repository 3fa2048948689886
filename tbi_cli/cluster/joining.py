"""Shards to one results file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from tbi_cli.runner import this_command
from tbi_cli.store import DONE, FAILED, merge, open_results, provenance


def join_shards(shards: Sequence[Path], output: Path, *, partial: bool, overwrite: bool) -> list[str]:
    """Merges shards and says in lines what came of it.  Raises StoreError for shards that do not fit."""
    here = provenance(case_yaml="", case_sha256="", command=this_command())
    path = merge(shards, output, partial=partial, overwrite=overwrite, attributes=here)
    with open_results(path) as results:
        status = results.status
    done, failed = int(np.sum(status == DONE)), int(np.sum(status == FAILED))
    left = status.size - done - failed
    counts = f"{status.size} scenarios: {done} done, {failed} failed" + (f", {left} to do" if left else "")
    return [f"{len(shards)} shards joined, {counts}", f"results: {path}"]
