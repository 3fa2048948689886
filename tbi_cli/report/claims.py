"""Every number that the paper states, beside ours."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from tbi_cli.report.catalogue import data_file
from tbi_cli.report.evidence import Evidence, si
from tbi_cli.report.readings import read
from tbi_cli.report.statements import check
from tbi_cli.report.study import Study
from tbi_cli.report.table import Cell, Table


@dataclass(frozen=True)
class Entry:
    """One number or statement of the paper, and ours (None where the results do not have it)."""

    id: str
    where: str
    what: str
    unit: str
    trust: str
    note: str
    paper: float | str
    ours: float | str | None
    holds: bool | None = None  # of a statement

    @property
    def difference(self) -> float | None:
        """Ours less the paper's; what is only rounding of the last bits is none."""
        if not isinstance(self.ours, float) or not isinstance(self.paper, float):
            return None
        away = self.ours - self.paper
        return 0.0 if abs(away) < 1e-12 * abs(self.paper) else away

    @property
    def percent(self) -> float | None:
        """The difference in percent of the paper's number."""
        if self.difference is None or not self.paper or isinstance(self.paper, str):
            return None
        return 100 * self.difference / self.paper


def entries(studies: Sequence[Study]) -> list[Entry]:
    """All entries of claims.yaml, in its order; a list of numbers is an entry for each."""
    evidence = Evidence(studies)
    return [
        entry for name, claim in data_file("claims.yaml").items() for entry in _entries(evidence, name, claim)
    ]


def _entries(evidence: Evidence, name: str, claim: Mapping[str, Any]) -> Iterator[Entry]:
    common = {
        "where": claim["where"],
        "unit": claim.get("unit", ""),
        "trust": claim.get("trust", "reported"),
        "note": claim.get("note", ""),
    }
    what, how = claim["what"], claim["read"]
    if "statement" in claim:
        parts = check(evidence, how["check"])
        said = "; ".join(text if holds else f"NOT: {text}" for text, holds in parts)
        holds = all(holds for _, holds in parts) if parts else None
        yield Entry(name, what=what, paper=claim["statement"], ours=said or None, holds=holds, **common)
    elif "by" in claim:
        ((key, values),) = claim["by"].items()
        for given, value in values.items():
            ours = read(evidence, how, {key: si(key, given)})
            shown = f"{given} s" if key == "sampling" else given
            yield Entry(name, what=f"{what}: {shown}", paper=float(value), ours=_number(ours), **common)
    else:
        ours = read(evidence, how, {})
        stated = claim["value"] if isinstance(claim["value"], list) else [claim["value"]]
        found = ours if isinstance(ours, list) else [ours]
        for k, value in enumerate(stated):
            mine = _number(found[k]) if k < len(found) else None
            text = f"{what} ({k + 1})" if len(stated) > 1 else what
            yield Entry(name, what=text, paper=float(value), ours=mine, **common)


def _number(value: object) -> float | None:
    return float(value) if isinstance(value, int | float) else None


def table(found: Sequence[Entry]) -> Table:
    """The entries as a table."""
    heads = ("id", "where", "what", "unit", "paper", "ours", "difference", "difference [%]", "trust", "note")
    rows: list[tuple[Cell, ...]] = [
        (e.id, e.where, e.what, e.unit, e.paper, e.ours, e.difference, e.percent, e.trust, e.note)
        for e in found
    ]
    note = (
        "trust: exact follows from a formula; reported is a result of the paper's own run with its lost "
        "Table 1; doubtful contradicts another statement. The paper's numbers do not all agree with each "
        "other, so none is a pass mark on its own."
    )
    return Table("reproduce", "The paper's numbers beside ours", heads, tuple(rows), note)


def to_json(found: Sequence[Entry]) -> str:
    """The entries as JSON: a list of objects."""
    rows = [
        {
            "id": e.id,
            "where": e.where,
            "what": e.what,
            "unit": e.unit,
            "paper": e.paper,
            "ours": e.ours,
            "difference": e.difference,
            "percent": e.percent,
            "holds": e.holds,
            "trust": e.trust,
            "note": e.note,
        }
        for e in found
    ]
    return json.dumps(rows, indent=1, ensure_ascii=False) + "\n"


def to_text(found: Sequence[Entry]) -> str:
    """The entries for a terminal: a line each, statements and notes below."""
    whats = [f"{e.what} [{e.unit}]" if e.unit else e.what for e in found]
    width = max((len(what) for what in whats), default=0)
    lines = [f"{'where':12} {'what':{width}} {'paper':>10} {'ours':>10} {'difference':>10}"]
    told: set[tuple[str, str]] = set()
    for e, what in zip(found, whats, strict=True):
        if isinstance(e.paper, str):
            lines += [
                f"{e.where:12} {e.what}",
                f"{'':15}paper: {e.paper}",
                f"{'':15}ours:  {e.ours or 'no data'}",
            ]
        else:
            ours = f"{e.ours:.5g}" if isinstance(e.ours, float) else "no data"
            lines.append(f"{e.where:12} {what:{width}} {e.paper:>10.5g} {ours:>10} {_away(e):>10}".rstrip())
        note = f"doubtful: {e.note}" if e.trust == "doubtful" and e.note else e.note
        if note and (e.id, note) not in told:
            told.add((e.id, note))
            lines.append(f"{'':15}{note}")
    return "\n".join(lines) + "\n"


def _away(entry: Entry) -> str:
    """The difference in percent, or as a number where the paper's is zero."""
    if entry.percent is not None:
        return f"{round(entry.percent, 1) + 0.0:+.1f} %"
    return "" if entry.difference is None else f"{entry.difference:+.3g}"
