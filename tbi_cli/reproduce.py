"""The paper's studies run, one results file each, and its numbers beside ours."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from tbi_cli.case import load_case
from tbi_cli.report import claims
from tbi_cli.report.catalogue import catalogue
from tbi_cli.report.errors import ReportError
from tbi_cli.report.paper_tables import TABLES
from tbi_cli.report.study import open_studies
from tbi_cli.runner import Options, Progress, Summary, run
from tbi_cli.workers import Workers

NAME = "reproduce"


@dataclass(frozen=True)
class Files:
    """The entries as text, as CSV and as JSON."""

    text: Path
    csv: Path
    json: Path


def paper_cases() -> list[str]:
    """The built-in cases that hold the data of every figure and table of the paper."""
    names = [spec.case for spec in catalogue() if not any(panel.runs for panel in spec.panels)]
    names += [run.case for spec in catalogue() for panel in spec.panels for run in panel.runs]
    names += [spec.case for spec in TABLES]
    return list(dict.fromkeys(names))


def run_paper(
    folder: Path, *, workers: Workers, overwrite: bool, progress: Progress, stop: threading.Event
) -> list[Summary]:
    """Runs the paper's cases into `folder`; what an earlier run finished there is kept, unless `overwrite`.

    Ends early once `stop` is set.  Raises StoreError for files there that hold something else.
    """
    summaries: list[Summary] = []
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ReportError.from_os(folder, error) from error
    for name in paper_cases():
        output = folder / f"{name.replace('paper/', '')}.h5"
        progress.say(f"{name}: {output}")
        options = Options(
            output=output,
            workers=workers,
            resume=not overwrite,
            overwrite=overwrite,
            command=("tbi", "run", name, "-o", str(output)),
        )
        summaries.append(run(load_case(name), options, progress=progress, stop=stop))
        if summaries[-1].left:
            break
    return summaries


def compare(results: Sequence[Path]) -> list[claims.Entry]:
    """Every number of the paper beside what these results files hold.  Raises StoreError."""
    studies = open_studies(results)
    try:
        return claims.entries(studies)
    finally:
        for study in studies:
            study.results.close()


def write(entries: Sequence[claims.Entry], folder: Path) -> Files:
    """Writes the entries into `folder`.  Raises ReportError if the disk refuses."""
    files = Files(*(folder / f"{NAME}.{kind}" for kind in ("txt", "csv", "json")))
    try:
        folder.mkdir(parents=True, exist_ok=True)
        files.text.write_text(claims.to_text(entries), encoding="utf-8")
        files.csv.write_text(claims.table(entries).to_csv(), encoding="utf-8", newline="")
        files.json.write_text(claims.to_json(entries), encoding="utf-8")
    except OSError as error:
        raise ReportError.from_os(folder, error) from error
    return files
