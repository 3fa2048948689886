"""The folder of a report: written aside, moved in when complete, and never at the cost of anyone's files.

A folder made by `tbi report` has a marker file that lists what the report wrote.  A new report replaces those
files and leaves all others; a folder without the marker is refused unless it is empty.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tbi_cli.report.errors import ReportError
from tbi_cli.scratch import scratch_folder
from tbi_cli.store.errors import StoreError
from tbi_cli.store.plain import read_plain

MARKER = ".tbi-report.json"
_KIND = "tbi-report"
_MOST_BYTES = 1 << 24  # of the marker


def check_folder(path: Path) -> None:
    """Raises ReportError where no report may be put: a file, or a folder with someone's files in it."""
    try:
        if not path.exists():
            return
        if not path.is_dir():
            raise ReportError(f"{path}: expected a folder for the report, got a file; choose another with -o")
        if any(path.iterdir()) and _listed(path) is None:
            raise ReportError(
                f"{path}: expected a new folder, an empty one or an earlier report, got other files; "
                f"nothing was touched; choose another with -o"
            )
    except OSError as error:
        raise ReportError.from_os(path, error) from error


@contextmanager
def report_folder(path: Path) -> Iterator[Path]:
    """A folder to write the report into; when the block ends well, its files move to `path`.

    Raises ReportError if `path` may not be used (`check_folder`), or the disk refuses.
    """
    check_folder(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        # Forty characters are no longer than a name may be, whatever they are.
        with scratch_folder(path.parent, f".{path.name[:40]}-") as scratch:
            yield scratch
            _move_in(scratch, path)
    except OSError as error:
        raise ReportError.from_os(path, error) from error


def _move_in(scratch: Path, path: Path) -> None:
    new = sorted(file.name for file in scratch.iterdir())
    check_folder(path)
    path.mkdir(exist_ok=True)
    old = _listed(path) or []
    # If this is interrupted, the next report still knows all of our files.
    _write_marker(path, sorted({*old, *new}))
    for name in new:
        (scratch / name).replace(path / name)
    for name in set(old) - set(new):
        (path / name).unlink(missing_ok=True)
    _write_marker(path, new)


def _listed(path: Path) -> list[str] | None:
    """The files of the report in `path`, None if there is none.  Names that lead elsewhere do not count."""
    marker = path / MARKER
    if marker.is_symlink() or not marker.is_file():
        return None
    try:
        found = json.loads(read_plain(marker, _MOST_BYTES))
    except (OSError, StoreError, ValueError, RecursionError):
        return None
    if not isinstance(found, dict) or found.get("kind") != _KIND or not isinstance(found.get("files"), list):
        return None
    return [name for name in found["files"] if _is_plain(path, name)]


def _is_plain(path: Path, name: object) -> bool:
    if (
        not isinstance(name, str)
        or not name
        or "\0" in name
        or name != Path(name).name
        or name in (".", "..")
    ):
        return False
    return name != MARKER and not (path / name).is_dir()


def _write_marker(path: Path, names: list[str]) -> None:
    text = json.dumps({"kind": _KIND, "files": names}, indent=1)
    temporary = path / f"{MARKER}.new"
    temporary.write_text(text + "\n", encoding="utf-8")
    temporary.replace(path / MARKER)
