"""A simply supported beam as finite elements under moving forces: no modes, no influence lines.

Euler-Bernoulli elements of cubic shape functions, deflection upwards and slope at each node, integrated by
the rule of the mean acceleration.  Moments and shear forces at a node are what the element behind it needs.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh, lu_factor, lu_solve

Array = NDArray[np.float64]


class ElementBeam:
    """EI (N m2), mu (kg/m) and c (N s/m per m) of a beam, in `count` equal elements."""

    def __init__(self, length: float, EI: float, mu: float, c: float, count: int = 60) -> None:
        self.length, self.count, self.h = length, count, length / count
        h = self.h
        bend = [[12, 6 * h, -12, 6 * h], [6 * h, 4 * h * h, -6 * h, 2 * h * h]]
        bend += [[-12, -6 * h, 12, -6 * h], [6 * h, 2 * h * h, -6 * h, 4 * h * h]]
        mass = [[156, 22 * h, 54, -13 * h], [22 * h, 4 * h * h, 13 * h, -3 * h * h]]
        mass += [[54, 13 * h, 156, -22 * h], [-13 * h, -3 * h * h, -22 * h, 4 * h * h]]
        self.k, self.m = np.array(bend) * EI / h**3, np.array(mass) * mu * h / 420
        self.gamma = c / mu
        size = 2 * count + 2
        K, M = np.zeros((size, size)), np.zeros((size, size))
        for e in range(count):
            at = slice(2 * e, 2 * e + 4)
            K[at, at] += self.k
            M[at, at] += self.m
        self.free = np.setdiff1d(np.arange(size), [0, 2 * count])
        self.K, self.M = (matrix[np.ix_(self.free, self.free)] for matrix in (K, M))

    def frequencies(self, n: int) -> Array:
        """The lowest n circular natural frequencies (rad/s)."""
        return np.sqrt(eigh(self.K, self.M, eigvals_only=True)[:n])

    def loads(self, force: float, x: float) -> tuple[int, Array]:
        """Element under a force (N, downwards) at x, and its four nodal loads; none off the beam."""
        if not 0 <= x <= self.length:
            return 0, np.zeros(4)
        e = min(int(x / self.h), self.count - 1)
        s = x / self.h - e
        shapes = [
            1 - 3 * s**2 + 2 * s**3,
            self.h * s * (1 - s) ** 2,
            s**2 * (3 - 2 * s),
            self.h * s**2 * (s - 1),
        ]
        return e, -force * np.array(shapes)

    def crossing(
        self,
        forces: Sequence[float],
        behind: Sequence[float],
        velocity: float,
        step: float,
        steps: int,
        node: int,
    ) -> tuple[Array, Array, Array]:
        """Deflection, moment and shear force (steps + 1,) at a node, as the results file counts them."""
        size = 2 * self.count + 2
        C = self.gamma * self.M
        lu = lu_factor(self.K + 2 / step * C + 4 / step**2 * self.M)
        u, v, a = (np.zeros(size) for _ in range(3))
        w, M, V = (np.zeros(steps + 1) for _ in range(3))
        free = self.free
        for j in range(1, steps + 1):
            load, here = np.zeros(size), np.zeros(4)
            for force, distance in zip(forces, behind, strict=True):
                e, four = self.loads(force, velocity * j * step - distance)
                load[2 * e : 2 * e + 4] += four
                here += four * (e == node)
            past = 4 / step**2 * u + 4 / step * v + a
            rate = 2 / step * u + v
            new = np.zeros(size)
            new[free] = lu_solve(lu, load[free] + self.M @ past[free] + C @ rate[free])
            v, a, u = 2 / step * (new - u) - v, 4 / step**2 * new - past, new
            at = slice(2 * node, 2 * node + 4)
            ends = self.k @ u[at] + self.m @ (a[at] + self.gamma * v[at]) - here
            # What the beam before the node does to the element: it pushes up by V and turns by -M.
            w[j], V[j], M[j] = u[2 * node], ends[0], -ends[1]
        return w, M, V
