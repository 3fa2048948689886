"""Files of up to a megabyte, whole or wrong in every value: an answer in bounded time and memory."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ON_PAPER = "bridge: paper\nvelocity: 50\n"
OF_PAPER = "train: paper\nvelocity: 50\n"
HEAD = "train: paper\nbridge: paper\nvelocity: 50\n"
WRONG = ", ".join(["q"] * 95_000)
MISSING = ", ".join(["{vehicle: {model: full-31dof}}"] * 6_000)
MASSES = ", ".join(f"{20 + 0.001 * i:.3f} t" for i in range(80_000))
SPANS = ", ".join(f"{20 + 1e-4 * i:.4f}" for i in range(95_000))
SPEEDS = ", ".join(f"{2 + 0.1 * i:.1f}" for i in range(1_400))
STUDIES = "studies:\n" + "".join(f"  s{i}: {{sweep: {{velocity: [{SPEEDS}]}}}}\n" for i in range(64))

# What the file is, the exit code, and words of the answer; many of them took minutes, or most memory, once.
FILES = {
    "masses with units": (f"{HEAD}sweep: {{train.car_body.mass: [{MASSES}]}}", 0, "scenarios  80000"),
    "spans": (f"{HEAD}sweep: {{span: [{SPANS}]}}", 0, "scenarios  95000"),
    "studies": (HEAD + STUDIES, 0, "study      s63"),
    "wrong vehicles": (f"{ON_PAPER}train: {{consist: [{WRONG}]}}", 2, "at most 200 values in this list"),
    "empty vehicles": (f"{ON_PAPER}train: {{consist: [{MISSING}]}}", 2, "at most 200 values in this list"),
    "wrong stations": (f"{OF_PAPER}bridge: {{stations: [{WRONG}]}}", 2, "at most 100 values in this list"),
    "wrong forces": (
        f"{ON_PAPER}train: {{model: moving-load, forces: [{WRONG}]}}",
        2,
        "at most 1000 values in this list",
    ),
    "wrong rails": (
        f"{HEAD}track: {{irregularity: {{profile: {{x: [{WRONG}]}}}}}}",
        2,
        "at most 10000 values in this list",
    ),
    "wrong speeds": (f"{HEAD}sweep: {{velocity: [{WRONG}]}}", 2, "more errors"),
    "one key again and again": (HEAD + "velocity: 50\n" * 70_000, 2, "more than 20000 keys"),
    "nothing but brackets": ("[" * 1_000_000, 2, "nesting"),
    "one value again and again": (
        "a: &a [1, 2]\nb: [" + "*a," * 330_000 + "]",
        2,
        "aliases counted each time",
    ),
}


# What the system says of the process at its end: what `wait4` says of memory begins with that of the parent.
VALIDATE = """
import atexit, pathlib
from tbi_cli.__main__ import main
status = pathlib.Path("/proc/self/status")
atexit.register(lambda: pathlib.Path("status").write_text(status.read_text()))
main()
"""


@pytest.mark.parametrize("name", FILES)
def test_any_file_gets_an_answer(name: str, tmp_path: Path) -> None:
    """Ten seconds of a processor (an answer takes one or two) and 200 MB are the most."""
    text, code, words = FILES[name]
    file = tmp_path / "case.yaml"
    file.write_text(text)
    assert file.stat().st_size <= 1_000_000
    process = subprocess.Popen(
        [sys.executable, "-c", VALIDATE, "validate", str(file)],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        cwd=tmp_path,
    )
    assert process.stdout is not None
    answer = process.stdout.read().decode()
    _, status, used = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    assert process.returncode == code, answer
    assert words in answer
    assert "Traceback" not in answer
    assert used.ru_utime + used.ru_stime < 10
    peak = re.search(r"VmHWM:\s+([0-9]+) kB", (tmp_path / "status").read_text())
    assert peak is not None
    assert int(peak[1]) < 200_000
