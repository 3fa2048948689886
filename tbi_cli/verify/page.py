"""The verification as one self-contained HTML page: tables, curves over their references, case files."""

from __future__ import annotations

import io
import os
import platform
import tempfile
from collections.abc import Sequence
from datetime import UTC, datetime
from html import escape
from importlib.metadata import version
from pathlib import Path

import numpy as np

import tbi_cli
from tbi_cli.errors import UserError
from tbi_cli.verify.check import Curve
from tbi_cli.verify.references.parameters import Array
from tbi_cli.verify.run import Group
from tbi_cli.verify.table import HEADINGS, cells, verdict

# Points drawn of a history: twice as many as the figure has pixels across.
_POINTS = 900
_OURS = ("#c1272d", "#0b6fa4", "#2e7d32", "#8e5bb5")

_STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; max-width: 75rem; color: #1b1b1b; }
body { margin: 2rem auto; padding: 0 1rem; }
table { border-collapse: collapse; font-size: 13px; width: 100%; }
th, td { text-align: left; padding: .2rem .5rem; border-bottom: 1px solid #ddd; vertical-align: top; }
td.number { text-align: right; white-space: nowrap; font-variant-numeric: tabular-nums; }
.pass { color: #1b6b2f; } .fail { color: #fff; background: #b3261e; font-weight: 600; }
.notes { font-size: 13px; }
.scroll { overflow-x: auto; }
.curves { display: grid; grid-template-columns: repeat(auto-fill, minmax(30rem, 1fr)); gap: .5rem; }
.curves svg { width: 100%; height: auto; }
pre { background: #f5f5f5; padding: .6rem; overflow-x: auto; font-size: 12px; }
.signature td { height: 2.2rem; width: 33%; border-bottom: 1px solid #1b1b1b; }
@media print { details { display: none; } body { max-width: none; } }
"""


def write_page(path: Path, groups: Sequence[Group]) -> None:
    """Write the page in one go: under a temporary name beside it, then renamed.

    Raises OSError where the folder cannot be written.
    """
    text = page(groups)
    handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name[:40]}.", suffix=".tmp")
    try:
        with os.fdopen(handle, "w", encoding="utf-8") as file:
            file.write(text)
        umask = os.umask(0)
        os.umask(umask)
        Path(temporary).chmod(0o666 & ~umask)
        Path(temporary).replace(path)
    except BaseException:
        Path(temporary).unlink(missing_ok=True)
        raise


def check_page_path(path: Path) -> None:
    """Raise UserError unless the page can be written there: a new file, or in place of an earlier page."""
    start = b"<!DOCTYPE html>"
    try:
        folder_is_there = path.parent.is_dir()
        earlier = path.read_bytes()[: len(start)] if path.exists() else start
    except OSError as error:
        raise UserError(f"--output: {path}: {error.strerror}") from error
    if not folder_is_there:
        raise UserError(f"--output: expected a file in a folder that exists, got {path}")
    if earlier != start:
        raise UserError(f"--output: expected a new file or an earlier page, got {path}, which is neither")
    if not os.access(path.parent, os.W_OK | os.X_OK):
        raise UserError(f"--output: {path.parent}: cannot be written")


def page(groups: Sequence[Group]) -> str:
    """The whole page."""
    overview = "".join(map(_overview_row, groups))
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>tbi verification</title>'
        f"<style>{_STYLE}</style></head><body>\n<h1>Verification of tbi {escape(tbi_cli.__version__)}</h1>\n"
        f"<p><strong>{escape(verdict(list(groups)))}.</strong> Every case is a case file that was solved as "
        "<code>tbi run</code> solves it; what is compared was read back from the results file. A "
        "difference is "
        "relative to the size of the reference, or to what the quantity names after a slash.</p>\n"
        f"{_circumstances()}"
        "<h2>Overview</h2><table><tr><th>group</th><th>checks</th><th></th></tr>"
        f"{overview}</table>\n" + "".join(map(_group, groups)) + '<h2>Signature</h2><table class="signature">'
        "<tr><td>Name</td><td>Date</td><td>Signature</td></tr></table>\n</body></html>\n"
    )


def _overview_row(group: Group) -> str:
    v = group.verification
    link = f'<a href="#group-{v.number}">{v.number}. {escape(v.title)}</a>'
    return f"<tr><td>{link}</td><td>{len(group.outcome.checks)}</td>{_verdict_cell(group.passed)}</tr>"


def _circumstances() -> str:
    packages = ", ".join(f"{name} {version(name)}" for name in ("numpy", "scipy", "numba", "h5py"))
    rows = (
        ("Date", datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC")),
        ("Computer", f"{platform.node()}, {platform.machine()}, {platform.platform()}"),
        ("Software", f"tbi {tbi_cli.__version__}, Python {platform.python_version()}, {packages}"),
    )
    body = "".join(f"<tr><th>{escape(a)}</th><td>{escape(b)}</td></tr>" for a, b in rows)
    return f"<table>{body}</table>\n"


def _verdict_cell(passed: bool) -> str:
    return f'<td class="{"pass" if passed else "fail"}">{"pass" if passed else "FAIL"}</td>'


def _group(group: Group) -> str:
    v = group.verification
    head = "".join(f"<th>{escape(h)}</th>" for h in HEADINGS[:-1]) + "<th>note</th><th></th>"
    # The error estimates behind the tolerances, each once, in the order in which they are met.
    reasons = list(dict.fromkeys(check.tolerance.reason for check in group.outcome.checks))
    rows = []
    for check in group.outcome.checks:
        row = "".join(
            f'<td class="number">{escape(text)}</td>' if heading in _NUMBERS else f"<td>{escape(text)}</td>"
            for heading, text in zip(HEADINGS[:-1], cells(check)[:-1], strict=True)
        )
        note = reasons.index(check.tolerance.reason) + 1
        rows.append(f"<tr>{row}<td>{note}</td>{_verdict_cell(check.passed)}</tr>")
    notes = "".join(f"<li>{escape(reason)}</li>" for reason in reasons)
    curves = "".join(map(figure, group.outcome.curves))
    files = "".join(
        f"<details><summary>{escape(name)}.yaml</summary><pre>{escape(text.strip())}</pre></details>"
        for name, text in v.cases.items()
    )
    return (
        f'<h2 id="group-{v.number}">{v.number}. {escape(v.title)}</h2>\n<p>{escape(v.about)}</p>\n'
        f'<div class="scroll"><table><tr>{head}</tr>{"".join(rows)}</table></div>\n'
        f'<p>Where the tolerances come from:</p><ol class="notes">{notes}</ol>\n'
        f'<div class="curves">{curves}</div>\n{files}\n'
    )


_NUMBERS = ("reference", "ours", "difference", "tolerance")


def figure(curve: Curve) -> str:
    """One figure as SVG: the reference wide and grey, ours thin and coloured on top."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    with mpl.rc_context({"svg.fonttype": "none", "svg.hashsalt": curve.title, "font.size": 9}):
        drawing = Figure(figsize=(6.4, 3.4), layout="constrained")
        axes = drawing.add_subplot()
        ours = iter(_OURS)
        for line in curve.lines:
            x, y = thinned(line.x, line.y)
            if line.reference:
                axes.plot(x, y, color="#b9b9b9", linewidth=5, label=line.label, solid_capstyle="butt")
            else:
                mark = "o-" if len(x) < 20 else "-"
                axes.plot(x, y, mark, color=next(ours), linewidth=1.2, markersize=3.5, label=line.label)
        if curve.logarithmic:
            axes.set_xscale("log")
            axes.set_yscale("log")
        axes.set_title(curve.title, fontsize=9.5)
        axes.set_xlabel(curve.x_label)
        axes.set_ylabel(curve.y_label)
        axes.grid(color="#e5e5e5", linewidth=0.6)
        axes.legend(fontsize=8, frameon=False)
        buffer = io.StringIO()
        drawing.savefig(buffer, format="svg", metadata={"Date": None})
    svg = buffer.getvalue()
    return svg[svg.index("<svg") :]


def thinned(x: Array, y: Array) -> tuple[Array, Array]:
    """At most _POINTS points of a line: of each stretch the smallest and the largest value, in order."""
    if len(x) <= _POINTS:
        return x, y
    chosen: list[int] = []
    for stretch in np.array_split(np.arange(len(x)), _POINTS // 2):
        low, high = stretch[np.argmin(y[stretch])], stretch[np.argmax(y[stretch])]
        chosen += sorted({int(low), int(high)})
    return x[chosen], y[chosen]
