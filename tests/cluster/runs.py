"""A run of many short crossings, in this process or as a command, and what came of it."""

from __future__ import annotations

import contextlib
import io
import os
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

import h5py
import numpy as np

from tbi_cli.cli import run_command_line
from tests.cli.commands import Ended

# Two structures (2 and 3 modes), batches of unlike length, in under a second.
CASE = """\
title: Many short crossings
train: trains/paper.yaml
bridge: bridges/paper.yaml
velocity: 180 m/s
solver: {sampling: 0.002, substeps: 2, duration: 1}
sweep:
  bridge.modes: [2, 3]
  train.car_body.mass: [20 t, 40 t, 60 t]
  velocity: {from: 20, to: 192, step: 4}
output: {file: results.h5}
"""
SCENARIOS = 2 * 3 * 44
# The same sweep in steps so small that it takes some seconds, or longer than anyone waits for its end.
SLOW = ("--set", "solver.sampling=0.00005", "--set", "solver.substeps=1")
ENDLESS = ("--set", "solver.sampling=0.00001", "--set", "solver.substeps=1")
HISTORIES = ("--set", "output.histories={channels: [right_midspan, car_body_y], every: 0.01}")


def command(*arguments: str) -> list[str]:
    """The command line of a tbi process."""
    return [sys.executable, "-m", "tbi_cli", *arguments]


def inside(*arguments: str, folder: Path, **environment: str) -> Ended:
    """As `tbi` of tests.cli.commands, but in this process, which saves the second that a new one takes."""
    out, err, before = io.StringIO(), io.StringIO(), dict(os.environ)
    os.environ.update(environment)
    try:
        with contextlib.chdir(folder), contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            code = run_command_line(arguments)
    finally:
        os.environ.clear()
        os.environ.update(before)
    return Ended(code, out.getvalue(), err.getvalue())


def start(*arguments: str, folder: Path, **environment: str) -> subprocess.Popen[str]:
    """A tbi process that runs."""
    return subprocess.Popen(
        command(*arguments),
        cwd=folder,
        env=os.environ | environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def content(path: Path) -> Mapping[str, bytes]:
    """Every dataset of a results file, to the bit."""
    found: dict[str, bytes] = {}

    def keep(name: str, item: object) -> None:
        if isinstance(item, h5py.Dataset):
            value = item[()]
            text = isinstance(value, np.ndarray) and value.dtype == object
            found[name] = repr(value.tolist()).encode() if text else np.asarray(value).tobytes()

    with h5py.File(path, "r") as file:
        file.visititems(keep)
    return found


def parts(path: Path) -> list[Path]:
    """The finished batches of a run that is under way."""
    return sorted(path.with_name(path.name + ".parts").glob("*.h5"))
