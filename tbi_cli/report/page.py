"""report.html: one file that needs nothing else, every word from elsewhere escaped."""

from __future__ import annotations

import base64
import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from html import escape as escape_html
from importlib import resources
from typing import Any

from tbi_cli.report.interactive import interactive
from tbi_cli.report.plot import Plot
from tbi_cli.report.study import Study
from tbi_cli.report.table import Cell, Table, shown
from tbi_cli.store import StoreError

# Of all pictures and all plots on a page, in bytes; plotly.js itself takes 4.8 MB of the 10 MB.
_PICTURES, _PLOTS = 3_400_000, 1_300_000
_MOST_ROWS = 60  # of a table that stands open on the page
_WIDE = 24  # characters: longer texts in a table are wrapped
_LEFT_OUT = "Left out of this page for its size; the files beside it have it."


@dataclass(frozen=True)
class Contents:
    """What a page shows."""

    heading: str
    about: tuple[str, ...]
    gaps: tuple[str, ...]
    missing: tuple[tuple[str, str], ...]  # what, and the command that produces it
    studies: tuple[Study, ...]
    tables: tuple[Table, ...]
    claims: Table | None
    figures: tuple[tuple[Plot, bytes], ...]
    extremes: tuple[Table, ...]


def escape(text: str) -> str:
    """Text for HTML, without what no one can see."""
    return escape_html("".join(c if c.isprintable() or c == "\n" else " " for c in text))


def page(contents: Contents) -> str:
    """The whole page as text."""
    sections = [
        ("summary", "Summary", _summary(contents)),
        ("figures", "Figures", _figures(contents.figures)),
        ("tables", "Tables", "".join(_listed(table) for table in contents.tables)),
        ("claims", "The paper's numbers", _claims(contents.claims) if contents.claims else ""),
        ("extremes", "Extremes", "".join(_folded(table) for table in contents.extremes)),
        ("cases", "Cases and provenance", "".join(_study(study) for study in contents.studies)),
    ]
    kept = [(key, title, body) for key, title, body in sections if body]
    links = " ".join(f'<a href="#{key}">{escape(title)}</a>' for key, title, _ in kept)
    body = "".join(f'<h2 id="{key}">{escape(title)}</h2>\n{text}' for key, title, text in kept)
    about = "".join(f'<p class="about">{escape(line)}</p>' for line in contents.about)
    scripts = ""
    if 'class="plot"' in body:
        scripts = f"<script>{_plotly()}</script>\n<script>{_part('page.js')}</script>"
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        '<link rel="icon" href="data:,">\n'
        f"<title>{escape(contents.heading)}</title>\n<style>\n{_part('page.css')}</style>\n</head>\n<body>\n"
        f"<header><h1>{escape(contents.heading)}</h1>{about}<nav>{links}</nav></header>\n"
        f"<main>\n{body}</main>\n{scripts}\n</body>\n</html>\n"
    )


def _summary(contents: Contents) -> str:
    parts = [f'<div class="gap">{escape(gap)}</div>' for gap in contents.gaps]
    links = " ".join(
        f'<a href="#{escape(plot.name)}" title="{escape(plot.heading)}">{escape(_short(plot))}</a>'
        for plot, _ in contents.figures
    )
    parts.append(f"<nav>{links}</nav>" if links else "<p>No figure could be drawn from these results.</p>")
    if contents.missing:
        parts.append("<p>Not drawn, because the results do not hold the data:</p>")
        rows = tuple((what, command) for what, command in contents.missing)
        parts.append(_grid(("what", "command that produces it"), rows))
    return "".join(parts)


def _short(plot: Plot) -> str:
    """ "Fig. 15" for a figure of the paper, the whole heading for any other."""
    return ". ".join(plot.heading.split(". ")[:2]) if plot.heading.startswith("Fig. ") else plot.heading


def _figures(figures: Sequence[tuple[Plot, bytes]]) -> str:
    pictures = plots = 0
    parts = []
    for plot, picture in figures:
        data = interactive(plot)
        text = _json(data) if data else ""
        lively = bool(text) and plots + len(text) <= _PLOTS
        plots += len(text) if lively else 0
        image = ""
        size = len(picture) * 4 // 3
        if pictures + size <= _PICTURES:
            pictures += size
            source = base64.b64encode(picture).decode("ascii")
            image = f'<img alt="{escape(plot.heading)}" src="data:image/png;base64,{source}">'
        parts.append("".join(_figure(plot, text if lively else "", image)))
    return "\n".join(parts)


