"""Files of up to a megabyte, whole or wrong in every value: an answer in bounded time and memory."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

HEAD = "train: paper\nbridge: paper\nvelocity: 50\n"
WRONG = ", ".join(["q"] * 95_000)
MISSING = ", ".join(["{vehicle: {model: full-31dof}}"] * 6_000)
MASSES = ", ".join(f"{20 + 0.001 * i:.3f} t" for i in range(80_000))
SPEEDS = ", ".join(f"{2 + 0.1 * i:.1f}" for i in range(1_400))

# What the file is, and whether it is right.  By name: what took minutes, or most memory, before.
FILES = {
    "masses with units": (f"{HEAD}sweep: {{train.car_body.mass: [{MASSES}]}}", True),
    "speeds": (f"{HEAD}sweep: {{span: [{', '.join(f'{20 + 1e-4 * i:.4f}' for i in range(95_000))}]}}", True),
    "studies": (
        f"{HEAD}studies:\n" + "".join(f"  s{i}: {{sweep: {{velocity: [{SPEEDS}]}}}}\n" for i in range(64)),
        True,
    ),
    "wrong vehicles": (f"bridge: paper\nvelocity: 50\ntrain: {{consist: [{WRONG}]}}", False),
    "empty vehicles": (f"bridge: paper\nvelocity: 50\ntrain: {{consist: [{MISSING}]}}", False),
    "wrong stations": (f"{HEAD}bridge.stations: [{WRONG}]", False),
    "wrong forces": (f"bridge: paper\nvelocity: 50\ntrain: {{model: moving-load, forces: [{WRONG}]}}", False),
    "wrong rails": (f"{HEAD}track: {{irregularity: {{profile: {{x: [{WRONG}]}}}}}}", False),
    "wrong speeds": (f"{HEAD}sweep: {{velocity: [{WRONG}]}}", False),
    "one key again and again": (HEAD + "velocity: 50\n" * 70_000, False),
    "nothing but brackets": ("[" * 1_000_000, False),
    "one value again and again": ("a: &a [1, 2]\nb: [" + "*a," * 330_000 + "]", False),
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
    text, right = FILES[name]
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
    assert process.returncode == (0 if right else 2), answer
    assert "Traceback" not in answer
    assert used.ru_utime + used.ru_stime < 10
    peak = re.search(r"VmHWM:\s+([0-9]+) kB", (tmp_path / "status").read_text())
    assert peak is not None
    assert int(peak[1]) < 200_000
