"""What a report lacks, with the command that would produce it."""

from __future__ import annotations

import re
import shlex
from collections.abc import Sequence
from pathlib import Path

from tbi_cli.advice import go_on, join, without
from tbi_cli.report.catalogue import FigureSpec, catalogue
from tbi_cli.report.paper_figures import run_of
from tbi_cli.report.paper_tables import TABLES
from tbi_cli.report.study import Study

_ALL = "paper/all"  # the built-in case of all studies


def missing(drawn: set[str], tables: set[int], studies: Sequence[Study]) -> tuple[tuple[str, str], ...]:
    """What of the paper's figures and tables is not there: (what, command), one line for each command.

    Studies that share no figure with the paper get a single line, with the command for everything.
    """
    wanted: dict[str, list[str]] = {}
    for spec in catalogue():
        for case in _cases(spec, studies):
            if spec.name not in drawn or any(panel.runs for panel in spec.panels):
                wanted.setdefault(case, []).append(f"Fig. {spec.number}")
    for table in TABLES:
        if table.number not in tables:
            wanted.setdefault(table.case, []).append(f"Table {table.number}")
    if drawn.isdisjoint(spec.name for spec in catalogue()):
        everything = [name for names in wanted.values() for name in names]
        return ((_listed(list(dict.fromkeys(everything))), f"tbi run {_ALL}"),)
    return tuple((_listed(what), f"tbi run {case}") for case, what in wanted.items())


def _listed(names: Sequence[str]) -> str:
    """ "Figs. 22-25, 27-29, Table 5" for the names one by one."""
    numbers = sorted({int(name.removeprefix("Fig. ")) for name in names if name.startswith("Fig. ")})
    runs: list[list[int]] = []
    for number in numbers:
        if runs and number == runs[-1][-1] + 1:
            runs[-1].append(number)
        else:
            runs.append([number])
    texts = [f"{run[0]}-{run[-1]}" if len(run) > 1 else str(run[0]) for run in runs]
    figures = [f"Fig{'s' * (len(numbers) > 1)}. {', '.join(texts)}"] if texts else []
    return ", ".join([*figures, *sorted(name for name in names if name.startswith("Table"))])


def _cases(spec: FigureSpec, studies: Sequence[Study]) -> list[str]:
    """The built-in cases whose results a figure lacks."""
    runs = [run for panel in spec.panels for run in panel.runs]
    if not runs:
        return [spec.case]
    return [run.case for run in runs if run_of(run, studies) is None]


def gaps(studies: Sequence[Study]) -> tuple[str, ...]:
    """What is not computed in these studies, and how to go on."""
    found = []
    for study in studies:
        count, name = study.status.size, study.results.path.name
        refined = any(axis.refined for axis in study.axes)
        if study.to_do or refined:
            text = (
                f"{name}: {study.to_do} of {count} scenarios are not solved yet; curves and tables have gaps"
            )
            if refined:
                done = count - study.to_do - study.failed
                text = f"{name}: not finished, {done} scenarios are solved; refinement adds more"
            found.append(f"{text}; {_how_to_go_on(study)}")
        unsettled = 0 if study.results.unsettled is None else len(study.results.unsettled)
        if unsettled and not refined:
            text = "the tolerance of the refined sweep was not reached"
            found.append(f"{name}: {text} at {unsettled} of {count} scenarios")
        if study.failed:
            first = next(iter(study.results.messages.values()), "")
            found.append(
                f"{name}: {study.failed} of {count} scenarios failed"
                + (f" (the first: {first})" if first else "")
            )
    return tuple(found)


def _how_to_go_on(study: Study) -> str:
    """The command of the unfinished run, to be resumed; a shard has to be joined with the others instead."""
    attributes, path = study.results.attributes, study.results.path
    folder = str(attributes.get("folder", ""))
    if "shard" in attributes and study.results.finished:
        return _join(path, str(attributes["shard"]))
    if "shard_command" in attributes:
        # What joined shards lack is solved by the command of one of them, which solves all that is left.
        command = without(_words(attributes["shard_command"]), {"--requeue"}, {"--shard", "-o", "--output"})
        return go_on([*command, "-o", str(path.absolute())], str(attributes.get("shard_folder", "")))
    return go_on(_words(attributes.get("command", "")), folder)


def _join(path: Path, shard: str) -> str:
    """How a shard is joined with the others, which are beside it where it has the name of a shard."""
    of = shard.partition("/")[2]
    found = re.fullmatch(rf"(.+)\.shard-[0-9]+-of-{of}", path.stem)
    if found is None:
        return f"this is shard {shard}: join it with the others by tbi merge SHARDS -o RESULTS.h5"
    stem, ending = (shlex.quote(text) for text in (found[1], path.suffix))
    command = f"{stem}.shard-*-of-{of}{ending if path.suffix else ''}"
    return f"this is shard {shard}: {join(command, found[1] + path.suffix, str(path.parent.absolute()))}"


def _words(command: object) -> list[str]:
    try:
        return shlex.split(str(command))
    except ValueError:
        return []
