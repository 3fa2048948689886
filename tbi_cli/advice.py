"""What a message advises: how an unfinished run goes on, as a command that can be typed as it stands."""

from __future__ import annotations

import os
import re
import shlex
from collections.abc import Collection, Sequence

#: What ends the message about results that are another run's: nothing that is there is touched.
ANOTHER_FILE = "choose another file with -o"
#: The commands that have --resume; the others go on where they stopped when they are given once more.
_RESUMABLE = ("run", "sweep", "submit")
_IN_PYTHON = ((r"--(resume|overwrite)\b", r"Options(\1=True)"), (r"-o\b", "Options(output=...)"))


def go_on(command: Sequence[str], folder: str = "") -> str:
    """How the run that `command` began goes on; `folder` is where that was given, "" for here.

    A run that was begun from Python has no command line: fewer than two words.
    """
    if len(command) < 2:
        return "continue in Python with Options(resume=True)"
    words = without(command, {"--overwrite", "--resume"})
    if words[1] in _RESUMABLE:
        words = [*words, "--resume"]
    return f"continue with: {_there(folder)}{shlex.join(words)}"


def join(shards: str, results: str, folder: str = "") -> str:
    """How shards, named by a pattern of the shell, are joined."""
    return f"join it with the others: {_there(folder)}tbi merge {shards} -o {shlex.quote(results)}"


def without(command: Sequence[str], flags: Collection[str], options: Collection[str] = ()) -> list[str]:
    """A command line less some flags, and some options with their values."""
    words: list[str] = []
    skip = False
    for word in command:
        name = word.partition("=")[0]
        if not skip and word not in flags and name not in options:
            words.append(word)
        skip = not skip and word in options
    return words


def in_python(text: str) -> str:
    """The message with the options of the command line as those of `run`."""
    for option, call in _IN_PYTHON:
        text = re.sub(rf"(?<!\S){option}", call, text)
    return text


def _there(folder: str) -> str:
    try:
        here = os.getcwd()  # noqa: PTH109 - of a folder that is gone, Path.cwd raises no less
    except OSError:
        here = ""
    return f"cd {shlex.quote(folder)} && " if folder and folder != here else ""
