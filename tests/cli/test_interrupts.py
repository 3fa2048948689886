"""Ctrl-C while Python imports, which is most of a short command."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

# Sends the signal when a module is imported for the first time, then runs the command line.
START = """
import os, signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)  # ignored where the tests run in the background
wanted = sys.argv.pop(1)
class AtImport:
    def find_spec(self, name, path=None, target=None):
        if name == wanted:
            sys.meta_path.remove(self)
            os.kill(os.getpid(), signal.SIGINT)
sys.meta_path.insert(0, AtImport())
from tbi_cli.__main__ import main
main()
"""
RUN = ("run", "paper")


@pytest.mark.parametrize(
    ("module", "arguments"),
    [
        *(
            ("tbi_cli.cli", ("list",)),
            ("typer", RUN),
            ("tbi_cli.cli.run", RUN),
            ("pydantic", RUN),
            ("yaml", RUN),
        ),
        *(("numpy", RUN), ("h5py", RUN), ("tbi_cli.store.durable", RUN)),
    ],
)
def test_an_interrupted_import(module: str, arguments: tuple[str, ...], tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-c", START, module, *arguments],
        cwd=tmp_path,
        capture_output=True,
        timeout=120,
        check=False,
    )
    assert (done.returncode, done.stdout, done.stderr) == (130, b"", b"")
    assert not list(tmp_path.iterdir())
