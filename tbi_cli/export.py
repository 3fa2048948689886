"""The tables of a results file for spreadsheets and data frames."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Literal

import numpy as np

from tbi_cli.errors import UserError
from tbi_cli.store import Results
from tbi_cli.store.layout import CONVERGED


def export_tables(
    results: Results, folder: Path, form: Literal["csv", "parquet"], *, overwrite: bool = False
) -> list[Path]:
    """Writes one file per table, one row per scenario: axis values, then channels; returns the paths.

    Units stand in brackets behind the names.  A number is written so that reading it gives the same bits.
    Raises UserError if a file is there already, if the folder cannot be written to, or if Parquet is asked
    for without pyarrow.
    """
    if form == "parquet":
        _need_pyarrow()
    groups = [*results.layout.groups, *([] if results.converged is None else [CONVERGED])]
    paths = {group: folder / f"{group}.{form}" for group in groups}
    write = _write_csv if form == "csv" else _write_parquet
    try:
        there = next((path for path in paths.values() if path.exists()), None)
        if there is not None and not overwrite:
            raise UserError(f"{there}: exists already; --overwrite replaces it")
        folder.mkdir(parents=True, exist_ok=True)
        for group, path in paths.items():
            unfinished = path.with_name(f"{path.name}.unfinished")
            try:
                write(unfinished, dict(_columns(results, group)))
                unfinished.replace(path)
            finally:
                unfinished.unlink(missing_ok=True)
    except OSError as error:
        raise UserError.from_os(folder, error) from None
    return list(paths.values())


def _columns(results: Results, group: str) -> Iterator[tuple[str, Any]]:
    places = np.indices(results.shape).reshape(len(results.shape), -1)
    for dim, place in zip(results.dims, places, strict=True):
        for column in (dim, *dim.members):
            yield _named(column.name, column.units), column.values[place]
    if group == CONVERGED and results.converged is not None:
        yield CONVERGED, results.converged.ravel()
        return
    for variable in results.layout.columns(group):
        yield _named(variable.name, variable.units), results.table(group, variable.name).ravel()


def _named(name: str, units: str) -> str:
    return name if units == "1" else f"{name} [{units}]"


def _write_csv(path: Path, columns: dict[str, Any]) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(columns)
        # repr of a float is the shortest text that reads back as the same bits.
        writer.writerows(zip(*(values.tolist() for values in columns.values()), strict=True))


def _write_parquet(path: Path, columns: dict[str, Any]) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    pq.write_table(pa.table(columns), path)


def _need_pyarrow() -> None:
    try:
        import pyarrow  # noqa: F401
    except ImportError:
        raise UserError("--format parquet needs pyarrow: pip install 'tbi-cli[parquet]'") from None
