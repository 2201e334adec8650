"""Values and derivatives of an Ocp along a trajectory: generated C for all stages at once, chained through the step here.

The model's rates with their Jacobian are evaluated at each of the four Runge-Kutta points of all intervals (vector lanes);
the sensitivities run through them. The Hessian of the Lagrangian's dynamic part is taken at the second point, the middle
of the interval, by differences of the exact gradient: second-order accurate in the step, which leaves SQP's solution
exact and its convergence fast.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from softsoil.codegen.compiled import at_points
from softsoil.control.ocp import CIRCLES, OBSTACLE, REFERENCE, Ocp
from softsoil.control.ocp_chain import absorb, contract, perturb, reserve_rows, spread

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
        rates, self._rows, self._columns = _rates(ocp)
        use, self._use_rows, self._use_columns = _use(ocp)
        self._curvature = _curvature(ocp)
        self.dynamics, self.force_use = Points(rates, n), Points(use, n)
        self.gradient = Points(self._curvature.gradient, n * max(len(self._curvature.directions), 1))
        self.rest = Points(self._curvature.rest, n)
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
        """General rows per stage: clearances of each obstacle, two force reserves."""
        return CIRCLES * self.ocp.settings.obstacles + 2

    def set_parameters(self, s: Array, r: Array, ref: Array, obstacles: Array) -> None:
        """s (n_s,), r (N, n_r), ref (N + 1, 4), obstacles (N + 1, n_obs, 3)."""
        nv, h, w = self.nv, self.ocp.settings.dt, self.ocp.settings.weights
        for points in (self.dynamics, self.force_use, self.gradient, self.rest):
            points.shared[: len(s)] = s
            points.into.reshape(self.n, -1, points.into.shape[1])[:, :, nv : nv + r.shape[1]] = r[:, None]
        self.stage.into[:, nv : nv + 4] = ref
        self.stage.into[:-1, nv + 4] = h
        self.stage.into[-1, nv + 4] = h * w.terminal
        self.stage.into[:, nv + 5 :] = obstacles.reshape(self.n + 1, -1)

    def linearise(self, z: Array, w: Array) -> None:
        """Fill everything at z, w."""
        h, into, out = self.ocp.settings.dt, self.dynamics.into, self.dynamics.out
        for points in (self.dynamics, self.force_use):
            points.into[:, : self.nz], points.into[:, self.nz : self.nv] = z[:-1], w
        self.force_use.run()
        reserve_rows(
            self.force_use.out, self._use_rows, self._use_columns, self.ocp.settings.reserve, self.use, self.general,
            self.value,
        )  # fmt: skip
        for number in range(4):
            self.dynamics.run()
            absorb(
                number, h, z, into, out, self._rows, self._columns, self._s, self._sum, self._sum_t, self._middle_s,
                self._middle_z, self._middle_j, self.end, self.AB,
            )  # fmt: skip
        self.evaluate_terms(z, w)

    def evaluate_terms(self, z: Array, w: Array) -> None:
        """Cost and clearances with their derivatives at z, w; the dynamics and the force reserve are left as they stand."""
        into = self.stage.into
        into[:, : self.nz] = z
        into[:-1, self.nz : self.nv] = w
        self.stage.run()
        spread(
            self.stage.out, self.nv, self._cost_cells, self._gap_cells, CIRCLES * self.ocp.settings.obstacles, self.cost,
            self.g, self.cost_hessian, self.general, self.value,
        )  # fmt: skip

    def shoot(self, z: Array, w: Array) -> None:
        """Values only: end (N, n_z), cost, value."""
        self.linearise(z, w)

    def lagrangian_hessian(self, z: Array, w: Array, pi: Array, hessian: Array) -> None:
        """hessian (N + 1, n_v, n_v): cost plus the dynamics' curvature under the multipliers pi (N + 1, n_z)."""
        c = self._curvature
        perturb(self.gradient.into, self.rest.into, self._middle_z, w, pi, c.directions, DIFFERENCE, len(self.ocp.r))
        self.gradient.run()
        self.rest.run()
        contract(
            self.gradient.out, self.rest.out, self._middle_j, self._rows, self._columns, c.costly, c.wanted, c.directions,
            c.cells, self._middle_s, pi, self.ocp.settings.dt, DIFFERENCE, self.cost_hessian, hessian,
        )  # fmt: skip


