"""Jobs, backends, shards, Dask and Slurm: the same bits everywhere."""

from __future__ import annotations

import subprocess
import time

from soaking.common import HISTORIES, Soak

from tbi_cli.shards import Shard
from tbi_cli.store import DONE, open_results
from tests.cluster.dask_here import DaskHere
from tests.cluster.runs import command, content, parts
from tests.cluster.slurm_here import SlurmHere, why_not

SECONDS = 1200.0


def jobs(soak: Soak) -> None:
    """The number of jobs and the backend leave no trace."""
    soak.tbi("run", "case.yaml", "-o", "one.h5", "-q", "-j", "1", "--overwrite", *HISTORIES)
    whole = content(soak.folder / "one.h5")
    ways = [("-j", "2"), ("-j", "4"), ("-j", "2", "--backend", "processes")]
    ways += [] if soak.short else [("-j", "4", "--backend", "processes"), ("-j", "3")]
    print(f"jobs: -j 1 against {len(ways)} other ways")
    for way in ways:
        soak.tbi("run", "case.yaml", "-o", "other.h5", "-q", "--overwrite", *way, *HISTORIES)
        soak.holds(f"{' '.join(way)}: the same bits", content(soak.folder / "other.h5") == whole)


def shards(soak: Soak) -> None:
    """Cut into shards and joined again."""
    soak.tbi("run", "case.yaml", "-o", "whole.h5", "-q", "--overwrite", *HISTORIES)
    whole = content(soak.folder / "whole.h5")
    numbers = (1, 3) if soak.short else (1, 3, 7, 16)
    print(f"shards: {', '.join(map(str, numbers))}")
    for of in numbers:
        names = [f"s{number}-{of}.h5" for number in range(1, of + 1)]
        for number, name in enumerate(names, 1):
            soak.tbi("run", "case.yaml", "-o", name, "-q", "--shard", f"{number}/{of}", *HISTORIES)
        soak.tbi("merge", *names, "-o", "merged.h5", "--overwrite")
        soak.holds(f"{of} shards, merged: the same bits", content(soak.folder / "merged.h5") == whole)


def dask(soak: Soak) -> None:
    """A scheduler and two workers; one worker is killed half-way."""
    fine = ("--set", "solver.sampling=0.0001", "--set", "solver.substeps=1", *HISTORIES)
    soak.tbi("run", "case.yaml", "-o", "whole.h5", "-q", "--overwrite", *fine)
    whole = content(soak.folder / "whole.h5")
    (soak.folder / "dask").mkdir()
    cluster = DaskHere(soak.folder / "dask")
    try:
        far = ("--backend", "dask", "--scheduler", cluster.address)
        print(f"dask: a scheduler and {len(cluster.workers)} workers at {cluster.address}")
        soak.tbi("run", "case.yaml", "-o", "dask.h5", "-q", *far, *fine)
        soak.holds("Dask: the same bits", content(soak.folder / "dask.h5") == whole)
        process = subprocess.Popen(
            command("run", "case.yaml", "-o", "dask.h5", "-q", "--overwrite", *far, *fine), cwd=soak.folder
        )
        while len(parts(soak.folder / "dask.h5")) < 8 and process.poll() is None:
            time.sleep(0.02)
        cluster.workers[0].kill()
        code = process.wait()
        same = content(soak.folder / "dask.h5") == whole
        soak.holds(
            "Dask, one of two workers killed half-way: it completes, the same bits", code == 0 and same
        )
    finally:
        cluster.stop()


def slurm(soak: Soak) -> None:
    """Ten thousand scenarios over sixteen shards through real Slurm, merged and reported."""
    if reason := why_not():
        print(f"slurm: not run, {reason}")
        return
    sweep = "sweep={velocity: {from: 20, to: 119.99, step: 0.01}}"
    many = ("--set", sweep, "--set", "solver.duration=2")
    begin = time.monotonic()
    soak.tbi("run", "case.yaml", "-o", "direct.h5", "-q", *many)
    direct = time.monotonic() - begin
    cluster = SlurmHere()
    try:
        begin = time.monotonic()
        arguments = ("submit", "case.yaml", "-o", "slurm.h5", "--shards", "16", "--report", *many)
        sent = soak.tbi(*arguments, **cluster.environment)
        if sent.returncode:
            soak.holds(f"sent: {sent.stderr}", False)
            return
        jobs = [line.split()[1].rstrip(":") for line in sent.stdout.splitlines() if line.startswith("job ")]
        cluster.wait_for(*jobs, seconds=SECONDS)
        taken = time.monotonic() - begin
    finally:
        cluster.stop()
    with open_results(soak.folder / "slurm.h5") as results:
        done = int((results.status == DONE).sum())
    print(f"slurm: {done} scenarios over 16 shards in {taken:.0f} s; {direct:.0f} s in one process")
    soak.holds("10,000 scenarios are done", done == 10_000)
    direct_bits, bits = content(soak.folder / "direct.h5"), content(soak.folder / "slurm.h5")
    soak.holds(f"{len(bits)} datasets: the same bits as in one process", direct_bits == bits)
    report = soak.folder / "slurm-report" / "report.html"
    soak.holds(f"reported: {report.stat().st_size / 1e6 if report.exists() else 0:.1f} MB", report.exists())
    shards = [
        Shard(number, 16).path(soak.folder / "slurm-slurm" / "shards" / "slurm.h5") for number in range(1, 17)
    ]
    steps = []
    for shard in shards:
        with open_results(shard) as results:
            steps.append(float(results.attributes["case_steps"]))
    balance = max(steps) / (sum(steps) / len(steps))
    soak.holds(
        f"the costliest shard has {100 * (balance - 1):.2f} % more steps than the mean", balance < 1.02
    )
