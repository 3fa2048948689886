#!/usr/bin/env python
"""Measures what PERFORMANCE.md claims, beside each goal, with other ways to do the same in the same run.

    python scripts/benchmark.py             all of it (several minutes)
    python scripts/benchmark.py kernel cli  some: kernel, practice, scaling, cli, memory, histories, accuracy
    python scripts/benchmark.py --json      for machines

Times are the best of several; a machine that does other work at the same time makes all of them longer.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent))

from peers.arithmetic import multiply_adds_of_a_step, multiply_adds_per_second
from peers.c import ARITHMETIC
from peers.c import seconds_per_case_step as c_seconds
from peers.plain import PlainCrossing, numpy_rk4, scalar_numba, scipy_solution

from tbi_cli.batch import Batch, build_batch
from tbi_cli.case import load_case
from tbi_cli.integrator.integrate import integrate
from tbi_cli.solve import Solver
from tbi_cli.verify.references.crossing import crossing_channels


@dataclass(frozen=True)
class Figure:
    """One line of the table."""

    section: str
    name: str
    value: float
    unit: str
    goal: float | None = None
    at_least: bool = False

    @property
    def met(self) -> bool | None:
        if self.goal is None:
            return None
        return self.value >= self.goal if self.at_least else self.value <= self.goal


def best(action: Callable[[], object], times: int = 5) -> float:
    """The shortest of several runs of this thread, in seconds of a processor."""
    found = np.inf
    for _ in range(times):
        begin = time.thread_time()
        action()
        found = min(found, time.thread_time() - begin)
    return found


def batch_of(*overrides: str, copies: int = 64) -> Batch:
    """So many scenarios alike of the paper's case, every channel of the tables reduced."""
    solver = Solver(load_case("paper", overrides=overrides))
    place = {channel.name: k for k, channel in enumerate(solver.channels)}
    reduced = sorted({place[name] for c in solver.tables for name in c.members or (c.name,)})
    return build_batch([solver.scenarios.crosser(0)] * copies, reduced, ())


def solve(batch: Batch) -> None:
    """The kernel and what drives it."""
    integrate(batch.topology, batch.crossing, batch.last, batch.substeps, rails=batch.rails)


def per_case_step(batch: Batch, times: int = 5) -> float:
    """Seconds of one core for one Runge-Kutta step of one scenario."""
    return best(lambda: solve(batch), times) / float(np.sum(batch.last + 1) * batch.substeps)


def kernel() -> Iterator[Figure]:
    """Cost of a case-step, and what others need for it."""
    batch = batch_of()
    solve(batch)
    ours = per_case_step(batch)
    yield Figure("kernel", "one case-step, all channels reduced, one core", 1e6 * ours, "us", 0.25)
    yield Figure("kernel", "case-steps per second and core", 1e-6 / ours, "million", 4.0, at_least=True)
    for arithmetic in ARITHMETIC:
        in_c = c_seconds(batch, arithmetic)
        if in_c is not None:
            yield Figure("kernel", f"the same in C with 512-bit vectors, {arithmetic}", 1e6 * in_c, "us")
            goal = 1.2 if arithmetic == "as written" else None
            yield Figure("kernel", f"ours over C {arithmetic}", ours / in_c, "x", goal)
    peak, t = multiply_adds_per_second(), batch.topology
    needed = multiply_adds_of_a_step(len(t.term), len(t.wheel_col), len(t.wheel_mode), len(t.term_row), 0.2)
    yield Figure("kernel", "multiply-adds of a core at its peak", 1e-9 * peak, "thousand million/s")
    yield Figure("kernel", "share of that peak in the kernel", 100 * needed / ours / peak, "%")
    plain = PlainCrossing(Solver(load_case("paper")).scenarios.model(0), 300 / 3.6)
    yield Figure("kernel", "numpy RK4", 1e6 * numpy_rk4(plain, 1e-3, 2000)[0], "us")
    yield Figure(
        "kernel", "scalar numba loop, fewer channels", 1e6 * scalar_numba(plain, 1e-3, 4201)[0], "us"
    )
    crossing = ours * 4200
    yield Figure("kernel", "one crossing at 300 km/h (beside others)", 1e3 * crossing, "ms")
    yield Figure(
        "kernel", "SciPy RK45, rtol 1e-3, the same", 1e3 * scipy_solution(plain, "RK45", 1e-3, 4.2), "ms"
    )
    matched = 1e3 * scipy_solution(plain, "DOP853", 1e-6, 4.2)
    yield Figure("kernel", "SciPy DOP853, rtol 1e-6 (matched accuracy)", matched, "ms")
    hertz = ("contact={model: hertz}", "solver={sampling: 0.0001, substeps: 1, duration: 0.5}")
    rough = ("track.irregularity.random={spectrum: german-low, coherence: independent}",)
    for name, overrides, goal in (
        ("contact hertz over the paper's", hertz, 2.5),
        ("irregular rails over level ones", rough, None),
        ("contact hertz on irregular rails over both", (*hertz, *rough), 2.5),
    ):
        yield Figure("kernel", name, per_case_step(batch_of(*overrides)) / ours, "x", goal)


