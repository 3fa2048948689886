"""What this process may use of the machine."""

from __future__ import annotations

import contextlib
import os
import re
from pathlib import Path

_UNKNOWN = 2**62


def available_cpus() -> int:
    """CPUs for this job: what Slurm gave it, else what affinity and control group leave of the machine."""
    if re.fullmatch(r"0*[1-9][0-9]{0,3}", given := os.environ.get("SLURM_CPUS_PER_TASK", "")):
        return int(given)
    try:
        cpus = len(os.sched_getaffinity(0))
    except (AttributeError, OSError):
        cpus = os.cpu_count() or 1
    with contextlib.suppress(OSError, ValueError):
        quota, period = Path("/sys/fs/cgroup/cpu.max").read_text().split()
        if quota != "max":
            cpus = min(cpus, max(1, int(quota) // int(period)))
    return cpus


def available_memory() -> int:
    """Free memory in bytes, within the limits of control group and process; very large if nothing tells."""
    free = _UNKNOWN
    with contextlib.suppress(OSError, ValueError, StopIteration):
        lines = Path("/proc/meminfo").read_text().splitlines()
        free = int(next(line for line in lines if line.startswith("MemAvailable")).split()[1]) * 1024
    with contextlib.suppress(OSError, ValueError):
        limit = Path("/sys/fs/cgroup/memory.max").read_text().strip()
        used = int(Path("/sys/fs/cgroup/memory.current").read_text())
        if limit != "max":
            free = min(free, int(limit) - used)
    with contextlib.suppress(ImportError, OSError, ValueError):
        import resource  # not on Windows

        allowed, _ = resource.getrlimit(resource.RLIMIT_AS)
        if allowed != resource.RLIM_INFINITY:
            pages = int(Path("/proc/self/statm").read_text().split()[0])
            free = min(free, max(0, allowed - pages * resource.getpagesize()))
    return free
