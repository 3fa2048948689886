"""The matrices that the package assembles of a case, for the checks that need no run."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

from tbi_cli.verify.references.parameters import Array

if TYPE_CHECKING:
    from tbi_cli.system.assembly import System


def assembled(case: str) -> System:
    """The system of a case file's text, read and assembled as for a run."""
    from tbi_cli.case import load_case
    from tbi_cli.system.assembly import build_system

    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "case.yaml"
        file.write_text(case, encoding="utf-8")
        return build_system(load_case(file))


def accelerations(system: System, velocity: float, time: float, x: Array, x_t: Array) -> Array:
    """x'' (n_dof,) of the package's matrices at `time`: vehicle coordinates, then amplitudes of each beam.

    x, x_t (n_dof,): the state. The contact as in the integrator's description: a wheel's suspension acts on
    the beam under it while 0 <= xi <= L.
    """
    import numpy as np

    nv, n = len(system.coordinates), len(system.beams[0].omega)
    out = np.empty_like(x)
    forces = -(system.K @ x[:nv]) - system.C @ x_t[:nv]
    for b, beam in enumerate(system.beams):
        rows = slice(nv + b * n, nv + (b + 1) * n)
        out[rows] = -(beam.omega**2) * x[rows] - beam.damping * x_t[rows]
    order = np.arange(1, n + 1) * np.pi / system.length
    for wheel, g in enumerate(system.wheel_rows):
        b = int(system.wheel_beam[wheel])
        rows = slice(nv + b * n, nv + (b + 1) * n)
        xi = velocity * time - system.axle_offsets[system.wheel_axle[wheel]]
        if not 0 <= xi <= system.length:
            continue
        shape = np.sin(order * xi)
        w, w_t = shape @ x[rows], shape @ x_t[rows]
        if system.convective:
            w_t += velocity * (order * np.cos(order * xi)) @ x[rows]
        k, c = system.wheel_stiffness[wheel], system.wheel_damping[wheel]
        forces += g * (k * w + c * w_t)
        tension = k * (g @ x[:nv] - w) + c * (g @ x_t[:nv] - w_t)
        out[rows] += shape * (tension - system.wheel_load[wheel]) * system.beams[b].gain
    out[:nv] = forces / system.M
    return out
