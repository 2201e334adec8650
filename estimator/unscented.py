"""The unscented transform and the two steps of the filter as CasADi functions (paper, eqs. (sigma_pts)-(P_k)).

What the paper leaves out is stated here: Q and R are additive, covariances are symmetrised, sigma points are redrawn
between prediction and update, states with finite bounds are held inside them, and a measurement that is invalid or fails
the gate is left out exactly (its row of S becomes a unit row, its column of P_xy zero).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np

from softsoil.symbolic.signals import Layout

PIVOT_FLOOR = 1e-14
"""Least pivot of a Cholesky factor relative to its diagonal: rounding, not information."""


@dataclass(frozen=True)
class UnscentedScaling:
    """alpha in (0, 1], kappa, zeta of eqs. (lambda), (W_0c). With alpha = 1 and kappa = 0 no weight is negative.

    Raises ValueError for alpha outside (0, 1].
    """

    alpha: float = 1.0
    kappa: float = 0.0
    zeta: float = 2.0

    def __post_init__(self) -> None:
        if not 0 < self.alpha <= 1:
            raise ValueError(f"unscented scaling: expected alpha in (0, 1], found {self.alpha}")

    def spread(self, size: int) -> float:
        """L + lambda, eq. (lambda), for a state of `size` L."""
        return self.alpha**2 * (size + self.kappa)

    def weights(self, size: int) -> tuple[np.ndarray, np.ndarray]:
        """(2L + 1,) weights of the mean and of the covariance, eqs. (W_0m)-(Wi), for a state of `size` L."""
        spread = self.spread(size)
        mean = np.full(2 * size + 1, 1 / (2 * spread))
        mean[0] = (spread - size) / spread
        covariance = mean.copy()
        covariance[0] += 1 - self.alpha**2 + self.zeta
        return mean, covariance


def cholesky(matrix: ca.SX) -> ca.SX:
    """Lower factor of a symmetric (n, n) matrix, its pivots floored so that it exists for ever."""
    size = matrix.shape[0]
    factor = ca.SX.zeros(size, size)
    for j in range(size):
        pivot = matrix[j, j] - ca.sumsqr(factor[j, :j]) if j else matrix[j, j]
        factor[j, j] = ca.sqrt(ca.fmax(pivot, PIVOT_FLOOR * ca.fabs(matrix[j, j]) + 1e-300))
        for i in range(j + 1, size):
            done = ca.dot(factor[i, :j], factor[j, :j]) if j else 0
            factor[i, j] = (matrix[i, j] - done) / factor[j, j]
    return factor


def clip(layout: Layout, vector: ca.SX) -> ca.SX:
    """The vector with every entry that has finite bounds held inside them."""
    entries = []
    for i, signal in enumerate(layout):
        entry = vector[i]
        entry = ca.fmax(entry, signal.lower) if np.isfinite(signal.lower) else entry
        entry = ca.fmin(entry, signal.upper) if np.isfinite(signal.upper) else entry
        entries.append(entry)
    return ca.vertcat(*entries)


def sigma_points(
    layout: Layout, scaling: UnscentedScaling, order: Sequence[int] | None = None, inside: bool = True
) -> ca.Function:
    """[x, P] -> [X]: (L, 2L + 1) points of eq. (sigma_pts).

    order (L,): of the states in the factor of P, default their own; inside: whether each point is held inside the bounds.
    """
    size = len(layout)
    rows = list(range(size)) if order is None else list(order)
    x, cov = ca.SX.sym("x", size), ca.SX.sym("P", size, size)
    spread = ca.SX.zeros(size, size)
    spread[rows, :] = np.sqrt(scaling.spread(size)) * cholesky(cov[rows, rows])
    centre = ca.repmat(x, 1, size)
    points = ca.horzcat(x, centre + spread, centre - spread)
    if inside:
        points = ca.horzcat(*[clip(layout, points[:, i]) for i in range(2 * size + 1)])
    return ca.Function("sigma_points", [x, cov], [ca.densify(points)])


def predict_function(
    step: ca.Function,
    layout: Layout,
    scaling: UnscentedScaling,
    at_points: ca.Function | None = None,
    order: Sequence[int] | None = None,
) -> ca.Function:
    """[x, P, u, p, Q] -> [x, P]: the time update, eqs. (x_propigate)-(P_k-), with additive Q (L, L) per step.

    The step runs from points inside the bounds, and what it does is added to the points as they are: a state near a bound
    keeps its variance, and its mean is not pushed away from the bound.
    step: [x, u, p] -> [x_next]; layout: of x; at_points: [X (L, 2L + 1), u, p] -> [X_next], default `step` mapped;
    order: of `sigma_points`.
    """
    size = len(layout)
    x, cov, noise = ca.MX.sym("x", size), ca.MX.sym("P", size, size), ca.MX.sym("Q", size, size)
    u, p = ca.MX.sym("u", step.size1_in(1)), ca.MX.sym("p", step.size1_in(2))
    points = sigma_points(layout, scaling, order, inside=False)(x, cov)
    inside = _clipped(layout, 2 * size + 1)(points)
    moved = points + (at_points or step.map(2 * size + 1))(inside, u, p) - inside
    mean, spread = _moments(layout, scaling)(moved)
    return ca.Function(
        "predict", [x, cov, u, p, noise], [mean, spread + noise], ["x", "P", "u", "p", "Q"], ["x_next", "P_next"]
    )


def _clipped(layout: Layout, count: int) -> ca.Function:
    """[X] -> [X]: (L, count) points held inside the bounds."""
    points = ca.SX.sym("X", len(layout), count)
    return ca.Function("clipped", [points], [ca.densify(ca.horzcat(*[clip(layout, points[:, i]) for i in range(count)]))])


def _moments(layout: Layout, scaling: UnscentedScaling) -> ca.Function:
    """[X] -> [mean, covariance] of (L, 2L + 1) points, the mean inside the bounds; the covariance exactly symmetric."""
    size = len(layout)
    w_mean, w_cov = scaling.weights(size)
    points = ca.SX.sym("X", size, 2 * size + 1)
    mean = points @ w_mean
    away = points - ca.repmat(mean, 1, 2 * size + 1)
    return ca.Function("moments", [points], [ca.densify(clip(layout, mean)), _spread(away, w_cov)])


def _spread(away: ca.SX, weights: np.ndarray) -> ca.SX:
    """Weighted sum of a a' over the columns a of `away` (n, k); each entry computed once, so exactly symmetric."""
    size = away.shape[0]
    weighted = away @ ca.diag(ca.SX(weights))
    spread = ca.SX.zeros(size, size)
    for i in range(size):
        for j in range(i + 1):
            spread[i, j] = spread[j, i] = ca.dot(weighted[i, :], away[j, :])
    return spread


