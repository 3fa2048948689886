"""`tbi report`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tbi_cli.cli import options


def report(
    results: Annotated[
        list[Path],
        typer.Argument(
            readable=False, metavar="RESULTS.h5", help="Results files, finished or not.", show_default=False
        ),
    ],
    output: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--output",
            readable=False,
            help="Folder of the report.  [default: RESULTS-report, beside the first file]",
        ),
    ] = None,
    channels: Annotated[
        list[str] | None,
        typer.Option(
            "--channels",
            metavar="NAME,...",
            help="Draw these instead of the paper's figures, e.g. car_body_y,daf/right,wheel_*.",
        ),
    ] = None,
    x: Annotated[
        str | None,
        typer.Option("--x", metavar="AXIS", help="The axis to draw over, or time.  [default: the last]"),
    ] = None,
    family: Annotated[
        str | None,
        typer.Option(
            "--family",
            metavar="AXIS",
            help="The axis of which every value is a curve, or none.  [default: the last but one]",
        ),
    ] = None,
    select: Annotated[
        list[str] | None,
        typer.Option(
            "--select",
            metavar="AXIS=VALUE",
            help="Where another axis stands, e.g. car_body_mass='40 t'.  Repeatable.",
        ),
    ] = None,
    heat_map: Annotated[
        bool, typer.Option("--heat-map", help="Draw values over two axes, in colour.")
    ] = False,
    formats: Annotated[
        str, typer.Option("--formats", metavar="NAME,...", help="Of the figure files: png, pdf, svg.")
    ] = "png,pdf,svg",
    jobs: Annotated[
        int | None,
        typer.Option(
            "-j", "--jobs", min=1, help="Figures drawn at a time.  [default: the CPUs this job may use]"
        ),
    ] = None,
    quiet: options.Quiet = False,
) -> None:
    """Draw figures and tables of results files, and one page of all.

    Of the paper's figures 4-29 and tables 2-5 what the files hold, and figures of any other sweep.
    """
    from tbi_cli.report.make import default_folder, make_report
    from tbi_cli.report.wishes import Wishes

    wishes = Wishes(
        channels=_listed(channels or []),
        x=x,
        family=family,
        select=tuple(select or ()),
        heat_map=heat_map,
        formats=_listed([formats]),
    )
    made = make_report(results, output or default_folder(results), wishes, jobs=jobs)
    if quiet:
        return
    for gap in made.gaps:
        print(gap)
    names = ", ".join(plot.name for plot in made.figures)
    print(f"figures: {len(made.figures)}" + (f" ({names})" if names else ""))
    print(f"tables: {', '.join(table.name for table in made.tables)}")
    for what, command in made.missing:
        print(f"missing: {what}: {command}")
    print(f"report: {made.page}")


def _listed(texts: list[str]) -> tuple[str, ...]:
    return tuple(word.strip() for text in texts for word in text.split(",") if word.strip())
