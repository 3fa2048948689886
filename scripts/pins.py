#!/usr/bin/env python
"""Pins the bits of small built-in cases, which tests/core/test_digests.py then holds the code to.

    python scripts/pins.py                   whether the working tree has the pinned bits, kind by kind
    python scripts/pins.py --pin "REASON"    pins those that it has; nothing but this writes the file

The pins are in tests/core/digests.json: for each kind of arithmetic, case and group of tables a SHA-256 over
its tables' names, types, shapes and bits.  Kernels give the same bits on every processor; what a kind is made
of are the functions of NumPy and BLAS with which a case is assembled, and both of them choose their code by
the processor.  So a kind is told by the numbers that they give, and one machine can be several: --pin runs
itself again for each that the environment can make of it, and forgets what it cannot see.

Ends with exit code 1 if bits differ from those pinned.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import platform
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "scripts")]

from digests import digests  # noqa: E402

PINS = ROOT / "tests" / "core" / "digests.json"
# Built-in cases, with what makes a short one of them: together they take about three seconds.
CASES: dict[str, tuple[str, ...]] = {
    "paper": (),
    "paper/modes": ("sweep={modes: [1, 7, 20]}",),
    "paper/verification-1": (),
    "paper/verification-2-moving-load": (),
    "irregular/dip": ("sweep.track.irregularity.dip.depth=[0 mm, 5 mm]",),
    "irregular/contact-forces": (),
    "practice/axle-forces": (),
    "practice/eight-cars": ("sweep={velocity: [67, 93]}",),
    "practice/hslm-a": ("sweep={train.number: [2, 7], span: [15, 30], velocity: [45, 88]}",),
}
Pins = dict[str, dict[str, str]]


def kind() -> str:
    """The kind of this process's arithmetic: family of processor, and a hash of what is computed outside of
    kernels.

    Sines and cosines (NumPy takes code of its own where there are units of 512 bits, the C library's
    elsewhere), Fourier transforms, products and eigenvalues of matrices (OpenBLAS, with fused
    multiply-adds or without).
    """
    x = np.linspace(-40.0, 300.0, 6001)
    phases, table = np.exp(1j * x), np.sin(np.outer(x[:1500], np.arange(1.0, 21.0)))
    given = [
        *(np.sin(x), np.cos(x), np.tan(x / 200), phases, np.fft.irfft(phases)),
        *(table @ np.cos(x[:20]), table.T @ table, np.linalg.eigvalsh(table.T @ table)),
        np.linalg.eigvals(table[:40:2]),
    ]
    bits = hashlib.sha256(b"".join(np.ascontiguousarray(values).tobytes() for values in given))
    return f"{platform.machine()}-{bits.hexdigest()[:12]}"


def solved(case: str, folder: Path) -> dict[str, str]:
    """Group of tables -> digest of a case of CASES, solved by this process."""
    from tbi_cli.case import load_case
    from tbi_cli.runner import Options, run
    from tbi_cli.workers import Workers

    loaded = load_case(case, overrides=CASES[case])
    path = folder / f"{case.replace('/', '-')}.h5"
    run(loaded, Options(output=path, overwrite=True, workers=Workers(jobs=1)))
    groups: dict[str, list[str]] = {}
    for name, digest in sorted(digests(path).items()):
        # A name without a slash is an axis.
        groups.setdefault(name.split("/")[0] if "/" in name else "axes", []).append(f"{name} {digest}\n")
    return {group: hashlib.sha256("".join(lines).encode()).hexdigest() for group, lines in groups.items()}


def pinned() -> dict[str, Any]:
    """The file: `because`, and `kinds`: kind -> `about` and `cases`."""
    found: dict[str, Any] = json.loads(PINS.read_text(encoding="utf-8"))
    return found


def differences(found: Pins, expected: Pins) -> list[str]:
    """`case: group` for each that has other bits, or is in one of them only."""
    pairs = {(case, group) for some in (found, expected) for case, groups in some.items() for group in groups}
    return [
        f"{case}: {group}"
        for case, group in sorted(pairs)
        if found.get(case, {}).get(group) != expected.get(case, {}).get(group)
    ]


def environments() -> Iterator[dict[str, str]]:
    """Settings that make other kinds of this machine: NumPy without its widest units, an older BLAS."""
    extensions = np.show_config(mode="dicts")["SIMD Extensions"].get("found", [])
    for first in range(len(extensions), -1, -1):
        for blas in ({}, {"OPENBLAS_CORETYPE": "Haswell"}, {"OPENBLAS_CORETYPE": "Prescott"}):
            without = {"NPY_DISABLE_CPU_FEATURES": " ".join(extensions[first:])} if extensions[first:] else {}
            yield without | blas


def of_this_process() -> dict[str, Any]:
    """The kind of this process, what it is made of in words, and the digests of all cases."""
    with tempfile.TemporaryDirectory() as folder:
        cases = {case: solved(case, Path(folder)) for case in CASES}
    names = sorted(key for key in os.environ if key.startswith(("NPY_", "OPENBLAS_")))
    settings = [f"{name}={os.environ[name]}" for name in names]
    about = f"numpy {np.__version__}, {' '.join(platform.libc_ver())}, {' '.join(settings) or 'as it is'}"
    return {"kind": kind(), "about": about, "cases": cases}


def of_this_machine() -> dict[str, dict[str, Any]]:
    """Kind -> `about` and `cases`, by a process for each setting of the environment."""
    kinds: dict[str, dict[str, Any]] = {}
    for settings in environments():
        command = [sys.executable, str(Path(__file__)), "--one"]
        run = subprocess.run(command, env=os.environ | settings, capture_output=True, text=True, check=True)
        one = json.loads(run.stdout)
        kinds.setdefault(one.pop("kind"), one)
    return kinds


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--pin", metavar="REASON", help="why other bits are meant from now on")
    parser.add_argument("--one", action="store_true", help="print what this process gives, as JSON")
    arguments = parser.parse_args()
    if arguments.one:
        print(json.dumps(of_this_process()))
        return
    before = pinned() if PINS.exists() else {"kinds": {}}
    kinds, differ = of_this_machine(), False
    for name, one in kinds.items():
        known = before["kinds"].get(name)
        lines = differences(one["cases"], known["cases"]) if known else []
        differ |= bool(lines)
        said = "not pinned" if known is None else f"{len(lines)} differ" if lines else "the same"
        print(f"{name} ({one['about']}): {said}", *lines, sep="\n    ")
    if arguments.pin is None:
        sys.exit(1 if differ else 0)
    if len(arguments.pin.split()) < 3:
        parser.error("--pin takes the reason in words, which the file keeps")
    # Where nothing differs, kinds that this machine does not show are still true.
    kept = {} if differ else before["kinds"]
    text = json.dumps({"because": arguments.pin, "kinds": kept | kinds}, indent=1, sort_keys=True)
    PINS.write_text(text + "\n", encoding="utf-8")
    print(f"pinned {len(kinds)} kinds, forgot {len(before['kinds'].keys() - kept.keys() - kinds.keys())}")


if __name__ == "__main__":
    main()
