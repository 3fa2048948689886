"""Joining the shards of a run into one results file."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tbi_cli.advice import ANOTHER_FILE
from tbi_cli.store.assemble import write_results
from tbi_cli.store.claim import Claim, check_output
from tbi_cli.store.compare import refuse_other_run
from tbi_cli.store.errors import StoreError
from tbi_cli.store.layout import Layout, Scalar
from tbi_cli.store.opening import check_same_grid, is_there, open_results, resolve
from tbi_cli.store.parts import parts_folder
from tbi_cli.store.picked import MovedSource, numbers_in, refined_axis, settled, with_values
from tbi_cli.store.results import Results
from tbi_cli.store.sources import Source
from tbi_cli.store.studies import Heading, heading_of, write_studies

_SHOWN = 20  # shards or cases named in a message


def merge(
    paths: Sequence[str | os.PathLike[str]],
    out: str | os.PathLike[str],
    *,
    partial: bool = False,
    overwrite: bool = False,
    attributes: Mapping[str, Scalar] | None = None,
) -> Path:
    """Write the results of all shards of one run into the file ``out`` and return its path.

    The shards are results files, or the parts of shards that are still running.  ``attributes`` replace those
    of the first shard (command, host, time of creation).  Raises `StoreError` for a gap (shards that are
    missing or not finished; with ``partial`` their cases stay to be done), for a shard or a case that comes
    twice, for shards of different cases, versions or numbers of shards, and if ``out`` cannot be written.
    """
    target = check_output(out, overwrite=overwrite, resumes=False)
    if target in {resolve(path) for path in paths}:
        raise StoreError(f"{target}: is one of the shards; {ANOTHER_FILE}")
    there: list[Path] = []
    absent: list[Path] = []
    for path in map(resolve, paths):
        (there if is_there(path) or is_there(parts_folder(path)) else absent).append(path)
    if absent and not (partial and there):
        raise StoreError(f"missing: {_list([str(p) for p in absent])}")
    headings = [heading_of(path) for path in there]
    if headings:
        _check_studies(there, headings)
    new = attributes or {}
    with ExitStack() as stack:
        found: dict[str, Results] = {}
        for name in headings[0].names if headings and headings[0].names else ("",):
            shards = [stack.enter_context(open_results(path, study=name)) for path in there]
            found[name] = _joined(target, shards, new, partial=partial)
        claim = Claim(target)
        try:
            if "" in found:
                write_results(target, claim.folder, found[""].layout, found[""])
            else:
                root = {k: v for k, v in headings[0].attributes.items() if k != "shard"}
                write_studies(target, claim.folder, {**root, **new}, found)
        finally:
            claim.clean(parts=True)
            claim.release()
    return target


def _check_studies(paths: Sequence[Path], headings: Sequence[Heading]) -> None:
    """Raises `StoreError` if files have not all the same studies, of one case and version."""
    first = headings[0]
    for path, heading in zip(paths, headings, strict=True):
        if bool(heading.names) != bool(first.names):
            raise StoreError(f"{path}: holds {_studies(heading)}, {paths[0]} {_studies(first)}")
        if heading.names:
            old, new = ({**h.attributes, "shard": ""} for h in (heading, first))
            refuse_other_run(str(path), old, new, f"{paths[0]} sets the measure")


def _studies(heading: Heading) -> str:
    return "several studies" if heading.names else "one grid"


def _joined(
    target: Path, shards: Sequence[Results], attributes: Mapping[str, Scalar], *, partial: bool
) -> Results:
    """The results of one grid, all shards together."""
    shard_numbers = _check_shards(shards)
    layout = _layout(shards, attributes)
    sources: list[Source] = []
    unsettled: list[NDArray[np.int64]] = []
    for shard in shards:
        numbers = _numbers(shard, layout)
        sources += [MovedSource(source, numbers) for source in shard.sources]
        if shard.unsettled is not None:
            unsettled.append(numbers[shard.unsettled])
    results = Results(
        target, layout, sources, finished=False, unsettled=np.concatenate(unsettled) if unsettled else None
    )
    if not partial:
        _refuse_gaps(shard_numbers, shards, results)
        results.layout = settled(layout)
    return results


def _numbers(shard: Results, layout: Layout) -> NDArray[np.int64]:
    """The flat index in the whole grid of each case of a shard, which of a refined grid has some speeds."""
    return numbers_in(shard.layout.dims, [dim.values for dim in layout.dims])


def _check_shards(shards: Sequence[Results]) -> tuple[set[int], int]:
    """The numbers of the shards, and of how many; raises `StoreError` if they do not belong together."""
    if not shards:
        raise StoreError("no shards to merge")
    first = shards[0]
    found: dict[int, Path] = {}
    count = 0
    for shard in shards:
        number, of = _shard_number(shard)
        if count and of != count:
            raise StoreError(f"{shard.path}: is one of {of} shards, {first.path} one of {count}")
        count = of
        if number in found:
            raise StoreError(f"{shard.path}: is shard {number}/{of}, and so is {found[number]}")
        found[number] = shard.path
        old, new = ({**s.layout.attributes, "shard": ""} for s in (shard, first))
        refuse_other_run(str(shard.path), old, new, f"{first.path} sets the measure")
        check_same_grid(shard.layout, first.layout, shard.path)
    whole = _together(shards)
    solved = np.zeros(whole.size, dtype=bool)
    for shard in shards:
        own = np.zeros(whole.size, dtype=bool)
        own[_numbers(shard, whole)] = shard.status.ravel() != 0
        if (solved & own).any():
            index = int(np.flatnonzero(solved & own)[0])
            raise StoreError(f"{shard.path}: holds case {index}, which another shard holds too")
        solved |= own
    return set(found), count


def _shard_number(shard: Results) -> tuple[int, int]:
    text = str(shard.layout.attributes.get("shard", ""))
    match = re.fullmatch(r"([1-9][0-9]{0,8})/([1-9][0-9]{0,8})", text)
    if match is None or int(match[1]) > int(match[2]):
        raise StoreError(f"{shard.path}: is not a shard of a run")
    return int(match[1]), int(match[2])


def _layout(shards: Sequence[Results], attributes: Mapping[str, Scalar]) -> Layout:
    """The layout of the whole; the units of the history channels are known where there is a history."""
    first = _together(shards)
    channels = next((s.history_channels for s in shards if s.history_indices()), first.history_channels)
    kept = {k: v for k, v in first.attributes.items() if k != "shard"}
    kept |= {f"shard_{key}": kept[key] for key in ("command", "folder") if key in kept}
    return replace(first, history_channels=channels, attributes={**kept, **attributes})


def _together(shards: Sequence[Results]) -> Layout:
    """The layout of the first shard, on a refined axis with the values of all."""
    first = shards[0].layout
    axis = refined_axis(first)
    if axis is None:
        return first
    return with_values(first, axis, np.unique(np.concatenate([s.layout.dims[axis].values for s in shards])))


def _refuse_gaps(numbers: tuple[set[int], int], shards: Sequence[Results], results: Results) -> None:
    found, count = numbers
    missing = [f"{i}/{count}" for i in range(1, count + 1) if i not in found]
    if missing:
        raise StoreError(f"missing shards: {_list(missing)}; --partial leaves their cases to be done")
    running = [str(shard.path) for shard in shards if not shard.finished]
    if running:
        raise StoreError(f"not finished: {_list(running)}; --partial leaves their cases to be done")
    to_do = np.flatnonzero(results.status.ravel() == 0)
    if len(to_do):
        raise StoreError(
            f"no shard holds {len(to_do)} of the cases, the first is {to_do[0]}; "
            "--partial leaves them to be done"
        )


def _list(names: Sequence[str]) -> str:
    more = len(names) - _SHOWN
    return ", ".join(names[:_SHOWN]) + (f" and {more} more" if more > 0 else "")
