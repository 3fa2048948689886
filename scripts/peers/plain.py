"""The same crossing one scenario at a time: numpy, SciPy and a scalar numba loop."""

from __future__ import annotations

import time

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from tbi_cli.batch import Model

Array = NDArray[np.float64]


class PlainCrossing:
    """x'' = A (x, x') + contact of one scenario, as a numpy user would write it."""

    def __init__(self, model: Model, velocity: float) -> None:
        s = model.system
        self.velocity, self.length, self.offsets = velocity, s.length, s.axle_offsets
        entries, self.n, self.nv = model.matrix, len(s.beams[0].omega), len(s.coordinates)
        self.nd = entries.columns // 2
        self.A = np.zeros((self.nd, 2 * self.nd))
        self.A[entries.row, entries.column] = entries.value
        self.modes = np.arange(1, self.n + 1)
        self.k, self.c, self.load, self.gain = model.wheels.T
        self.axle = s.wheel_axle
        self.rows = s.wheel_rows
        self.rows_over_mass = s.wheel_rows / s.M
        self.first_mode = self.nv + self.n * s.wheel_beam
        self.columns = self.first_mode[:, None] + np.arange(self.n)

    def __call__(self, t: float, y: Array, on: Array | None = None) -> Array:
        """The rate of the state (x, x'); `on` says which axles are on the bridge."""
        nd, nv = self.nd, self.nv
        place = self.velocity * t - self.offsets
        on = (place >= 0) & (place <= self.length) if on is None else on
        a = self.A @ y
        if on.any():
            wheels = on[self.axle]
            shape = np.sin(self.modes * np.pi * place[self.axle][:, None] / self.length) * wheels[:, None]
            w = np.sum(shape * y[self.columns], axis=1)
            rate = np.sum(shape * y[nd + self.columns], axis=1)
            pull = self.k * w + self.c * rate
            a[:nv] += self.rows_over_mass.T @ pull
            tension = self.k * (self.rows @ y[:nv]) + self.c * (self.rows @ y[nd : nd + nv]) - pull
            force = self.gain * (tension - self.load) * wheels
            np.add.at(a, self.columns, shape * force[:, None])
        return np.concatenate([y[nd:], a])


def numpy_rk4(crossing: PlainCrossing, h: float, steps: int) -> tuple[float, Array]:
    """Seconds per step of a Runge-Kutta loop in numpy, and the largest |x|, |x''| of each coordinate."""
    y, peak = np.zeros(2 * crossing.nd), np.zeros(2 * crossing.nd)
    begin = time.perf_counter()
    for j in range(steps):
        t = j * h
        middle = crossing.velocity * (t + h / 2) - crossing.offsets
        on = (middle >= 0) & (middle <= crossing.length)
        k1 = crossing(t, y, on)
        k2 = crossing(t + h / 2, y + h / 2 * k1, on)
        k3 = crossing(t + h / 2, y + h / 2 * k2, on)
        k4 = crossing(t + h, y + h * k3, on)
        sampled = np.concatenate([y[: crossing.nd], k1[crossing.nd :]])
        peak = np.maximum(peak, np.abs(sampled))
        y = y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return (time.perf_counter() - begin) / steps, peak


def scipy_solution(crossing: PlainCrossing, method: str, rtol: float, end: float) -> float:
    """Seconds of SciPy's solve_ivp for the whole window, output at its own steps."""
    begin = time.perf_counter()
    solve_ivp(crossing, (0, end), np.zeros(2 * crossing.nd), method=method, rtol=rtol, atol=1e-9)
    return time.perf_counter() - begin


@njit
def _scalar(  # type: ignore[no-untyped-def]
    A, columns, rows, gm, axle, k, c, load, gain, offsets, v, length, h, steps
):
    nd = A.shape[0]
    nv, n, wheels = rows.shape[1], columns.shape[1], columns.shape[0]
    y, z, peak = np.zeros(2 * nd), np.zeros(2 * nd), np.zeros(2 * nd)
    a = np.zeros((4, nd))
    shape = np.zeros((wheels, n))
    for j in range(steps):
        z[:] = y
        for stage in range(4):
            t = (j + 0.5 * ((stage + 1) // 2)) * h
            for i in range(nd):
                total = 0.0
                for m in range(2 * nd):
                    if A[i, m] != 0.0:
                        total += A[i, m] * z[m]
                a[stage, i] = total
            for wheel in range(wheels):
                middle = v * (j + 0.5) * h - offsets[axle[wheel]]
                if middle < 0 or middle > length:
                    continue
                place = v * t - offsets[axle[wheel]]
                w = rate = 0.0
                for i in range(n):
                    shape[wheel, i] = np.sin((i + 1) * np.pi * place / length)
                    w += shape[wheel, i] * z[columns[wheel, i]]
                    rate += shape[wheel, i] * z[nd + columns[wheel, i]]
                pull = k[wheel] * w + c[wheel] * rate
                s = ds = 0.0
                for i in range(nv):
                    s += rows[wheel, i] * z[i]
                    ds += rows[wheel, i] * z[nd + i]
                    a[stage, i] += gm[wheel, i] * pull
                force = gain[wheel] * (k[wheel] * s + c[wheel] * ds - pull - load[wheel])
                for i in range(n):
                    a[stage, columns[wheel, i]] += shape[wheel, i] * force
            if stage == 0:
                for i in range(nd):
                    peak[i] = max(peak[i], abs(y[i]))
                    peak[nd + i] = max(peak[nd + i], abs(a[0, i]))
            if stage < 3:
                f = h if stage == 2 else h / 2
                for i in range(nd):
                    z[i] = y[i] + f * z[nd + i]
                    z[nd + i] = y[nd + i] + f * a[stage, i]
        for i in range(nd):
            y[i] += h * y[nd + i] + h * h / 6 * (a[0, i] + a[1, i] + a[2, i])
            y[nd + i] += h / 6 * (a[0, i] + 2 * a[1, i] + 2 * a[2, i] + a[3, i])
    return peak


def scalar_numba(crossing: PlainCrossing, h: float, steps: int) -> tuple[float, Array]:
    """Seconds per step of a scalar loop compiled by numba, and the same peaks as `numpy_rk4`."""
    c = crossing
    arguments = (
        *(c.A, c.columns, c.rows, c.rows_over_mass, c.axle, c.k, c.c, c.load, c.gain, c.offsets),
        *(c.velocity, c.length, h),
    )
    _scalar(*arguments, 1)
    begin = time.perf_counter()
    peak = _scalar(*arguments, steps)
    return (time.perf_counter() - begin) / steps, peak
