"""The smallest problem there is, for compiling the kernels.

There are two kinds: `general`, for whatever crosses a bridge, and `forces`, for trains of constant forces.
"""

from __future__ import annotations

import numpy as np

from tbi_cli.integrator.arrays import Crossing, Topology, work_space
from tbi_cli.integrator.exact import advance_exactly, one_interval
from tbi_cli.integrator.forces import advance_forces
from tbi_cli.integrator.kernel import advance
from tbi_cli.integrator.lanes import lane_zeros

KINDS = ("general", "forces")


def warm_up(kind: str) -> None:
    """Compiles the kernels of one kind, or loads them where they were compiled before."""
    none = np.zeros(0, dtype=np.int64)
    numbers, switches = (0, 0, 0, 0, 0, 0, 0), (False, False, False, False, False)
    topology = Topology(*numbers, *switches, *(none for _ in Topology._fields[12:]))
    crossing = Crossing(*(lane_zeros(11) for _ in Crossing._fields))
    if kind == "general":
        advance(topology, crossing, work_space(topology), 0, 1, lane_zeros(0, 0))
        return
    advance_forces(topology, crossing, work_space(topology), 0, 1, lane_zeros(0, 0))
    one_interval(np.zeros((0, 0)), np.zeros((0, 0)), np.zeros(0), np.zeros(0), np.zeros((0, 0)))
    advance_exactly(topology, crossing, work_space(topology), 0, lane_zeros(0, 0))