def _weighted(a: ca.SX, b: ca.SX, weights: np.ndarray) -> ca.SX:
    return (a @ ca.diag(ca.SX(weights))) @ b.T


def update_function(
    measure: ca.Function,
    layout: Layout,
    outputs: Layout,
    scaling: UnscentedScaling,
    order: Sequence[int] | None = None,
) -> ca.Function:
    """[x, P, u, p, y, valid, R, gate, held] -> [x, P, innovation, S, nis, used]: eqs. (Y_k)-(P_k) with additive R.

    measure: [x, u, p] -> [y]; valid (n_y,): 1 where the measurement counts, 0 where not; gate: largest |innovation| in
    standard deviations (inf for none); held (L,): 1 for a state that is not corrected (a Schmidt update: its correlations are);
    order: of `sigma_points`; outputs whose unit is rad and whose name is psi are compared modulo 2 pi;
    innovation (n_y,), S (n_y, n_y), nis: normalised innovation squared over the used measurements; used (n_y,): 1 or 0.
    The points are held inside the bounds only where the measurement depends on a bounded state: P then loses nothing.
    """
    size, n_y = len(layout), len(outputs)
    points_of = sigma_points(layout, scaling, order, _sees_bounded(measure, layout))
    x, cov = ca.MX.sym("x", size), ca.MX.sym("P", size, size)
    u, p = ca.MX.sym("u", measure.size1_in(1)), ca.MX.sym("p", measure.size1_in(2))
    y, valid, gate = ca.MX.sym("y", n_y), ca.MX.sym("valid", n_y), ca.MX.sym("gate")
    noise = ca.MX.sym("R", n_y, n_y)
    points = points_of(x, cov)
    held = ca.MX.sym("held", size)
    seen = measure.map(2 * size + 1)(points, u, p)
    results = _correction(layout, outputs, scaling)(x, points, seen, y, valid, noise, gate, held)
    return ca.Function(
        "update",
        [x, cov, u, p, y, valid, noise, gate, held],
        list(results),
        ["x", "P", "u", "p", "y", "valid", "R", "gate", "held"],
        ["x_next", "P_next", "innovation", "S", "nis", "used"],
    )


