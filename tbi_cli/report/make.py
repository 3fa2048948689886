"""A report from results files: what they hold, drawn, tabled and put into one folder."""

from __future__ import annotations

import os
import shlex
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import tbi_cli
from tbi_cli.report import claims
from tbi_cli.report.bridge_figures import bridge_figures
from tbi_cli.report.catalogue import catalogue
from tbi_cli.report.contact_figures import contact_figures
from tbi_cli.report.ensembles import ensemble_figures, ensemble_table, seeds_of
from tbi_cli.report.envelopes import envelope_figures
from tbi_cli.report.errors import ReportError
from tbi_cli.report.extremes import extremes
from tbi_cli.report.folder import check_folder, report_folder
from tbi_cli.report.generic_figures import generic_figures
from tbi_cli.report.missing import gaps, missing
from tbi_cli.report.page import Contents, page
from tbi_cli.report.paper_figures import Fit, fit_of, paper_figure
from tbi_cli.report.paper_tables import paper_tables
from tbi_cli.report.pictures import save_all
from tbi_cli.report.plot import Plot
from tbi_cli.report.resonance import resonance_table
from tbi_cli.report.study import Study, open_studies
from tbi_cli.report.table import Table
from tbi_cli.report.track_figures import track_figures
from tbi_cli.report.wishes import Wishes
from tbi_cli.resources import available_cpus

PAGE = "report.html"


@dataclass(frozen=True)
class Report:
    """What a report came to: its folder, figures and tables, and what it lacks."""

    folder: Path
    figures: tuple[Plot, ...]
    tables: tuple[Table, ...]
    gaps: tuple[str, ...]
    missing: tuple[tuple[str, str], ...]

    @property
    def page(self) -> Path:
        """The page."""
        return self.folder / PAGE


def default_folder(results: Sequence[Path]) -> Path:
    """Beside the first results file, named after it."""
    first = results[0]
    return first.parent / f"{first.name.removesuffix('.h5')}-report"


def make_report(
    results: Sequence[Path], folder: Path, wishes: Wishes | None = None, *, jobs: int | None = None
) -> Report:
    """Draws and tables all that the results files have data for, into `folder`.

    An earlier report there is replaced.  Raises ReportError for wishes that cannot be met and for a folder
    that may not be used, StoreError for results files that cannot be read.
    """
    wishes = wishes or Wishes()
    check_folder(folder)
    studies = open_studies(results)
    try:
        wishes.check(studies)
        select = wishes.selection(studies)
        figures = _figures(studies, wishes, select)
        if wishes.own_figures and not figures:
            raise ReportError(
                "no figure of that kind can be drawn from these results; their axes are shown by: "
                f"tbi info {shlex.quote(os.fspath(results[0]))}"
            )
        by_number = paper_tables(studies)
        tables = [table for table, _ in by_number.values()]
        tables += [table for study in studies if (table := ensemble_table(study))]
        tables += [table for study in studies if (table := resonance_table(study, select[study.name]))]
        drawn = {plot.name for plot in figures}
        absent = () if wishes.own_figures else missing(drawn, set(by_number), studies)
        holes = gaps(studies)
        known = [entry for entry in claims.entries(studies) if entry.ours is not None]
        of_paper = claims.table(known) if known else None
        largest = [extremes(study) for study in studies]
        with report_folder(folder) as scratch:
            pictures = save_all(figures, scratch, wishes.formats, jobs or available_cpus())
            for table in (*tables, *largest, *([of_paper] if of_paper else [])):
                (scratch / f"{table.name}.csv").write_text(table.to_csv(), encoding="utf-8", newline="")
            contents = Contents(
                heading="Train-bridge interaction",
                about=(_about(studies),),
                gaps=holes,
                missing=absent,
                studies=tuple(studies),
                tables=tuple(tables),
                claims=of_paper,
                figures=tuple(zip(figures, pictures, strict=True)),
                extremes=tuple(largest),
            )
            (scratch / PAGE).write_text(page(contents), encoding="utf-8", errors="replace")
    finally:
        for study in studies:
            study.results.close()
    return Report(folder, tuple(figures), (*tables, *largest), holes, absent)


def _figures(studies: Sequence[Study], wishes: Wishes, select: dict[str, dict[str, int]]) -> list[Plot]:
    """The paper's figures, then those of the studies that no figure of the paper shows in full."""
    if wishes.own_figures:
        return [plot for study in studies for plot in _others(study, wishes, select[study.name])]
    figures: list[Plot] = []
    used: dict[str, list[Fit]] = {study.name: [] for study in studies}
    for spec in catalogue():
        found = paper_figure(spec, studies, select)
        if found is not None:
            plot, fits = found
            figures.append(plot)
            for fit in fits:
                used[fit.study.name].append(fit)
            for study in studies:
                # A study that has the same figure's data is no stranger, unless its case is another.
                other = fit_of(spec, study, select[study.name])
                if other is not None and _same_case(study, fits[0].study):
                    used[study.name].append(other)
    for study in studies:
        figures += track_figures(study, select[study.name])
        figures += [plot for plot in contact_figures(study, select[study.name]) if not plot.empty]
        of_bridge = [plot for plot in bridge_figures(study, select[study.name]) if not plot.empty]
        figures += of_bridge
        figures += envelope_figures(study, select[study.name])
        if not _shown(study, used[study.name], select[study.name]):
            # What is at mid-span stands in those figures already.
            seen = {f"{study.name}-midspan"} if any("-deck" in plot.name for plot in of_bridge) else set()
            others = _others(study, wishes, select[study.name])
            figures += [plot for plot in others if not plot.name.startswith(tuple(seen))]
    return figures


def _others(study: Study, wishes: Wishes, select: dict[str, int]) -> Iterator[Plot]:
    """Figures of a study that no figure of the paper shows: of an ensemble as bands, else as curves."""
    seeds = seeds_of(study)
    spread = seeds is not None and seeds.name not in select
    if spread and not wishes.heat_map and study.axis(wishes.family or wishes.x or "") is not seeds:
        return ensemble_figures(study, wishes, select)
    return generic_figures(study, wishes, select)


def _shown(study: Study, fits: Sequence[Fit], select: dict[str, int]) -> bool:
    """Whether figures of the paper show all axes that vary in a study."""
    varied = {axis.name for axis in study.varied} - set(select)
    return bool(fits) and varied <= {name for fit in fits for name in fit.used}


def _same_case(study: Study, other: Study) -> bool:
    if study.case is None or other.case is None:
        return study is other
    return study.case.train == other.case.train and study.case.bridge == other.case.bridge


def _about(studies: Sequence[Study]) -> str:
    names = ", ".join(dict.fromkeys(study.results.path.name for study in studies))
    made = time.strftime("%Y-%m-%d %H:%M")
    return f"Made by tbi {tbi_cli.__version__} on {made} from {names}."
