"""Reads a text file that a stranger may have named: only regular files, only text, never more than 1 MB."""

from __future__ import annotations

import codecs
import os
import re
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path

from tbi_cli.case.builtin import configs_folder
from tbi_cli.case.messages import CaseError, Place, Problem, Source, fail

MAX_BYTES = 1_000_000
# Control characters, and the line ends of YAML 1.1 that nobody's editor shows as such.
_FORBIDDEN = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\u2028\u2029\ud800-\udfff\ufeff\ufffe\uffff]")
_KINDS = (
    (stat.S_ISDIR, "a directory"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
    (stat.S_ISFIFO, "a pipe"),
    (stat.S_ISSOCK, "a socket"),
)


_home: ContextVar[str] = ContextVar("home", default="")


@contextmanager
def case_folder(case: Path) -> Iterator[None]:
    """While a case is read: files outside its folder are `foreign`, links followed; built-in ones are not.

    The folder of a built-in case, which has none of the user's files, is the working directory.
    """
    token = _home.set(str(_real(Path() if _is_below(case, configs_folder()) else case.parent)))
    try:
        yield
    finally:
        _home.reset(token)


def _is_foreign(path: Path) -> bool:
    home = _home.get()
    return bool(home) and not _is_below(path, Path(home)) and not _is_below(path, configs_folder())


def _is_below(path: Path, folder: Path) -> bool:
    return _real(path).is_relative_to(_real(folder))


def _real(path: Path) -> Path:
    """The path with links followed; a path that none can have, with a null character, as it is."""
    return path if "\0" in str(path) else Path(os.path.realpath(path))


def read_source(path: Path, name: str) -> Source:
    """The text of `path`, called `name` in messages.

    Raises CaseError when it is missing, unreadable, not a regular file, too large, not UTF-8 or holds
    control characters.
    """
    return decoded(_content(path, name), name, path.parent, foreign=_is_foreign(path))


def read_table_source(path: Path, name: str) -> Source:
    """The text of a table, which programs write in UTF-8, in UTF-16 with its mark, or in Latin-1.

    Raises CaseError like `read_source`; Latin-1 is that of Windows, which has letters for more bytes.
    """
    content = _content(path, name)
    if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        encodings = ["utf-16"]
    elif b"\0" in content:
        raise fail(name, "neither UTF-8 nor UTF-16 with its byte order mark; save the table as UTF-8")
    else:
        encodings = ["utf-8-sig", "cp1252"]
    for encoding in encodings:
        try:
            text = content.decode(encoding)
        except UnicodeDecodeError:
            continue
        return checked(Source(name=name, text=text, folder=path.parent, foreign=_is_foreign(path)))
    raise fail(name, "not text in UTF-8, UTF-16 or Latin-1; save the table as UTF-8")


def _content(path: Path, name: str) -> bytes:
    """The bytes of a regular file that is not too large."""
    try:
        status = path.stat()
        for is_kind, kind in _KINDS:
            if is_kind(status.st_mode):
                raise fail(name, f"expected a file, got {kind}")
        with path.open("rb") as file:
            # The size that stat tells is not to be relied on: /proc says 0 for files without end.
            content = file.read(MAX_BYTES + 1)
    except FileNotFoundError:
        raise fail(name, "no such file") from None
    except (OSError, ValueError) as error:
        reason = (
            os.strerror(error.errno).lower() if isinstance(error, OSError) and error.errno else str(error)
        )
        raise fail(name, f"cannot be read: {reason}") from None
    if len(content) > MAX_BYTES:
        raise fail(name, f"larger than {MAX_BYTES} bytes, too large for a case file")
    return content


def decoded(content: bytes, name: str, folder: Path, *, foreign: bool = False) -> Source:
    """The bytes as text; raises CaseError with the place of what is not UTF-8 or not printable."""
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        byte = "a byte" if foreign else f"byte {content[error.start]:#04x}"
        raise fail(name, f"not UTF-8 text: {byte} on line {line}") from None
    return checked(Source(name=name, text=text, folder=folder, foreign=foreign))


def checked(source: Source) -> Source:
    """The same source; raises CaseError where it holds control characters, or bytes that are not text."""
    found = _FORBIDDEN.search(source.text)
    if found:
        place = Place(source, *source.position(found.start()))
        raise CaseError([Problem(place, "", f"control character U+{ord(found[0]):04X}")])
    return source
