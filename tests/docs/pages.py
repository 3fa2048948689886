"""The pages of the documentation, and how what they tell a reader to type is run."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

PROJECT = Path(__file__).parents[2]
DOCS = PROJECT / "docs"
_FENCE = re.compile(
    r'^```(?P<language>\w*)(?: title="(?P<title>[^"]+)")?\n(?P<text>.*?)^```$', re.DOTALL | re.MULTILINE
)


def without_code(text: str) -> str:
    """A page less its blocks of code."""
    return _FENCE.sub("", text)


def script(page: Path) -> str:
    """All that a page tells to write and to run, in its order, as one shell script.

    A block of yaml with a title is that file, a block of sh is run, a block of python is a program by itself.
    """
    lines = ["set -eu"]
    for found in _FENCE.finditer(page.read_text(encoding="utf-8")):
        language, title, text = found["language"], found["title"], found["text"]
        if language == "sh":
            lines.append(text)
        elif language == "yaml" and title:
            lines.append(f"cat > {title} <<'END OF FILE'\n{text}END OF FILE\n")
        elif language == "python":
            lines.append(f"python <<'END OF FILE'\n{text}END OF FILE\n")
    return "\n".join(lines)


def follow(page: Path, folder: Path) -> str:
    """Does in a folder what a page says; returns what was printed.  Fails if anything of it fails."""
    programs = folder / ".programs"
    programs.mkdir()
    for name, arguments in (("tbi", "-m tbi_cli"), ("python", "")):
        program = programs / name
        program.write_text(f'#!/bin/sh\nexec "{sys.executable}" {arguments} "$@"\n')
        program.chmod(0o755)
    done = subprocess.run(
        ["bash", "-c", script(page)],
        cwd=folder,
        env=os.environ | {"PATH": f"{programs}{os.pathsep}{os.environ['PATH']}", "MPLBACKEND": "agg"},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stdout
    assert "Traceback" not in done.stdout, done.stdout
    return done.stdout
