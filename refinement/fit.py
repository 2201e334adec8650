"""Parameters of a model by prediction error over shooting windows: robust Gauss-Newton in a box, cluster-robust errors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import lsq_linear

from softsoil.windows.parameters import Free
from softsoil.windows.sandwich import jackknife_covariance
from softsoil.windows.shooting import Shooting

Array = NDArray[np.float64]

HUBER = 3.0
"""Standard deviations beyond which a residual counts linearly: spikes of a sensor do not pull."""
RELATIVE_STEP = 5e-6
"""Step of the differences that make the Jacobian, relative to a parameter's scale: rollouts are exact to 1e-12, so derivatives
are to 1e-5 (tests/symbolic/test_derivatives.py). Algorithmic ones cost eight times the compiling and three times the rollouts,
and at a bound where an effect is absent (a delay of 0) they give the branch that does not move; differences inwards give the
other."""
ITERATIONS = 12
SETTLED_COST, SETTLED_VALUE = 1e-3, 0.03
"""A fit is over when a step gains less than this share of the cost and moves no number by more than this share of its scale."""
DAMPINGS = ((0.01, 0.1, 1.0, 10.0), (1e2, 1e3, 1e4, 1e5))
"""Dampings tried from one linearisation, as multiples of the last one that helped. All of a group at once: in vector lanes four
parameter sets cost little more than one."""
FIRST_DAMPING, LEAST_DAMPING = 1e-2, 1e-5


@dataclass(frozen=True)
class Fit:
    """Result of a fit.

    free: what was free; value, std (K,): estimates and cluster-robust standard errors; p (D, n_p): all parameters of
    each drive; cost: mean robust squared residual over the fit windows, and the squares of what departs from what is
    known; at_bound: names that ended on a bound.
    """

    free: tuple[Free, ...]
    value: Array
    std: Array
    p: Array
    cost: float
    at_bound: tuple[str, ...]

    def named(self) -> dict[str, tuple[float, float]]:
        """Name -> (value, standard error)."""
        return {f.name: (float(v), float(s)) for f, v, s in zip(self.free, self.value, self.std, strict=True)}


@dataclass(frozen=True)
class Weights:
    """What a residual is measured against: sigma (6,) per channel, in its unit."""

    sigma: Array

    def cost(self, residual: Array) -> Array:
        """(W,) mean robust squared residual of each window, all channels alike; missing values do not count."""
        z = residual / self.sigma
        return np.nanmean(_huber(z), axis=(1, 2))


def _huber(z: Array) -> Array:
    size = np.abs(z)
    return np.where(size <= HUBER, z * z, HUBER * (2 * size - HUBER))


def fit(
    shootings: Sequence[Shooting],
    windows: Sequence[NDArray[np.int_]],
    weights: Weights,
    free: Sequence[Free],
    start: Array,
    p: Array,
    *,
    settle: bool = True,
    errors: bool = True,
) -> Fit:
    """Free numbers that predict the given windows best.

    shootings: one per drive; windows: their indices to fit, per drive; start (K,), or (S, K): the best of them is taken;
    p (D, n_p): all other parameters; settle: go on until the numbers stop as well as the cost, which alone decides between
    effects; errors: of the numbers, NaN without.
    """
    problem = _Problem(tuple(shootings), tuple(windows), weights, tuple(free), p)
    starts = [problem.clip(row) for row in np.atleast_2d(np.asarray(start, dtype=float))]
    raw = problem.raw(np.array(starts))
    problem, tried = replace(problem, seen=max(float(np.isfinite(raw[0]).mean()), 1e-9)), np.nan_to_num(raw)
    costs = [problem.cost(value, z) for value, z in zip(starts, tried, strict=True)]
    chosen = int(np.argmin(costs))
    value, residual, cost, damping = starts[chosen], tried[chosen], costs[chosen], FIRST_DAMPING
    for _ in range(ITERATIONS):
        jacobian = problem.jacobian(value, residual)
        for group in DAMPINGS:
            tries = [problem.clip(value + problem.step(value, jacobian, residual, damping * factor)) for factor in group]
            tried = problem.residuals(np.array(tries))
            costs = [problem.cost(candidate, z) for candidate, z in zip(tries, tried, strict=True)]
            chosen = int(np.argmin(costs))
            if costs[chosen] < cost:
                break
        else:
            break
        gain, change = cost - costs[chosen], np.abs(tries[chosen] - value) / problem.scale
        value, residual, cost = tries[chosen], tried[chosen], costs[chosen]
        damping = max(damping * group[chosen], LEAST_DAMPING)
        if gain < SETTLED_COST * cost and (not settle or change.max() < SETTLED_VALUE):
            break
    std = problem.std(value, problem.jacobian(value, residual), residual) if errors else np.full(len(value), np.nan)
    bounds = [f.name for f, v in zip(free, value, strict=True) if f.at_bound(v)]
    return Fit(tuple(free), value, std, problem.full(value), float(cost), tuple(bounds))


@dataclass(frozen=True)
class _Problem:
    """Residuals of the fit windows and their derivatives as functions of the free numbers."""

    shootings: tuple[Shooting, ...]
    windows: tuple[NDArray[np.int_], ...]
    weights: Weights
    free: tuple[Free, ...]
    p: Array
    seen: float = 1.0  # share of the fit windows' values that were measured

    @property
    def scale(self) -> Array:
        return np.array([f.scale for f in self.free])

    def clip(self, value: Array) -> Array:
        return np.clip(value, [f.lower for f in self.free], [f.upper for f in self.free])

    def full(self, value: Array) -> Array:
        p = self.p.copy()
        for f, v in zip(self.free, value, strict=True):
            for name in f.sets:
                p[slice(None) if f.drive is None else f.drives, self.shootings[0].model.p.index(name)] = v
        return p

    def residual(self, value: Array) -> Array:
        """(W, N, 6) residuals of the fit windows in standard deviations; missing values are 0."""
        return self.residuals(value[None])[0]

    def residuals(self, values: Array) -> Array:
        """(S, W, N, 6) residuals for many values (S, K) at once; missing values are 0."""
        return np.nan_to_num(self.raw(values))

    def raw(self, values: Array) -> Array:
        """(S, W, N, 6) residuals for many values (S, K) at once, NaN where nothing was measured."""
        p = np.array([self.full(value) for value in values])
        parts = [
            shooting.residual(p[:, d], windows)
            for d, (shooting, windows) in enumerate(zip(self.shootings, self.windows, strict=True))
        ]
        longest = max(part.shape[2] for part in parts)  # drives of several rates: no value after a window's last sample
        padded = [np.pad(part, ((0, 0), (0, 0), (0, longest - part.shape[2]), (0, 0)), constant_values=np.nan) for part in parts]
        return np.concatenate(padded, axis=1) / self.weights.sigma

    def cost(self, value: Array, z: Array) -> float:
        """Mean robust square of the residuals z (W, N, 6), and of what departs from what is known: as a channel of a window."""
        return float(np.mean(_huber(z)) / self.seen + np.sum(self._known(value)[0] ** 2) / (len(z) * z.shape[-1]))

    def _known(self, value: Array) -> tuple[Array, Array]:
        """(K,) departures from what is known in standard deviations, and their derivatives; 0 where nothing is."""
        known = [f.known for f in self.free]
        slope = np.array([0.0 if k is None else 1.0 / k[1] for k in known])
        return slope * (value - np.array([0.0 if k is None else k[0] for k in known])), slope

    def jacobian(self, value: Array, residual: Array) -> Array:
        """(W, N * 6, K) derivatives of the residual by one-sided differences, inwards at a bound."""
        steps = RELATIVE_STEP * self.scale
        steps = np.where(value + steps > [f.upper for f in self.free], -steps, steps)
        moved = self.residuals(value + np.diag(steps))
        flat = (moved - residual).reshape(len(steps), len(residual), -1) / steps[:, None, None]
        return np.moveaxis(flat, 0, -1)

    def _weighted(self, jacobian: Array, residual: Array) -> tuple[Array, Array]:
        z = residual.reshape(len(residual), -1)
        weight = np.minimum(1.0, HUBER / np.maximum(np.abs(z), 1e-12))
        return jacobian * weight[..., None], z

    def step(self, value: Array, jacobian: Array, residual: Array, damping: float) -> Array:
        """The damped Gauss-Newton step that stays inside the bounds: cut off at them, a step goes where none should."""
        weighted, z = self._weighted(jacobian, residual)
        away, slope = self._known(value)
        samples = residual.shape[1] * self.seen  # of a channel in a window: what is known weighs as much
        hessian = np.einsum("wmk,wml->kl", weighted, jacobian) + samples * np.diag(slope**2)
        gradient = self.scale * (np.einsum("wmk,wm->k", weighted, z) + samples * slope * away)
        scaled = hessian * np.outer(self.scale, self.scale)
        size, axes = np.linalg.eigh(scaled + damping * np.diag(np.diag(scaled)))
        # A parameter that moves nothing leaves a zero row: the floor keeps it where it is.
        root = np.sqrt(np.maximum(size, 1e-12 * max(size[-1], 1e-300)))
        lower, upper = ((np.array([getattr(f, end) for f in self.free]) - value) / self.scale for end in ("lower", "upper"))
        box = (np.minimum(lower, -1e-12), np.maximum(upper, 1e-12))
        return self.scale * lsq_linear((axes * root).T, -(axes.T @ gradient) / root, box, method="bvls").x

    def std(self, value: Array, jacobian: Array, residual: Array) -> Array:
        """Standard errors with windows as clusters, residuals inside of which are anything but independent: by leaving out one at
        a time, since a drive has few."""
        weighted, z = self._weighted(jacobian, residual)
        samples = residual.shape[1] * self.seen
        known = samples * np.diag((self._known(value)[1] * self.scale) ** 2)
        hessian = np.einsum("wmk,wml->kl", weighted, jacobian) * np.outer(self.scale, self.scale) + known
        per_window = np.einsum("wmk,wm->wk", weighted, z) * self.scale
        per_window = per_window - per_window.mean(axis=0)
        each = np.einsum("wmk,wml->wkl", weighted, jacobian) * np.outer(self.scale, self.scale)
        cov = jackknife_covariance(hessian, per_window, each, samples * known)
        return self.scale * np.sqrt(np.maximum(np.diag(cov), 0.0))
