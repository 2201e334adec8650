"""Parameters from windows with free initial states: robust Gauss-Newton, initial states eliminated window by window.

Minimise sum over windows min over x0 of sum rho(z(theta, x0)) + sum ((theta - prior)/std)^2 with rho of Huber. A prior counts
as one observation. The covariance is the sandwich of the windows' scores, since what a model misses is not white inside a window.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from softsoil.windows.free_windows import FreeWindows, Linear
from softsoil.windows.parameters import Free
from softsoil.windows.sandwich import cluster_covariance

Array = NDArray[np.float64]

HUBER = 3.0
"""Standard deviations beyond which a residual counts linearly."""
ITERATIONS = 15
SETTLED = 0.01
"""A fit is over when no number moves by more than this share of its scale and its standard error, whichever is larger."""
DAMPINGS = (0.0, 1e-2, 1e-1, 1.0, 10.0, 1e2)
LONGEST = 3.0
"""Scales that a number moves at most in one step."""
RIDGE = 1e-6
"""Weight of an initial state that the window does not see at all."""


class Beside(Protocol):
    """Observations of one drive beside its windows, which depend on the parameters alone, in nearly independent clusters."""

    @property
    def times(self) -> Array:
        """(C,) time of each cluster (s)."""
        ...

    @property
    def prior(self) -> bool:
        """Whether it is what is known beforehand, which scatters as it is stated to, and no data."""
        ...

    def residual(self, p: Array) -> Array:
        """(C, m) residuals in standard deviations for parameters p (n_p,)."""
        ...

    def linearise(self, p: Array, free: Sequence[Free]) -> Linear:
        """Residuals and derivatives at p (n_p,), without states."""
        ...


@dataclass(frozen=True)
class WindowFit:
    """Result of a fit.

    free; value, std (K,); covariance (K, K), sandwich; information (K, K): Gauss-Newton, without what is `known` of each number;
    p (D, n_p): parameters per drive; x0: initial states (W, 6) per drive; cost: mean squared robust residual; costs (W,): per
    window of all drives; scores (C, K), hessians (C, K, K): gradient and Gauss-Newton Hessian of the cost of each cluster, the
    windows and then what was observed beside them; places (C, 2): drive and time (s) of each; at_bound: names on a bound.
    """

    free: tuple[Free, ...]
    value: Array
    std: Array
    covariance: Array
    information: Array
    p: Array
    x0: tuple[Array, ...]
    cost: float
    costs: Array
    scores: Array
    hessians: Array
    places: Array
    at_bound: tuple[str, ...]

    def named(self) -> dict[str, tuple[float, float]]:
        """Name -> (value, standard error)."""
        return {f.name: (float(v), float(s)) for f, v, s in zip(self.free, self.value, self.std, strict=True)}

    @property
    def correlation(self) -> Array:
        """(K, K) correlation of the estimates."""
        spread = np.sqrt(np.maximum(np.diag(self.covariance), 1e-300))
        return self.covariance / np.outer(spread, spread)


@dataclass(frozen=True)
class Reduced:
    """One drive's windows with the initial states eliminated.

    hessian (W, K, K), gradient (W, K): of the numbers; inverse (W, 6, 6), cross (W, 6, K), lean (W, 6): to recover the states.
    """

    hessian: Array
    gradient: Array
    inverse: Array
    cross: Array
    lean: Array

    def states(self, step: Array) -> Array:
        """(W, 6) steps of the initial states that belong to a step (K,) of the numbers."""
        return -np.einsum("wij,wj->wi", self.inverse, self.lean + self.cross @ step)


def reduce_windows(linear: Linear) -> Reduced:
    """Schur complement of the initial states in the robust normal equations of each window."""
    weight = np.minimum(1.0, HUBER / np.maximum(np.abs(linear.residual), 1e-12))[..., None]
    by_state, by_free = linear.by_state * weight, linear.by_free * weight
    a = np.einsum("wmi,wmj->wij", by_state, linear.by_state) + RIDGE * np.eye(linear.by_state.shape[-1])
    cross = np.einsum("wmi,wmk->wik", by_state, linear.by_free)
    lean = np.einsum("wmi,wm->wi", by_state, linear.residual)
    inverse = np.linalg.inv(a)
    own = np.einsum("wmk,wml->wkl", by_free, linear.by_free)
    hessian = own - np.einsum("wik,wij,wjl->wkl", cross, inverse, cross)
    gradient = np.einsum("wmk,wm->wk", by_free, linear.residual) - np.einsum("wik,wij,wj->wk", cross, inverse, lean)
    return Reduced(hessian, gradient, inverse, cross, lean)


def window_costs(residual: Array) -> Array:
    """(W,) mean robust squared residual of each window, for residuals (W, m) in standard deviations."""
    size = np.abs(residual)
    return np.where(size <= HUBER, residual**2, HUBER * (2 * size - HUBER)).mean(axis=1)


def fit_windows(
    drives: Sequence[FreeWindows],
    free: Sequence[Free],
    start: Array,
    p: Array,
    beside: Sequence[Beside] = (),
    iterations: int = ITERATIONS,
) -> WindowFit:
    """Free numbers and initial states that predict the windows of all drives best.

    drives: windows of each; start (K,): first values; p (D, n_p): all other parameters; beside: what else was observed on each
    drive, none or one per drive; iterations: at most.
    """
    problem = _Problem(tuple(drives), tuple(free), np.atleast_2d(p), tuple(beside))
    value = problem.clip(np.asarray(start, dtype=float))
    x0 = [windows.first for windows in drives]
    cost = problem.cost(value, x0)
    for iteration in range(iterations):
        parts = problem.reduced(value, x0)
        hessian, gradient, _, _ = problem.normal(value, parts)
        for damping in DAMPINGS:
            step = problem.step(value, hessian, gradient, damping)
            tried = [x + part.states(step[mine]) for x, part, mine in zip(x0, parts, problem.mine, strict=True)]
            found = problem.cost(value + step, tried)
            if not found < cost * (1 + 1e-9):
                tried = problem.nearer(value + step, tried, x0)
                found = problem.cost(value + step, tried)
            if found < cost * (1 + 1e-9):
                break
        else:
            break
        value, x0, cost = value + step, tried, found
        for windows, row, states in zip(drives, problem.full(value), x0, strict=True):
            windows.follow(row, states)
        cost = problem.cost(value, x0)
        error = np.sqrt(np.maximum(np.diag(np.linalg.pinv(hessian)), 0.0))
        if iteration > 0 and np.all(np.abs(step) < SETTLED * np.maximum(problem.scale, error)):
            break
    return problem.result(value, x0)


@dataclass(frozen=True)
class _Problem:
    drives: tuple[FreeWindows, ...]
    free: tuple[Free, ...]
    p: Array
    beside: tuple[Beside, ...] = ()

    @property
    def scale(self) -> Array:
        return np.array([f.scale for f in self.free])

    @property
    def mine(self) -> list[NDArray[np.int_]]:
        """Positions of the numbers that each drive depends on."""
        return [
            np.array([k for k, f in enumerate(self.free) if f.drive is None or f.drive == d], dtype=int)
            for d in range(len(self.drives))
        ]

    def clip(self, value: Array) -> Array:
        return np.clip(value, [f.lower for f in self.free], [f.upper for f in self.free])

    def full(self, value: Array) -> Array:
        """(D, n_p) parameters for the free numbers value (K,)."""
        p = self.p.copy()
        index = self.drives[0].compiled.model.p.index
        for f, v in zip(self.free, value, strict=True):
            for name in f.sets:
                p[slice(None) if f.drive is None else f.drive, index(name)] = v
        return p

    def prior(self, value: Array) -> tuple[Array, Array]:
        """(K,) departures from what is known in standard deviations, and their slopes; 0 where nothing is."""
        slope = np.array([0.0 if f.known is None else 1.0 / f.known[1] for f in self.free])
        centre = np.array([0.0 if f.known is None else f.known[0] for f in self.free])
        return slope * (value - centre), slope

    def cost(self, value: Array, x0: Sequence[Array]) -> float:
        """Robust sum of squares of all windows, and of the departures from what is known."""
        rows = zip(self.drives, self.full(value), x0, strict=True)
        residuals = [windows.residual(row, states) for windows, row, states in rows]
        residuals += [more.residual(row) for more, row in zip(self.beside, self.full(value), strict=False)]
        total = sum(float((window_costs(z) * z.shape[1]).sum()) for z in residuals)
        return total + float((self.prior(value)[0] ** 2).sum())

    def nearer(self, value: Array, tried: Sequence[Array], x0: Sequence[Array]) -> list[Array]:
        """Initial states by window: those tried, or those before where a window is met better by them. One whose state is nearly
        open, as by a gap inside it, would keep the numbers of all others from moving.
        """
        best = []
        for windows, row, new, old in zip(self.drives, self.full(value), tried, x0, strict=True):
            worse = ~(window_costs(windows.residual(row, new)) <= window_costs(windows.residual(row, old)))
            best.append(np.where(worse[:, None], old, new))
        return best

    def reduced(self, value: Array, x0: Sequence[Array]) -> list[Reduced]:
        rows = zip(self.drives, self.full(value), x0, self.mine, strict=True)
        return [
            reduce_windows(windows.linearise(row, states, [self.free[k] for k in mine])) for windows, row, states, mine in rows
        ]

    def normal(self, value: Array, parts: Sequence[Reduced]) -> tuple[Array, Array, Array, Array]:
        """Hessian (K, K) and gradient (K,) with what is known; scores (C, K) and Hessians (C, K, K) of the clusters."""
        count = len(self.free)
        own = [(mine, part.hessian, part.gradient) for part, mine in zip(parts, self.mine, strict=True)]
        for more, row, mine in zip(self.beside, self.full(value), self.mine, strict=False):
            reduced = reduce_windows(more.linearise(row, [self.free[k] for k in mine]))
            own.append((mine, reduced.hessian, reduced.gradient))
        scores, hessians = [], []
        for mine, hessian, gradient in own:
            score, whole = np.zeros((len(gradient), count)), np.zeros((len(gradient), count, count))
            score[:, mine], whole[:, mine[:, None], mine] = gradient, hessian
            scores.append(score)
            hessians.append(whole)
        away, slope = self.prior(value)
        joined, stacked = np.concatenate(scores), np.concatenate(hessians)
        return stacked.sum(axis=0) + np.diag(slope**2), joined.sum(axis=0) + slope * away, joined, stacked

    def joint(self, full: Array) -> tuple[Array, NDArray[np.bool_]]:
        """Information (K, K) of what is known of numbers together, at full (D, n_p), and which clusters (C,) are data: what is
        known beforehand is one observation, whose own score says nothing of how it scatters."""
        known, at = np.zeros((len(self.free), len(self.free))), sum(len(windows.rows) for windows in self.drives)
        data = np.ones(at + sum(len(more.times) for more in self.beside), dtype=bool)
        for more, row, mine in zip(self.beside, full, self.mine, strict=False):
            if more.prior:
                root = more.linearise(row, [self.free[k] for k in mine]).by_free.reshape(-1, len(mine)) * self.scale[mine]
                known[np.ix_(mine, mine)] += root.T @ root
                data[at : at + len(more.times)] = False
            at += len(more.times)
        return known, data

    def places(self) -> Array:
        """(C, 2) drive and time (s) of each cluster."""
        rows = [windows.drive.t[windows.rows] for windows in self.drives] + [more.times for more in self.beside]
        drives = [*range(len(self.drives)), *range(len(self.beside))]
        return np.concatenate([np.column_stack([np.full(len(t), d), t]) for d, t in zip(drives, rows, strict=True)])

    def step(self, value: Array, hessian: Array, gradient: Array, damping: float) -> Array:
        """Damped step of the numbers, active bounds held."""
        scale = self.scale
        scaled, lean = hessian * np.outer(scale, scale), gradient * scale
        scaled = scaled + damping * np.diag(np.diag(scaled)) + 1e-12 * max(np.trace(scaled), 1e-300) * np.eye(len(scale))
        held = np.zeros(len(scale), dtype=bool)
        lower, upper = (np.array([getattr(f, end) for f in self.free]) for end in ("lower", "upper"))
        step = np.zeros(len(scale))
        for _ in range(len(scale) + 1):
            open_ = np.flatnonzero(~held)
            if not len(open_):
                break
            inside = np.zeros(len(scale))
            inside[open_] = -np.linalg.solve(scaled[np.ix_(open_, open_)], lean[open_] + scaled[np.ix_(open_, held)] @ step[held])
            inside = np.clip(inside, -LONGEST, LONGEST)
            out = ~held & ((value + scale * inside < lower) | (value + scale * inside > upper))
            if not out.any():
                step[open_] = inside[open_]
                break
            clipped = (np.clip(value + scale * inside, lower, upper) - value) / scale
            step[out] = clipped[out]
            held |= out
        return np.clip(value + scale * step, lower, upper) - value

    def result(self, value: Array, x0: Sequence[Array]) -> WindowFit:
        parts = self.reduced(value, x0)
        hessian, _, scores, hessians = self.normal(value, parts)
        scale = self.scale
        known, full = np.diag((self.prior(value)[1] * scale) ** 2), self.full(value)
        joint, data = self.joint(full)
        centred = (scores[data] - scores[data].mean(axis=0)) * scale
        scaled = hessian * np.outer(scale, scale)
        covariance = cluster_covariance(scaled, centred, known + joint, rcond=1e-12) * np.outer(scale, scale)
        residuals = [windows.residual(row, states) for windows, row, states in zip(self.drives, full, x0, strict=True)]
        costs = np.concatenate([window_costs(z) for z in residuals])
        return WindowFit(
            free=self.free, value=value, std=np.sqrt(np.maximum(np.diag(covariance), 0.0)), covariance=covariance,
            information=hessian - known / np.outer(scale, scale), p=full, x0=tuple(x0), cost=float(costs.mean()), costs=costs,
            scores=scores, hessians=hessians, places=self.places(),
            at_bound=tuple(f.name for f, v in zip(self.free, value, strict=True) if f.at_bound(v)),
        )  # fmt: skip
