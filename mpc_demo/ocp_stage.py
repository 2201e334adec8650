"""Values and derivatives of an Ocp along a trajectory: generated C for all stages at once, chained through the step here.

The model's rates with their Jacobian are evaluated at each of the four Runge-Kutta points of all intervals (vector lanes);
the sensitivities run through them. The Hessian of the Lagrangian's dynamic part is taken at the second point, the middle
of the interval, by differences of the exact gradient: second-order accurate in the step, which leaves SQP's solution
exact and its convergence fast.
"""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np
from numba import njit
from numpy.typing import NDArray

from estimator.compiled import at_points
from mpc_demo.ocp import OBSTACLE, REFERENCE, Ocp

Array = NDArray[np.float64]
Whole = NDArray[np.int64]
DIFFERENCE = 1e-5
"""Step of the gradient's differences, units of each variable (all of order 1)."""


class Points:
    """A CasADi function [point, shared] -> [values] at many points: rows of `into` (count, n) give rows of `out` (count, m)."""

    def __init__(self, function: ca.Function, count: int) -> None:
        self.function, self.sources = at_points(function, count)
        self.into = np.zeros((count, function.size1_in(0)))
        self.shared = np.zeros(max(function.size1_in(1), 1))
        self.out = np.zeros((count, function.size1_out(0)))
        buffer: tuple[Any, Any] = self.function.buffer()
        self._buffer, self.run = buffer
        for place, array in enumerate((self.into, self.shared)):
            self._buffer.set_arg(place, _memory(array))
        self._buffer.set_res(0, _memory(self.out))


class Stages:
    """An Ocp along a trajectory z (N + 1, n_z), w (N, n_w).

    `linearise` fills values, AB (N, n_z, n_v), cost gradients g (N + 1, n_v), cost Hessians (N + 1, n_v, n_v), the
    general rows (N + 1, n_g, n_v) and their values; `lagrangian_hessian` adds the dynamics' part.
    """

    def __init__(self, ocp: Ocp) -> None:
        self.ocp, n = ocp, ocp.settings.steps
        self.nz, self.nw = len(ocp.z), len(ocp.w)
        self.nv, self.n = self.nz + self.nw, n
        self._rates, self._rows, self._columns, self._directions = _rates(ocp)
        self.dynamics = Points(self._rates, n)
        self.gradient = Points(_gradient(ocp, self._directions), n * len(self._directions))
        stage, self._cost_cells, self._gap_cells = _stage(ocp)
        self.stage = Points(stage, n + 1)
        nv, ng = self.nv, self.n_general
        self.end = np.zeros((n, self.nz))
        self.AB = np.zeros((n, self.nz, nv))
        self.g, self.cost_hessian = np.zeros((n + 1, nv)), np.zeros((n + 1, nv, nv))
        self.general, self.value = np.zeros((n + 1, ng, nv)), np.zeros((n + 1, ng))
        self.use, self.cost = np.zeros((n, 2)), np.zeros(n + 1)
        self._sum, self._sum_t = np.zeros((n, self.nz)), np.zeros((n, self.nz, nv))
        self._s, self._middle_s = np.zeros((n, self.nz, nv)), np.zeros((n, self.nz, nv))
        self._middle_z, self._middle_j = np.zeros((n, self.nz)), np.zeros((n, len(self._rows)))

    @property
    def n_general(self) -> int:
        """General rows per stage: two clearances per obstacle, two force reserves."""
        return 2 * self.ocp.settings.obstacles + 2

    def set_parameters(self, s: Array, r: Array, ref: Array, obstacles: Array) -> None:
        """s (n_s,), r (N, n_r), ref (N + 1, 4), obstacles (N + 1, n_obs, 3)."""
        nv, h, w = self.nv, self.ocp.settings.dt, self.ocp.settings.weights
        self.dynamics.shared[: len(s)] = s
        self.gradient.shared[: len(s)] = s
        self.dynamics.into[:, nv:] = r
        directions = len(self._directions)
        self.gradient.into.reshape(self.n, directions, -1)[:, :, nv : nv + r.shape[1]] = r[:, None]
        self.stage.into[:, nv : nv + 4] = ref
        self.stage.into[:-1, nv + 4] = h
        self.stage.into[-1, nv + 4] = h * w.terminal
        self.stage.into[:, nv + 5 :] = obstacles.reshape(self.n + 1, -1)

    def linearise(self, z: Array, w: Array) -> None:
        """Fill everything at z, w."""
        h, into, out = self.ocp.settings.dt, self.dynamics.into, self.dynamics.out
        into[:, : self.nz], into[:, self.nz : self.nv] = z[:-1], w
        for number in range(4):
            self.dynamics.run()
            _absorb(
                number, h, z, into, out, self._rows, self._columns, self._s, self._sum, self._sum_t, self._middle_s,
                self._middle_z, self._middle_j, self.end, self.AB, self.use, self.general, self.value,
                self.ocp.settings.reserve,
            )  # fmt: skip
        self._stage_terms(z, w)

    def _stage_terms(self, z: Array, w: Array) -> None:
        into = self.stage.into
        into[:, : self.nz] = z
        into[:-1, self.nz : self.nv] = w
        self.stage.run()
        _spread(
            self.stage.out, self.nv, self._cost_cells, self._gap_cells, 2 * self.ocp.settings.obstacles, self.cost,
            self.g, self.cost_hessian, self.general, self.value,
        )  # fmt: skip

    def shoot(self, z: Array, w: Array) -> None:
        """Values only: end (N, n_z), cost, value."""
        self.linearise(z, w)

    def lagrangian_hessian(self, z: Array, w: Array, pi: Array, hessian: Array) -> None:
        """hessian (N + 1, n_v, n_v): cost plus the dynamics' curvature under the multipliers pi (N + 1, n_z)."""
        _perturb(self.gradient.into, self._middle_z, w, pi, self._directions, DIFFERENCE, len(self.ocp.r))
        self.gradient.run()
        _contract(
            self.gradient.out, self._middle_j, self._rows, self._columns, self._directions, self._middle_s, pi,
            self.ocp.settings.dt, DIFFERENCE, self.cost_hessian, hessian,
        )  # fmt: skip