def _memory(array: Any) -> memoryview:
    """The array's own memory."""
    return memoryview(array.reshape(-1))


def _derivatives(rows: ca.SX, v: ca.SX) -> tuple[list[Any], Whole, Whole]:
    """Nonzeros of d rows/dv, row by row in reverse mode (few rows are costly, and they share their sweep), and their places."""
    nonzeros, places = [], []
    for i in range(rows.numel()):
        row = ca.jacobian(rows[i], v)
        columns = row.sparsity().get_triplet()[1]
        nonzeros += [row.nz[j] for j in range(row.nnz())]
        places += [(i, column) for column in columns]
    table = np.array(places, dtype=np.int64).reshape(-1, 2)
    return nonzeros, table[:, 0].copy(), table[:, 1].copy()


def _rates(ocp: Ocp) -> tuple[ca.Function, Whole, Whole]:
    """[(z, w, r), s] -> [(rates, nonzeros of their Jacobian)], and its rows and columns."""
    z, w, r, s = ocp.symbols()
    v = ca.vertcat(z, w)
    rates = ocp.dynamics()(z, w, r, s)[0]
    nonzeros, rows, columns = _derivatives(rates, v)
    return ca.Function("ocp_rates", [ca.vertcat(v, r), s], [ca.densify(ca.vertcat(rates, *nonzeros))]), rows, columns


def _use(ocp: Ocp) -> tuple[ca.Function, Whole, Whole]:
    """The same for the use of the soil's lateral force, front and rear."""
    z, w, r, s = ocp.symbols()
    v = ca.vertcat(z, w)
    use = ocp.dynamics()(z, w, r, s)[1]
    nonzeros, rows, columns = _derivatives(use, v)
    return ca.Function("ocp_use", [ca.vertcat(v, r), s], [ca.densify(ca.vertcat(use, *nonzeros))]), rows, columns


@dataclass(frozen=True)
class Curvature:
    """How the Hessian of pi' rates is found.

    gradient: [(z, w, r, pi), s] -> gradient of the costly rows' share in the `wanted` variables, to be differenced along
    `directions` (the states among them; the inputs' own 2 x 2 block is small beside their weights and left out);
    rest: the same point -> the cheap rows' exact Hessian, lower `cells`.
    """

    gradient: ca.Function
    costly: Whole
    wanted: Whole
    directions: Whole
    rest: ca.Function
    cells: Whole


COSTLY = 300
"""Operations from which on a row of the rates counts as costly: those with soil forces in them."""


def _curvature(ocp: Ocp) -> Curvature:
    z, w, r, s = ocp.symbols()
    v, pi = ca.vertcat(z, w), ca.SX.sym("pi", len(ocp.z))
    rates = ocp.dynamics()(z, w, r, s)[0]
    sizes = [ca.Function("row", [v, r, s], [rates[i]]).n_instructions() for i in range(rates.numel())]
    costly = np.array([i for i, size in enumerate(sizes) if size > COSTLY], dtype=np.int64)
    cheap = [i for i in range(rates.numel()) if i not in costly]
    share: Any = sum((pi[int(i)] * rates[int(i)] for i in costly), ca.SX(0))
    gradient = ca.gradient(share, v)
    wanted = np.array([i for i in range(v.numel()) if ca.which_depends(gradient[i], v, 1, True)[0]], dtype=np.int64)
    directions = np.array([i for i in wanted if i < len(ocp.z)], dtype=np.int64)
    point = ca.vertcat(v, r, pi)
    slopes = ca.vertcat(*[gradient[int(i)] for i in wanted]) if len(wanted) else ca.SX(1, 1)
    rest = ca.tril(ca.hessian(sum((pi[i] * rates[i] for i in cheap), ca.SX(0)), v)[0])
    cells = np.array(rest.sparsity().get_triplet(), dtype=np.int64).reshape(2, -1)
    entries = ca.vertcat(*[rest.nz[i] for i in range(rest.nnz())]) if rest.nnz() else ca.SX(1, 1)
    return Curvature(
        ca.Function("ocp_gradient", [point, s], [ca.densify(slopes)]), costly, wanted, directions,
        ca.Function("ocp_rest", [point, s], [ca.densify(entries)]), cells,
    )  # fmt: skip


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
