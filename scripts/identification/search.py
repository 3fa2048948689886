"""Nonlinear least squares from many starts, and what the Jacobian says of the answer."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import qmc

from identification.parameters import Array, from_unit, published, to_unit
from identification.targets import Target
from identification.trials import Trials

# Share of its range by which a parameter is moved for a derivative: speeds and times come on grids.
_STEP = 0.03
# Deflections go as load over mass: what fits best differs by 2.3 between the two static loads.
_SCALES = (0.35, 0.45, 0.55, 0.7, 0.85, 1.0, 1.2, 1.5)
_PRIOR = 12.0  # 1/variance of a share that is anywhere between its bounds


@dataclass(frozen=True)
class Fit:
    """One answer: shares of the ranges (n,), our numbers and residuals (targets,), and the robust total."""

    trials: Trials
    shares: Array
    ours: Array
    residuals: Array

    @property
    def values(self) -> Array:
        """The parameters in SI."""
        return from_unit(self.trials.parameters, self.shares)

    @property
    def total(self) -> float:
        """Sum of soft-l1 losses, 2 (sqrt(1 + r2) - 1): about r2 where small, 2 |r| where large."""
        return robust(self.residuals)


def robust(residuals: Array) -> float:
    """The robust total of residuals."""
    return float(np.sum(2 * (np.sqrt(1 + residuals**2) - 1)))


class Problem:
    """Residuals and their Jacobian; a Jacobian costs one batch."""

    def __init__(self, trials: Trials, targets: Sequence[Target]) -> None:
        self.trials, self.targets = trials, targets
        self.value = np.array([target.value for target in targets])
        self.error = np.array([target.error for target in targets])

    def ours(self, shares: Array) -> Array:
        """Our numbers (sets, targets) for parameter sets (sets, n)."""
        solved = self.trials.solve(from_unit(self.trials.parameters, shares))
        found = np.array([[target.ours(one) for target in self.targets] for one in solved])
        return np.where(np.isfinite(found), found, 0.0)  # a peak that is not there

    def residuals(self, shares: Array) -> Array:
        """Ours less the paper's in units of the error."""
        return (self.ours(shares) - self.value) / self.error

    def jacobian(self, shares: Array, free: Array) -> Array:
        """The derivatives (targets, free parameters) of the residuals by shares of the ranges."""
        moved = np.repeat(shares[None], len(free) + 1, axis=0)
        steps = np.where(shares[free] + _STEP <= 1, _STEP, -_STEP)
        moved[np.arange(len(free)) + 1, free] += steps
        found = self.residuals(moved)
        return (found[1:] - found[0]).T / steps

    def at(self, shares: Array) -> Fit:
        """A parameter set as an answer."""
        ours = self.ours(shares[None])[0]
        return Fit(self.trials, shares, ours, (ours - self.value) / self.error)

    def scaled(self, start: Array) -> Fit:
        """The best of a few common factors of the first two parameters, the masses of the beams."""
        parameters = self.trials.parameters
        values = np.repeat(from_unit(parameters, start)[None], len(_SCALES), axis=0)
        values[:, :2] *= np.array(_SCALES)[:, None]
        shares = to_unit(parameters, values)
        ours = self.ours(shares)
        fits = [
            Fit(self.trials, one, found, (found - self.value) / self.error)
            for one, found in zip(shares, ours, strict=True)
        ]
        return min(fits, key=lambda fit: fit.total)

    def fit(self, start: Array, evaluations: int) -> Fit:
        """The best within the bounds that is found from a start."""
        free = np.arange(len(start))
        found = least_squares(
            lambda shares: self.residuals(shares[None])[0],
            np.clip(start, 1e-3, 1 - 1e-3),
            jac=lambda shares: self.jacobian(shares, free),
            bounds=(0.0, 1.0),
            loss="soft_l1",
            max_nfev=evaluations,
        )
        return self.at(found.x)


def starts(count: int, problem: Problem, seed: int) -> list[Array]:
    """The published vehicle, and a Latin hypercube over the bounds."""
    parameters = problem.trials.parameters
    cube = qmc.LatinHypercube(len(parameters), seed=seed).random(max(count - 1, 0))
    return [published(parameters), *cube]


def multi_start(
    problem: Problem,
    count: int,
    seed: int,
    evaluations: int,
    polish: int,
    jobs: int,
    tell: Callable[[Fit], None] = lambda fit: None,
) -> list[Fit]:
    """Answers from `count` starts, the best first, the two best followed further; `tell` hears of each."""
    found = []
    with ThreadPoolExecutor(jobs) as pool:
        for fit in pool.map(lambda start: problem.fit(start, evaluations), starts(count, problem, seed)):
            tell(fit)
            found.append(fit)
        found.sort(key=lambda fit: fit.total)
        for k, fit in enumerate(pool.map(lambda fit: problem.fit(fit.shares, polish), found[:2])):
            tell(fit)
            found[k] = fit
    return sorted(found, key=lambda fit: fit.total)


@dataclass(frozen=True)
class Certainty:
    """What the numbers say of the parameters, by the Jacobian at an answer.

    spread: standard errors over that of a parameter that is anywhere in its range: 0 is pinned down, 1 not at
    all; correlation: of the parameters; singular: values of the weighted Jacobian.
    """

    spread: Array
    correlation: Array
    singular: Array


def certainty(problem: Problem, fit: Fit) -> Certainty:
    """Linearised, residuals that are far off being worth less, scaled by the misfit that remains."""
    free = np.arange(len(fit.shares))
    weight = (1 + fit.residuals**2) ** -0.25
    jacobian = problem.jacobian(fit.shares, free) * weight[:, None]
    left = max(len(fit.residuals) - len(free), 1)
    scale = max(1.0, float(np.sum((weight * fit.residuals) ** 2)) / left)
    covariance = np.linalg.inv(jacobian.T @ jacobian / scale + _PRIOR * np.eye(len(free)))
    deviation = np.sqrt(np.diag(covariance))
    return Certainty(
        spread=deviation * np.sqrt(_PRIOR),
        correlation=covariance / np.outer(deviation, deviation),
        singular=np.linalg.svd(jacobian / np.sqrt(scale), compute_uv=False),
    )