def _memory(array: Any) -> memoryview:
    """The array's own memory."""
    return memoryview(array.reshape(-1))


def _rates(ocp: Ocp) -> tuple[ca.Function, Whole, Whole, Whole]:
    """[(z, w, r), s] -> [(rates, force use, nonzeros of the Jacobian)], its rows and columns, the curved variables."""
    z, w, r, s = ocp.symbols()
    v = ca.vertcat(z, w)
    rates, use = ocp.dynamics()(z, w, r, s)
    both = ca.vertcat(rates, use)
    jacobian = ca.jacobian(both, v)
    rows, columns = (np.array(part, dtype=np.int64) for part in jacobian.sparsity().get_triplet())
    nonzeros = ca.vertcat(*[jacobian.nz[i] for i in range(jacobian.nnz())])
    weights = ca.SX.sym("weights", rates.numel())
    pattern = ca.hessian(ca.dot(weights, rates), v)[0].sparsity()
    curved = np.unique(np.array(pattern.get_triplet()[1], dtype=np.int64))
    function = ca.Function("ocp_rates", [ca.vertcat(v, r), s], [ca.densify(ca.vertcat(both, nonzeros))])
    return function, rows, columns, curved


def _gradient(ocp: Ocp, directions: Whole) -> ca.Function:
    """[(z, w, r, pi), s] -> [gradient of pi' rates with respect to the curved variables]."""
    z, w, r, s = ocp.symbols()
    pi = ca.SX.sym("pi", len(ocp.z))
    v = ca.vertcat(z, w)
    gradient = ca.gradient(ca.dot(pi, ocp.dynamics()(z, w, r, s)[0]), v)
    wanted = ca.vertcat(*[gradient[int(i)] for i in directions])
    return ca.Function("ocp_gradient", [ca.vertcat(v, r, pi), s], [ca.densify(wanted)])


def _stage(ocp: Ocp) -> tuple[ca.Function, Whole, Whole]:
    """[(z, w, ref, scale, obstacles), nothing] -> [(l, gradient, Hessian cells, gaps, Jacobian cells of the gaps)]."""
    z, w, _, _ = ocp.symbols()
    ref, scale = ca.SX.sym("ref", len(REFERENCE)), ca.SX.sym("scale")
    places = ca.SX.sym("obstacles", len(OBSTACLE), ocp.settings.obstacles)
    v = ca.vertcat(z, w)
    cost = scale * ocp.cost()(z, w, ref)
    hessian, gradient = ca.hessian(cost, v)
    hessian = ca.tril(hessian)
    cells = np.array(hessian.sparsity().get_triplet(), dtype=np.int64).reshape(2, -1)
    parts = [cost, ca.densify(gradient), *[hessian.nz[i] for i in range(hessian.nnz())]]
    clear = ocp.clearance()
    gaps = ca.vertcat(*[clear(z, places[:, i]) for i in range(ocp.settings.obstacles)])
    gap_cells = np.zeros((2, 0), dtype=np.int64)
    if ocp.settings.obstacles:
        jacobian = ca.jacobian(gaps, v)
        gap_cells = np.array(jacobian.sparsity().get_triplet(), dtype=np.int64).reshape(2, -1)
        parts += [gaps, *[jacobian.nz[i] for i in range(jacobian.nnz())]]
    point = ca.vertcat(v, ref, scale, ca.vec(places))
    nothing = ca.SX.sym("nothing", 1)
    return ca.Function("ocp_stage", [point, nothing], [ca.densify(ca.vertcat(*parts))]), cells, gap_cells


