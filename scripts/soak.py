#!/usr/bin/env python
"""Kills, full disks, hostile files, clusters, shortages: nothing is lost and the bits are the same.

    python scripts/soak.py                  all of it (most of an hour)
    python scripts/soak.py kills slurm      some of it: kills, disk, kernels, paths, strangers, jobs, shards,
                                            dask, slurm, environment, streams, shortages, interrupts
    python scripts/soak.py --short          a few kills and full disks, for the tests

Prints what was done and counted, and ends with exit code 1 if anything did not hold.  Dask and Slurm are
started here, on the loopback interface; Slurm needs root.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from soaking.clusters import dask, jobs, shards, slurm
from soaking.common import Soak
from soaking.hostile import paths, strangers
from soaking.kills import child, kills
from soaking.places import disk, kernels
from soaking.surroundings import environment, interrupts, shortages, streams

FUNCTIONS = (
    *(kills, disk, kernels, paths, strangers, jobs, shards, dask, slurm),
    *(environment, streams, shortages, interrupts),
)
SECTIONS: dict[str, Callable[[Soak], None]] = {function.__name__: function for function in FUNCTIONS}
SHORT = ("kills", "disk", "paths", "strangers")


def main() -> int:
    """The exit code."""
    if sys.argv[1:2] == ["--child"]:
        return child(sys.argv[2], sys.argv[3:])
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("sections", nargs="*", choices=[[], *SECTIONS], metavar="SECTION")
    parser.add_argument("--short", action="store_true", help="a few of each, for the tests")
    options = parser.parse_args()
    chosen = options.sections or (SHORT if options.short else SECTIONS)
    failed = False
    for name in chosen:
        with tempfile.TemporaryDirectory(prefix="tbi-soak-") as folder:
            soak = Soak(Path(folder), short=options.short)
            begin = time.monotonic()
            SECTIONS[name](soak)
            print(
                f"{name}: {'FAILED' if soak.failed else 'holds'}, {time.monotonic() - begin:.0f} s\n",
                flush=True,
            )
            failed |= soak.failed
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