def practice() -> Iterator[Figure]:
    """Whole trains over one car, and the ten trains HSLM-A on eight spans at 101 speeds."""
    physical = ("contact.static_load=physical", "solver={sampling: 0.001, substeps: 1, duration: 1.5}")
    one, train = (batch_of(f"train={name}", *physical) for name in ("crh380a", "crh380al-16"))
    cost = per_case_step(train, 3) / per_case_step(one, 3)
    yield Figure("practice", "16 cars over one, one case-step", cost, "x", 16.0)
    with tempfile.TemporaryDirectory() as folder:
        out = ["--overwrite", "-o", f"{folder}/r.h5"]
        for method in ("exact", "rk4"):
            run = ("run", "practice/hslm-a", *out, "--set", f"solver.method={method}")
            seconds = min(tbi(*run)[0] for _ in range(3))
            yield Figure("practice", f"HSLM-A1 to A10, 8 spans, 101 speeds, {method}", seconds, "s", 5.0)


def scaling() -> Iterator[Figure]:
    """How cost grows with steps, cores, modes, scenarios."""
    small = batch_of("solver.duration=1.9")
    per_step = {}
    for copies, repeat in ((64, 5), (640, 2), (6400, 1), (62_000, 1)):
        batch = batch_of("solver.duration=1.92", copies=min(copies, 640))
        calls = max(1, copies // 640)
        steps = int(np.sum(batch.last)) * calls
        per_step[steps] = best(lambda b=batch, n=calls: [solve(b) for _ in range(n)], repeat) / steps  # type: ignore[misc]
    first = next(iter(per_step.values()))
    for steps, seconds in per_step.items():
        yield Figure(
            "scaling", f"{steps:.1e} case-steps: cost of one over that of the fewest", seconds / first, "x"
        )
    spread = max(per_step.values()) / min(per_step.values())
    yield Figure("scaling", "largest over smallest cost, 1e5 to 1e8", spread, "x", 1.1)

    def threads(count: int) -> float:
        def work() -> None:
            for _ in range(60 // count):
                solve(small)

        workers = [threading.Thread(target=work) for _ in range(count)]
        begin = time.perf_counter()
        for worker in workers:
            worker.start()
        for worker in workers:
            worker.join()
        return time.perf_counter() - begin

    gain = max(threads(1) / threads(2) for _ in range(3))
    yield Figure("scaling", "two cores over one", gain, "x", 1.9, at_least=True)
    base = per_case_step(batch_of("bridge.modes=4"), 3)
    for modes in (1, 2, 8, 20):
        cost = per_case_step(batch_of(f"bridge.modes={modes}"), 3)
        yield Figure("scaling", f"{modes} modes over 4", cost / base, "x")
    for copies in (1, 8, 16, 256):
        yield Figure(
            "scaling",
            f"{copies} scenarios, one case-step",
            1e6 * per_case_step(batch_of(copies=copies), 3),
            "us",
        )
    for step in ("0.01", "0.0001"):
        cost = per_case_step(batch_of(f"solver.sampling={step}", "solver.substeps=auto"), 3)
        yield Figure("scaling", f"sampling {step} s, substeps auto, one case-step", 1e6 * cost, "us")


def tbi(*arguments: str, **environment: str) -> tuple[float, int]:
    """Seconds and peak memory (bytes) of one command."""
    begin = time.perf_counter()
    process = subprocess.Popen(
        [sys.executable, "-m", "tbi_cli", *arguments],
        env=os.environ | environment,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    _, status, usage = os.wait4(process.pid, 0)
    seconds = time.perf_counter() - begin
    if status:
        raise RuntimeError(f"tbi {' '.join(arguments)} ended with {status}")
    return seconds, usage.ru_maxrss * 1024


def cli() -> Iterator[Figure]:
    """Commands from the shell prompt and back, kernels compiled unless said otherwise."""
    with tempfile.TemporaryDirectory() as folder:
        out = ["--overwrite", "-o", f"{folder}/r.h5"]
        tbi("run", "paper", *out)

        def fastest(*arguments: str) -> float:
            return min(tbi(*arguments)[0] for _ in range(5))

        yield Figure("cli", "tbi --help", fastest("--help"), "s", 0.3)
        yield Figure("cli", "tbi run, one case", fastest("run", "paper", *out), "s", 1.2)
        sweep = fastest("sweep", "velocity", *out)
        batch = Solver(load_case("paper/velocity"))
        yield Figure("cli", "tbi sweep velocity, 397 speeds", sweep, "s", 2.5)
        yield Figure("cli", "of it outside the kernel", sweep - _kernel_seconds(batch), "s", 1.2)
        campaign = min(tbi("run", "paper/campaign", *out)[0] for _ in range(3))
        yield Figure("cli", "tbi run paper/campaign: velocity x masses, spans, damping", campaign, "s", 8.0)
        first, _ = tbi("run", "paper", *out, TBI_CACHE_DIR=f"{folder}/cache")
        yield Figure("cli", "first run ever, compilation included", first, "s", 20.0)


def _kernel_seconds(solver: Solver) -> float:
    """What the kernel alone takes for a sweep on the processors there are."""
    from tbi_cli.resources import available_cpus

    result = solver.solve(range(len(solver.scenarios)))
    assert result is not None
    return float(result.solve_seconds.sum()) / available_cpus()


def memory() -> Iterator[Figure]:
    """Peak memory of whole runs."""
    with tempfile.TemporaryDirectory() as folder:
        out = ["--overwrite", "-o", f"{folder}/r.h5"]
        _, few = tbi("sweep", "velocity", *out)
        fine = ["--from", "20", "--to", "200", "--step", "0.045", "--set", "solver.duration=1"]
        _, many = tbi("sweep", "velocity", *fine, *out)
        tables = 4001 * 77 * 5 * 8
        yield Figure("memory", "tbi sweep velocity, 397 speeds", few / 2**20, "MiB", 350 * 1e6 / 2**20)
        yield Figure(
            "memory", "4001 speeds, tables taken off", (many - tables) / 2**20, "MiB", 350 * 1e6 / 2**20
        )


def histories() -> Iterator[Figure]:
    """Raw data of histories per second of a whole command, less what the command takes without them."""
    with tempfile.TemporaryDirectory() as folder:
        out = ["--overwrite", "-o", f"{folder}/r.h5"]
        speeds = ["sweep", "velocity", "--from", "20", "--to", "100", "--step", "1"]
        bare = min(tbi(*speeds, *out)[0] for _ in range(2))
        full, peak = min(tbi(*speeds, *out, "--set", "output.histories=all") for _ in range(3))
        size = Path(folder, "r.h5").stat().st_size
        yield Figure("histories", "written", size / 1e6, "MB")
        yield Figure("histories", "rate, of the whole command", size / 1e6 / full, "MB/s", 200, at_least=True)
        yield Figure("histories", "rate, of the time they add", size / 1e6 / max(full - bare, 1e-3), "MB/s")
        yield Figure("histories", "peak memory", peak / 2**20, "MiB")


def accuracy() -> Iterator[Figure]:
    """Peaks against DOP853, rtol 1e-10, restarted at every axle event and read at the same samples."""
    speeds = (
        2.5,
        11,
        18.5,
        27.3,
        36,
        45.7,
        54.1,
        64.4,
        71.5,
        83.333,
        97,
        111.1,
        121.7,
        138,
        150.3,
        168.5,
        185.2,
        199.5,
    )
    yield from _against_dop853("1 ms, 2-200 m/s", speeds, 2e-4, 1e-3)
    yield from _against_dop853("1 ms, events on steps", (10, 25, 50, 100), 1e-5, 1e-5)
    worst = 0.0
    for overrides in (("velocity=83.333",), ("velocity=20",), ("bridge.length=30", "velocity=150")):
        auto = ("solver.sampling=auto", "solver.substeps=auto", *overrides)
        grid = Solver(load_case("paper", overrides=auto)).scenarios.crosser(0).grid
        fine = (f"solver.sampling={grid.sampling / 4!r}", "solver.substeps=auto", *overrides)
        coarse, exact = _peaks(auto), _peaks(fine)
        worst = max(worst, *(abs(coarse[name] / exact[name] - 1) for name in coarse))
    yield Figure("accuracy", "auto sampling against four times as many", 100 * worst, "%", 0.1)


def _peaks(overrides: Sequence[str]) -> dict[str, float]:
    solver = Solver(load_case("paper", overrides=overrides))
    result = solver.solve([0])
    assert result is not None
    return dict(zip((c.name for c in solver.tables), result.tables["peak"][0].tolist(), strict=True))


def _against_dop853(label: str, speeds: Sequence[float], goal: float, goal_acc: float) -> Iterator[Figure]:
    worst = {False: 0.0, True: 0.0}
    for speed in speeds:
        overrides = (f"velocity={speed}", "solver.duration=1.5")
        case = load_case("paper", overrides=overrides)
        times = np.arange(int(1.5 * 70 / speed / 1e-3 + 1e-9) + 1) * 1e-3
        exact = crossing_channels(case.resolved(), times)
        for name, value in _peaks(overrides).items():
            other = float(np.max(np.abs(exact[name])))
            accelerated = "acceleration" in name
            worst[accelerated] = max(worst[accelerated], abs(value / other - 1))
    yield Figure("accuracy", f"{label}: displacements and forces", worst[False], "relative", goal)
    yield Figure("accuracy", f"{label}: accelerations", worst[True], "relative", goal_acc)


SECTIONS = (kernel, practice, scaling, cli, memory, histories, accuracy)


def main() -> None:
    """Runs the sections asked for."""
    names = {section.__name__: section for section in SECTIONS}
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("sections", nargs="*", choices=[[], *names], help="which (default: all)")
    parser.add_argument("--json", action="store_true", help="print JSON instead of a table")
    arguments = parser.parse_args()
    figures: list[Figure] = []
    for name in arguments.sections or names:
        for figure in names[name]():
            figures.append(figure)
            if not arguments.json:
                mark = {None: "", True: "met", False: "NOT met"}[figure.met]
                sign = ">=" if figure.at_least else "<="
                goal = "" if figure.goal is None else f"{sign} {figure.goal:.4g}"
                value = f"{figure.value:10.4g} {figure.unit:18}"
                print(f"{figure.section:10} {figure.name:58} {value} {goal:10} {mark}", flush=True)
    if arguments.json:
        machine = {"processor": platform.processor() or platform.machine(), "cpus": os.cpu_count()}
        print(
            json.dumps(
                {"machine": machine, "figures": [asdict(f) | {"met": f.met} for f in figures]}, indent=1
            )
        )


if __name__ == "__main__":
    main()
