"""Foreign text made printable: names of files, words of other programs, texts in strangers' files.

Whatever `tbi` prints goes through `printable`, line by line (`printable_streams`), and so does every message
of a `UserError`: no text moves the cursor, changes colours, turns the direction of writing or ends a line.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, TextIO, cast


def printable(text: str) -> str:
    """``text`` on one line, what cannot be printed escaped: ``\\x1b``, ``\\u202e``.

    A byte of a file name that is not UTF-8 (in Python a lone surrogate) is written as that byte: ``\\xff``.
    """
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() else _escaped(c) for c in text)


def one_line(text: str) -> str:
    """``text`` on one line without what cannot be printed: for words of files, which nobody has to type."""
    return " ".join("".join(c if c.isprintable() else " " for c in text).split())


def bare(stream: TextIO) -> TextIO:
    """The stream itself behind one of `printable_streams`: for a progress bar, which moves the cursor."""
    return stream.bare if isinstance(stream, _PrintableStream) else stream


@contextmanager
def printable_streams() -> Iterator[None]:
    """While the block runs, all that is written to standard output and standard error is made printable."""
    before = sys.stdout, sys.stderr
    sys.stdout, sys.stderr = _wrapped(sys.stdout), _wrapped(sys.stderr)
    try:
        yield
    finally:
        sys.stdout, sys.stderr = before


def _escaped(character: str) -> str:
    code = ord(character)
    if 0xDC80 <= code <= 0xDCFF:
        code -= 0xDC00
    if code < 0x100:
        return f"\\x{code:02x}"
    return character.encode("unicode_escape").decode("ascii")


def _wrapped(stream: TextIO) -> TextIO:
    if stream is None or isinstance(stream, _PrintableStream):  # None where the descriptor is closed
        return stream
    return cast(TextIO, _PrintableStream(stream))


class _PrintableStream:
    """A text stream whose lines are printable; in all else it is the stream ``bare``."""

    def __init__(self, bare: TextIO) -> None:
        self.bare = bare

    def write(self, text: str) -> int:
        """Writes the lines of a text; returns how many characters were asked for."""
        self.bare.write(text if text.isprintable() else "\n".join(map(printable, text.split("\n"))))
        return len(text)

    def writelines(self, lines: list[str]) -> None:
        """Writes texts one after the other."""
        for line in lines:
            self.write(line)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.bare, name)
