"""What a report lacks, with the command that would produce it."""

from __future__ import annotations

import shlex
from collections.abc import Sequence

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
    if "shard" in study.results.attributes and study.results.finished:
        return "this is a shard: join it with the others by tbi merge"
    try:
        command = shlex.split(str(study.results.attributes.get("command", "")))
    except ValueError:
        command = []
    if not command:
        return "run it again with --resume"
    kept = [word for word in command if word not in ("--overwrite", "--resume")]
    return f"continue with: {shlex.join([*kept, '--resume'])}"
