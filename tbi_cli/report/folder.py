"""The folder of a report: written aside, moved in when complete, and never at the cost of anyone's files.

A folder made by `tbi report` has a marker file that lists what the report wrote.  A new report replaces those
files and leaves all others; a folder without the marker is refused unless it is empty.
"""

from __future__ import annotations

import json
import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tbi_cli.report.errors import ReportError

MARKER = ".tbi-report.json"
_KIND = "tbi-report"


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
        raise _trouble(path, error) from error


@contextmanager
def report_folder(path: Path) -> Iterator[Path]:
    """A folder to write the report into; when the block ends well, its files move to `path`.

    Raises ReportError if `path` may not be used (`check_folder`), or the disk refuses.
    """
    check_folder(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        scratch = Path(tempfile.mkdtemp(prefix=f".{path.name[:100]}-", dir=path.parent))
    except OSError as error:
        raise _trouble(path, error) from error
    try:
        yield scratch
        _move_in(scratch, path)
    except OSError as error:
        raise _trouble(path, error) from error
    finally:
        shutil.rmtree(scratch, ignore_errors=True)


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
        found = json.loads(marker.read_text(encoding="utf-8"))
    except (OSError, ValueError):
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


def _trouble(path: Path, error: OSError) -> ReportError:
    return ReportError(f"{path}: {os.strerror(error.errno) if error.errno else error}")