def _figure(plot: Plot, data: str, image: str) -> Iterator[str]:
    name = escape(plot.name)
    yield f'<figure id="{name}"><h3>{escape(plot.heading)}</h3>'
    if data:
        yield f'<div class="plot" data-from="data-{name}"></div>'
        yield f'<script type="application/json" id="data-{name}">{data}</script>'
        if image:
            yield f"<details><summary>as printed</summary>{image}</details>"
    else:
        yield image or f'<p class="note">{_LEFT_OUT}</p>'
    yield f"<figcaption>{escape(' '.join((plot.caption, *plot.notes)))}</figcaption></figure>"


def _table(table: Table) -> str:
    note = f'<p class="note">{escape(table.note)}</p>' if table.note else ""
    return f"<h3>{escape(table.heading)}</h3>{_grid(table.columns, table.rows)}{note}"


def _listed(table: Table) -> str:
    return _table(table) if len(table.rows) <= _MOST_ROWS else _folded(table)


def _claims(table: Table) -> str:
    """The paper's numbers, then its statements; their keys and columns with nothing in them are left out."""
    paper = table.columns.index("paper")
    grids = []
    for stated in (False, True):
        rows = [row for row in table.rows if isinstance(row[paper], str) is stated]
        filled = [any(row[k] not in (None, "") for row in rows) for k in range(len(table.columns))]
        used = [k for k, name in enumerate(table.columns) if filled[k] and name != "id"]
        if rows:
            grids.append(_grid([table.columns[k] for k in used], [[row[k] for k in used] for row in rows]))
    return f'<h3>{escape(table.heading)}</h3>{"".join(grids)}<p class="note">{escape(table.note)}</p>'


def _folded(table: Table) -> str:
    note = f'<p class="note">{escape(table.note)}</p>' if table.note else ""
    grid = _grid(table.columns, table.rows)
    return f"<details><summary>{escape(table.heading)}</summary>{grid}{note}</details>"


def _grid(columns: Sequence[str], rows: Sequence[Sequence[Cell]]) -> str:
    texts = [any(isinstance(row[k], str) for row in rows) for k in range(len(columns))]
    head = "".join(
        f"<th{' class=text' if text else ''}>{escape(column)}</th>"
        for column, text in zip(columns, texts, strict=True)
    )
    body = "".join(
        "<tr>" + "".join(_cell(cell, text) for cell, text in zip(row, texts, strict=True)) + "</tr>"
        for row in rows
    )
    return f'<div class="scroll"><table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table></div>'


def _cell(cell: Cell, text: bool) -> str:
    words = shown(cell)
    kind = ' class="text wide"' if len(words) > _WIDE else " class=text" if text else ""
    return f"<td{kind}>{escape(words)}</td>"


def _study(study: Study) -> str:
    results = study.results
    rows: list[tuple[Cell, ...]] = [("file", results.path.name)]
    for axis in study.axes:
        ends = f"{axis.values[0]:.6g} to {axis.values[-1]:.6g}" if axis.varies else f"{axis.values[0]:.6g}"
        unit = "" if axis.dim.units == "1" else f" {axis.dim.units}"
        rows.append((f"axis {axis.name}", f"{ends}{unit}, {len(axis.values)} value{'s' * axis.varies}"))
    done = study.status.size - study.to_do - study.failed
    rows.append(("scenarios", f"{done} done, {study.failed} failed, {study.to_do} to do"))
    rows += [
        (key, _plain(value)) for key, value in results.attributes.items() if key not in ("case", "title")
    ]
    case = f"<details><summary>the resolved case</summary><pre>{escape(results.case_yaml)}</pre></details>"
    failures = [f"scenario {index}: {text}" for index, text in _messages(study)]
    note = f"<pre>{escape(chr(10).join(failures))}</pre>" if failures else ""
    return f"<h3>{escape(study.title)}</h3>{_grid(('', ''), rows)}{note}{case}"


def _messages(study: Study, most: int = 20) -> list[tuple[int, str]]:
    try:
        return list(study.results.messages.items())[:most] if study.failed else []
    except StoreError as error:
        return [(-1, str(error))]


def _plain(value: object) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def _json(data: dict[str, Any]) -> str:
    """JSON that no text in it can end the script element of."""
    text = json.dumps(data, separators=(",", ":"), ensure_ascii=False)
    return text.replace("<", "\\u003c").replace("\u2028", "\\u2028").replace("\u2029", "\\u2029")


def _part(name: str) -> str:
    return resources.files("tbi_cli.report").joinpath(name).read_text(encoding="utf-8")


def _plotly() -> str:
    from plotly.offline import get_plotlyjs

    return str(get_plotlyjs())
