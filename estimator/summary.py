"""Windows of a moving horizon reduced to quadratics in what is estimated: their sum, its minimum and how sure it is."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

LEAST_CURVATURE = 1e-9
"""Curvature of windows that say nothing of n: a standard deviation of 3e4."""


@dataclass
class Summary:
    """Quadratics of the windows seen so far: point of linearisation, curvature, gradient, initial states and cost of each."""

    at: list[Array] = field(default_factory=list)
    hessian: list[Array] = field(default_factory=list)
    gradient: list[Array] = field(default_factory=list)
    states: list[Array] = field(default_factory=list)
    cost: list[float] = field(default_factory=list)

    def minimum(self, weight: Array, prior: tuple[Array, Array] | None = None, rows: slice = slice(None)) -> tuple[Array, Array]:
        """(A,) minimum and (A, A) curvature of the sum of quadratics by `weight` (W,); prior: centre and standard deviation."""
        rows = _counted(weight, rows)
        at, hessian, gradient = (np.array(part[rows]) for part in (self.at, self.hessian, self.gradient))
        total = np.einsum("w,wkl->kl", weight[rows], hessian)
        lean = np.einsum("w,wk->k", weight[rows], np.einsum("wkl,wl->wk", hessian, at) - gradient)
        if prior is not None:
            total = total + np.diag(1.0 / prior[1] ** 2)
            lean = lean + prior[0] / prior[1] ** 2
        return np.linalg.solve(total + LEAST_CURVATURE * np.eye(len(total)), lean), total

    def scatter(self, n: Array, weight: Array, rows: slice = slice(None)) -> Array:
        """(A, A) scatter of the windows' scores at n (A,), by `weight` (W,)."""
        rows = _counted(weight, rows)
        at, hessian, gradient = (np.array(part[rows]) for part in (self.at, self.hessian, self.gradient))
        scores = gradient + np.einsum("wkl,wl->wk", hessian, n - at)
        return np.einsum("w,wk,wl->kl", weight[rows], scores, scores)

    def variance(self, n: Array, weight: Array, prior: tuple[Array, Array] | None = None, rows: slice = slice(None)) -> Array:
        """(A,) variance of a minimum n (A,) by `weight` (W,), `prior`, `rows`: sandwich of the scores, at least that of noise."""
        _, curvature = self.minimum(weight, prior, rows)
        inverse = np.linalg.inv(curvature + LEAST_CURVATURE * np.eye(len(curvature)))
        robust = inverse @ self.scatter(n, weight, rows) @ inverse
        return np.maximum(np.diag(robust), np.diag(inverse))


def _counted(weight: Array, rows: slice) -> slice:
    """The rows of a slice without those before the first that has a weight (W,), one at least: of a long drive most have none."""
    start, stop, _ = rows.indices(len(weight))
    counted = np.flatnonzero(weight[start:stop])
    return slice(start + int(counted[0]) if len(counted) else max(stop - 1, start), stop)
