"""The C peer: kernel.c with the tables of one batch, compiled by the system's compiler, timed as ours is."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np

from tbi_cli.batch import Batch
from tbi_cli.integrator.arrays import ROW

_FLAGS = ["-O3", "-march=native", "-mprefer-vector-width=512", "-fno-math-errno"]
#: What the compiler may do to the sums: as our kernel, fused and ordered as they are written; fused wherever
#: that is faster; or in any order too.
ARITHMETIC = {
    "as written": ["-ffp-contract=off", "-DSTRICT"],
    "contracted": ["-ffp-contract=fast"],
    "reassociated": ["-ffp-contract=fast", "-fassociative-math", "-fno-signed-zeros", "-fno-trapping-math"],
}


def seconds_per_case_step(batch: Batch, arithmetic: str) -> float | None:
    """Seconds of one core per case-step of a batch of eight scenarios alike; None without a compiler."""
    compiler = shutil.which("cc")
    if compiler is None:
        return None
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "terms.h").write_text(_tables(batch))
        library = Path(folder, "kernel.so")
        source = Path(__file__).with_name("kernel.c")
        command = [
            compiler,
            *_FLAGS,
            *ARITHMETIC[arithmetic],
            "-shared",
            "-fPIC",
            f"-I{folder}",
            str(source),
            "-o",
            str(library),
            "-lm",
        ]
        subprocess.run(command, check=True)
        return _timed(ctypes.CDLL(str(library)), batch)


def _tables(batch: Batch) -> str:
    t = batch.topology
    assert t.axle_wheel_end[-1] == 2 * len(t.axle_wheel_begin)
    rows = np.argsort(t.term_row)
    begin, end = t.term_begin[rows], t.term_end[rows]
    nd, wheels, axles = len(t.term_row), len(t.wheel_mode), len(t.axle_wheel_begin)

    def moved(signal: np.ndarray) -> np.ndarray:
        """Signal rows without the wheels' time aloft, which the C leaves out."""
        return np.where(signal >= 3 * nd + 5 * wheels, signal - wheels, signal)

    sizes = {
        "ND": nd,
        "NV": int(t.wheel_mode.min()),
        "N": t.n_modes,
        "AXLES": axles,
        "WHEELS": wheels,
        "TERMS": len(batch.crossing.term),
        "G_TERMS": len(t.wheel_col),
        "SUMS": len(t.sum_begin),
        "SUM_TERMS": len(t.sum_col),
        "CHANNELS": len(t.channel),
    }
    arrays = {
        "term_begin": [*begin, end[-1]],
        "term_value": (t.term >> 32) // ROW,
        "term_col": (t.term & 0xFFFFFFFF) // ROW,
        "g_begin": [*t.wheel_begin, t.wheel_end[-1]],
        "g_col": t.wheel_col,
        "sum_begin": [*t.sum_begin, t.sum_end[-1]],
        "sum_col": moved(t.sum_col),
        "channel": moved(t.channel),
    }
    lines = [f"#define {name} {value}" for name, value in sizes.items()]
    for name, values in arrays.items():
        lines.append(f"static const int {name}[] = {{{', '.join(str(int(v)) for v in values)}}};")
    return "\n".join(lines) + "\n"


def _aligned(count: int) -> np.ndarray:
    raw = np.zeros(count * 8 + 8)
    start = (-raw.ctypes.data % 64) // 8
    return raw[start : start + count * 8].reshape(count, 8)


def _timed(library: ctypes.CDLL, batch: Batch) -> float:
    t, c = batch.topology, batch.crossing
    nd, wheels = len(t.term_row), len(t.wheel_mode)
    axle = c.axle.reshape(len(t.axle_wheel_begin), -1, c.axle.shape[1])[:, :4].reshape(-1, c.axle.shape[1])
    parts = (c.scale[:5], c.wave, c.term, axle, c.wheel, c.wheel_g, c.wheel_gm, c.sum_offset, c.sum_coef)
    numbers = np.concatenate([part[:, :8] for part in parts])
    crossing = _aligned(len(numbers))
    crossing[:] = numbers
    channels, axles = len(t.channel), len(t.axle_wheel_begin)
    sizes = (2 * nd, 3 * nd + 4 * wheels + len(t.sum_begin), 3 * nd, 6 * axles * t.n_modes, axles)
    work = _aligned(sum(sizes) + 5 * channels)
    reduced = work[sum(sizes) :]
    best = np.inf
    steps = int(batch.last[0]) + 1
    for _ in range(5):
        work[:] = 0
        reduced[1::5], reduced[2::5] = -np.inf, np.inf
        begin = time.thread_time()
        library.advance(
            crossing.ctypes.data_as(ctypes.c_void_p),
            work.ctypes.data_as(ctypes.c_void_p),
            ctypes.c_double(0.0),
            ctypes.c_long(steps),
        )
        best = min(best, time.thread_time() - begin)
    return best / (8 * steps)
