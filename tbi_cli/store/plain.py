"""Small text files beside a results file, which may have been changed or put there by a stranger."""

from __future__ import annotations

import os
import stat
from pathlib import Path

from tbi_cli.store.errors import StoreError


def read_plain(path: Path, most: int) -> str:
    """The text of a regular file of at most ``most`` bytes: a pipe is not waited for, a device not read.

    Raises `OSError` as opening it does, and `StoreError` for what is not such a file, or not UTF-8.
    """
    with os.fdopen(os.open(path, os.O_RDONLY | os.O_CLOEXEC | getattr(os, "O_NONBLOCK", 0)), "rb") as file:
        if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
            raise StoreError(f"{path}: is not a regular file")
        content = file.read(most + 1)
    if len(content) > most:
        raise StoreError(f"{path}: is too large")
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError as error:
        raise StoreError(f"{path}: is not text") from error
