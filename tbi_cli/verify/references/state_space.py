"""The state-space form of Appendix 1, X' = A(t) X + f(t), from the independent assembly.

The paper's order: a coordinate and its velocity side by side, those of Eq. (9) first, then the modes of
the right beam and of the left. The wheelset y are kinematic and have no states, so 54 + 4 n are left.
"""

from __future__ import annotations

import numpy as np

from tbi_cli.verify.references.crossing import CoupledSystem
from tbi_cli.verify.references.energies import COORDINATES, DYNAMIC
from tbi_cli.verify.references.parameters import Array


def state_names(system: CoupledSystem) -> list[str]:
    """Names of the states in the order of X: `car_body_y`, `car_body_y_velocity`, ..."""
    coordinates = [COORDINATES[i] for i in DYNAMIC]
    coordinates += [f"{side}_mode_{i + 1}" for side in ("right", "left") for i in range(system.n)]
    return [name for c in coordinates for name in (c, f"{c}_velocity")]


def state_space(system: CoupledSystem, time: float) -> tuple[Array, Array]:
    """A(t) (54 + 4n, 54 + 4n) and f(t) (54 + 4n,) of Eq. (21) at `time` [s]."""
    on = system.axles_on(time)
    phi, slope = system.shapes(time, on), system.shapes(time, on, 1)
    rows = np.hstack([system.wheel_rows, -phi])
    k, c = system.matrices.wheel_k[:, None], system.matrices.wheel_c[:, None]
    K, C = system.K + rows.T @ (k * rows), system.C + rows.T @ (c * rows)
    if system.crossing.convective:
        convected = np.hstack([np.zeros_like(system.wheel_rows), -system.crossing.velocity * slope])
        K = K + rows.T @ (c * convected)
    size = system.size
    A, f = np.zeros((2 * size, 2 * size)), np.zeros(2 * size)
    A[0::2, 1::2] = np.eye(size)
    A[1::2, 0::2] = -K / system.mass[:, None]
    A[1::2, 1::2] = -C / system.mass[:, None]
    beam_load = np.concatenate([np.zeros(system.n_train), -phi.T @ system.static_loads])
    f[1::2] = beam_load / system.mass
    return A, f
