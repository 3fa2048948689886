"""Standard streams that may be full, closed, left by their reader, or unable to spell what is written.

What cannot be written to standard output is an error with a message; what cannot be written to standard error
is lost, and the work goes on.  Characters that the encoding of a stream lacks are written as well as it can.
"""

from __future__ import annotations

import codecs
import contextlib
import errno
import io
import os
import sys
import unicodedata
from collections.abc import Iterator
from typing import Any, TextIO

from tbi_cli.errors import UserError

# Signs that tbi prints itself and that decompose into nothing: the micro sign, Greek letters, typography.
_SIGNS = {
    "u": "µμ",
    "lambda": "λ",
    "xi": "ξ",
    "pi": "π",
    "Delta": "Δ",
    "sigma": "σ",
    "omega": "ω",
    "o": "ø",
    "O": "Ø",
    "x": "×",
    "*": "·",
    "-": "−–—",
    "+-": "±",
    "<=": "≤",
    ">=": "≥",
    "~": "≈",
    "->": "→",
    "sqrt": "√",
    "inf": "∞",
    " deg": "°",
    '"': "“”„",
    "'": "‘’",
}
_SPELLED = {sign: word for word, signs in _SIGNS.items() for sign in signs}
_ERRORS = "tbi-spell"


class OutputError(UserError):
    """Standard output cannot be written to; the text is the complete message."""


class ReaderGoneError(OutputError):
    """What read standard output has stopped reading, as `head` does; there is nothing to say about it."""

    exit_code = 141  # what a shell makes of SIGPIPE


def set_up_streams() -> None:
    """Puts streams of ours in place of Python's, once, when the process starts."""
    _occupy_closed_descriptors()
    codecs.register_error(_ERRORS, _spell)
    sys.stdout = _stream(_Output, sys.stdout)
    sys.stderr = _stream(_Messages, sys.stderr)


def _occupy_closed_descriptors() -> None:
    """Else the next file to be opened would be standard output to a library written in C."""
    for descriptor in (0, 1, 2):
        try:
            os.fstat(descriptor)
        except OSError:
            with contextlib.suppress(OSError):
                os.open(os.devnull, os.O_RDWR)  # takes the lowest descriptor that is free


def let_go_of_output() -> None:
    """Else Python would try once more, when it ends, to write what could not be written."""
    sys.stdout = None


def _stream(kind: type[io.TextIOWrapper], found: TextIO | None) -> Any:
    if found is None:
        return kind(io.BufferedWriter(_Closed()), "utf-8", _ERRORS)
    if not isinstance(found, io.TextIOWrapper):
        return found
    how = {"line_buffering": found.line_buffering, "write_through": found.write_through}
    encoding, newline = found.encoding, "\n" if os.linesep == "\n" else None
    return kind(found.detach(), encoding, _ERRORS, newline, **how)


class _Output(io.TextIOWrapper):
    """Standard output.  It raises OutputError where it cannot be written to, and ever after."""

    _error: OutputError | None = None

    def write(self, text: str) -> int:
        with self._failing():
            return super().write(text)

    def flush(self) -> None:
        with self._failing():
            super().flush()

    @contextlib.contextmanager
    def _failing(self) -> Iterator[None]:
        if self._error is not None:
            raise self._error
        try:
            yield
        except OSError as error:
            self._error = _output_error(error)
            raise self._error from None


def _output_error(error: OSError) -> OutputError:
    if error.errno == errno.EPIPE:
        return ReaderGoneError()
    return OutputError(f"standard output: {'is closed' if error.errno == errno.EBADF else error.strerror}")


class _Messages(io.TextIOWrapper):
    """Standard error.  What cannot be written there is lost: nowhere could that be told."""

    _lost = False

    def write(self, text: str) -> int:
        if not self._lost:
            try:
                return super().write(text)
            except OSError:
                self._lost = True
        return len(text)

    def flush(self) -> None:
        if not self._lost:
            try:
                super().flush()
            except OSError:
                self._lost = True


class _Closed(io.RawIOBase):
    """A stream that was closed before tbi began."""

    def writable(self) -> bool:
        return True

    def write(self, data: Any) -> int:
        raise OSError(errno.EBADF, os.strerror(errno.EBADF))


def _spell(error: UnicodeError) -> tuple[str | bytes, int]:
    """Handles encoding errors: u for a micro sign, e for e with an accent, \\u4e2d where nothing is alike."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    return "".join(map(_likeness, error.object[error.start : error.end])), error.end


def _likeness(sign: str) -> str:
    if "\udc80" <= sign <= "\udcff":  # a byte of a name that is not text
        return f"\\x{ord(sign) - 0xDC00:02x}"
    spelled = _SPELLED.get(sign) or unicodedata.normalize("NFKD", sign).encode("ascii", "ignore").decode()
    return spelled or sign.encode("ascii", "backslashreplace").decode()
