"""The files of a run, be it one, or shards beside it or sent to a cluster, and the case that they hold."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from tbi_cli.case import Case
from tbi_cli.cluster.job import submission_folder
from tbi_cli.cluster.submission import read_note
from tbi_cli.errors import UserError
from tbi_cli.report.stored_case import stored_case
from tbi_cli.shards import Shard
from tbi_cli.store import Results, StoreError, heading_of, open_parts, open_results, studies_of
from tbi_cli.store.errors import is_missing
from tbi_cli.store.layout import MOST_CASES
from tbi_cli.store.opening import is_there
from tbi_cli.store.parts import parts_folder


@dataclass(frozen=True)
class Opened:
    """A file and what it holds by study; nothing before its first batch."""

    path: Path | None
    shard: Shard | None
    results: Mapping[str, Results]


def files_of(path: Path) -> list[tuple[Path, Shard | None]]:
    """The files that a path stands for: itself, or the shards that were sent off or lie beside it."""
    if is_there(path) or is_there(parts_folder(path)):
        return [(path, None)]
    note = read_note(submission_folder(path))
    if note is None:
        return [(shard.path(path), shard) for shard in _shards_at(path)] or [(path, None)]
    sent = submission_folder(path) / "shards" / path.name
    # One stands for all that are not begun, so that their number is known.
    shards = {shard for shard in _shards_at(sent) if shard.of == note["shards"]} or {Shard(1, note["shards"])}
    return [(shard.path(sent), shard) for shard in shards]


def _shards_at(path: Path) -> set[Shard]:
    """The shards of a results file that are begun or finished in its folder."""
    try:
        found = [Shard.of_path(file, path) for file in path.parent.iterdir()]
    except OSError as error:
        if is_missing(error):
            return set()
        raise StoreError.from_os(path.parent, error) from error
    return {shard for shard in found if shard is not None}


def opened_by_study(path: Path) -> dict[str, Results]:
    """What a run has written so far, by study; nothing before its first batch."""
    found = {}
    for study in studies_of(path) or ("",):
        results = open_parts(path, study)
        if results is None and is_there(path):
            results = open_results(path, study=study)
        if results is not None:
            found[study] = results
    return found


def shard_in(path: Path, results: Mapping[str, Results]) -> Shard | None:
    texts = [str(part.attributes.get("shard", "")) for part in results.values()]
    try:
        return Shard.parse(texts[0]) if texts and texts[0] else None
    except UserError:
        raise StoreError(f"{path}: is not a shard of a run") from None


def case_of(opened: Sequence[Opened], case: Case | None, named: Path) -> Case:
    """The case of all files; raises UserError if they are of several."""
    for file in opened:
        if not file.results or file.path is None:
            continue
        whole = file.results[""].attributes if "" in file.results else heading_of(file.path).attributes
        if case is None:
            case = stored_case(str(whole.get("case", "")))
            if case is None:
                raise UserError(f"{file.path}: holds a case that this version of tbi cannot read")
        if whole.get("case_sha256") != case.sha256 or not _fits(file.results, case):
            raise UserError(f"{file.path}: holds another case")
    if case is None:
        raise UserError(f"{named}: nothing has been computed yet")
    return case


def _fits(results: Mapping[str, Results], case: Case) -> bool:
    """Whether grids have the shapes of those of a case; a refined axis keeps but some of its values."""
    grids = case.studies or {"": case}
    return all(name in grids and _has_shape(found, grids[name]) for name, found in results.items())


def _has_shape(found: Results, case: Case) -> bool:
    wanted = [len(axis) for axis in case.axes] or [1]
    refined = [axis.refinement is not None for axis in case.axes] or [False]
    return (
        len(found.shape) == len(wanted)
        and all(n == m or (n < m and may) for n, m, may in zip(found.shape, wanted, refined, strict=True))
        and math.prod(wanted) <= MOST_CASES
    )