def _sees_bounded(measure: ca.Function, layout: Layout) -> bool:
    arguments = measure.sx_in()
    bounded = [arguments[0][i] for i, s in enumerate(layout) if np.isfinite(s.lower) or np.isfinite(s.upper)]
    return bool(bounded) and bool(ca.depends_on(measure(*arguments), ca.vertcat(*bounded)))


def _correction(layout: Layout, outputs: Layout, scaling: UnscentedScaling) -> ca.Function:
    size, n_y = len(layout), len(outputs)
    w_mean, w_cov = scaling.weights(size)
    x, points, held = ca.SX.sym("x", size), ca.SX.sym("X", size, 2 * size + 1), ca.SX.sym("held", size)
    seen, y, valid = ca.SX.sym("Y", n_y, 2 * size + 1), ca.SX.sym("y", n_y), ca.SX.sym("valid", n_y)
    noise, gate = ca.SX.sym("R", n_y, n_y), ca.SX.sym("gate")
    y_mean = seen @ w_mean
    away_y = seen - ca.repmat(y_mean, 1, 2 * size + 1)
    away_x = points - ca.repmat(points @ w_mean, 1, 2 * size + 1)
    full = _spread(away_y, w_cov) + noise
    innovation = ca.vertcat(*[_difference(s, y[i] - y_mean[i]) for i, s in enumerate(outputs)])
    inside = ca.vertcat(*[innovation[i] ** 2 <= gate**2 * full[i, i] for i in range(n_y)])
    used = valid * inside
    masked = used @ used.T * full + ca.diag(1 - used)
    factor = cholesky((masked + masked.T) / 2)
    left_out = innovation * used
    scaled = ca.solve(factor, left_out)
    cross = _weighted(away_x, away_y, w_cov) * ca.repmat(used.T, size, 1)
    gain_root = ca.solve(factor, cross.T).T  # P_xy L^-T, so that K S K^T = gain_root gain_root^T
    x_next = clip(layout, x + (1 - held) * (gain_root @ scaled))
    # P - K P_xy' - P_xy K' + K S K' with the rows of K that belong to held states zero.
    p_next = _spread(away_x, w_cov) - gain_root @ gain_root.T * (1 - held @ held.T)
    return ca.Function(
        "correction",
        [x, points, seen, y, valid, noise, gate, held],
        [x_next, ca.densify((p_next + p_next.T) / 2), innovation, ca.densify(full), ca.sumsqr(scaled), used],
    )


def _difference(signal, value: ca.SX) -> ca.SX:
    """An angle's innovation on (-pi, pi], any other as it is."""
    if signal.name == "psi" and signal.unit == "rad":
        return value - 2 * np.pi * ca.floor(value / (2 * np.pi) + 0.5)
    return value