@njit(cache=True)
def _absorb(
    number, h, z, into, out, rows, columns, s, total, total_t, middle_s, middle_z, middle_j, end, AB, use, general, value,
    reserve,
):  # fmt: skip
    """Take in Runge-Kutta point `number` (0 to 3) of all intervals and place the next one in `into`."""
    count, nz, nv = AB.shape
    t = np.empty((nz, nv))
    weight = h / 6.0 if number in (0, 3) else h / 3.0
    ahead = h if number == 2 else 0.5 * h
    first = general.shape[1] - 2
    for k in range(count):
        t[:] = 0.0
        for i in range(len(rows)):
            row, column, entry = rows[i], columns[i], out[k, nz + 2 + i]
            if row >= nz:
                continue
            if number == 0 or column >= nz:
                t[row, column] += entry
            if number > 0 and column < nz:
                for j in range(nv):
                    t[row, j] += entry * s[k, column, j]
        if number == 0:
            for a in range(2):
                size = np.sqrt(out[k, nz + a] ** 2 + 1e-4)
                use[k, a] = out[k, nz + a]
                value[k, first + a] = 1.0 - reserve - size
                general[k, first + a, :] = 0.0
            for i in range(len(rows)):
                a = rows[i] - nz
                if a >= 0:
                    sign = out[k, nz + a] / np.sqrt(out[k, nz + a] ** 2 + 1e-4)
                    general[k, first + a, columns[i]] = -sign * out[k, nz + 2 + i]
        for i in range(nz):
            total[k, i] = weight * out[k, i] + (0.0 if number == 0 else total[k, i])
            for j in range(nv):
                total_t[k, i, j] = weight * t[i, j] + (0.0 if number == 0 else total_t[k, i, j])
                s[k, i, j] = ahead * t[i, j] + (1.0 if i == j else 0.0)
        if number < 3:
            for i in range(nz):
                into[k, i] = z[k, i] + ahead * out[k, i]
        else:
            for i in range(nz):
                end[k, i] = z[k, i] + total[k, i]
                for j in range(nv):
                    AB[k, i, j] = total_t[k, i, j] + (1.0 if i == j else 0.0)
        if number == 0:
            for i in range(nz):
                middle_z[k, i] = into[k, i]
                for j in range(nv):
                    middle_s[k, i, j] = s[k, i, j]
        if number == 1:
            for i in range(len(rows)):
                middle_j[k, i] = out[k, nz + 2 + i]


@njit(cache=True)
def _spread(out, nv, cost_cells, gap_cells, gaps, cost, g, hessian, general, value):
    """Stage terms from their packed form."""
    for k in range(out.shape[0]):
        cost[k] = out[k, 0]
        for j in range(nv):
            g[k, j] = out[k, 1 + j]
        at = 1 + nv
        for i in range(cost_cells.shape[1]):
            a, b = cost_cells[0, i], cost_cells[1, i]
            hessian[k, a, b] = out[k, at + i]
            hessian[k, b, a] = out[k, at + i]
        at += cost_cells.shape[1]
        for i in range(gaps):
            value[k, i] = out[k, at + i]
        at += gaps
        for i in range(gap_cells.shape[1]):
            general[k, gap_cells[0, i], gap_cells[1, i]] = out[k, at + i]


@njit(cache=True)
def _perturb(into, z, w, pi, directions, eps, n_r):
    """Points of the gradient: each curved variable of each interval moved by eps; pi of the interval's end."""
    nz, nw = z.shape[1], w.shape[1]
    count = len(directions)
    for k in range(z.shape[0]):
        for d in range(count):
            row = k * count + d
            for i in range(nz):
                into[row, i] = z[k, i]
                into[row, nz + nw + n_r + i] = pi[k + 1, i]
            for i in range(nw):
                into[row, nz + i] = w[k, i]
            into[row, directions[d]] += eps


@njit(cache=True)
def _contract(out, middle_j, rows, columns, directions, s, pi, h, eps, cost, hessian):
    """Hessian = cost + h T' (differences) T, T the variables at the middle of the interval over those at its start."""
    count, nz, nv = s.shape
    nd = len(directions)
    curve, half, t = np.empty((nd, nd)), np.empty((nd, nv)), np.zeros((nd, nv))
    base = np.empty(nv)
    for k in range(count):
        base[:] = 0.0
        for i in range(len(rows)):
            if rows[i] < nz:
                base[columns[i]] += pi[k + 1, rows[i]] * middle_j[k, i]
        for a in range(nd):
            for b in range(nd):
                curve[a, b] = h * (out[k * nd + a, b] - base[directions[b]]) / eps
            if directions[a] < nz:
                for j in range(nv):
                    t[a, j] = s[k, directions[a], j]
            else:
                t[a, directions[a]] = 1.0
        for a in range(nd):
            for j in range(nv):
                value = 0.0
                for b in range(nd):
                    value += 0.5 * (curve[a, b] + curve[b, a]) * t[b, j]
                half[a, j] = value
        for i in range(nv):
            for j in range(i + 1):
                value = cost[k, i, j]
                for a in range(nd):
                    value += t[a, i] * half[a, j]
                hessian[k, i, j] = value
                hessian[k, j, i] = value
    hessian[count] = cost[count]
