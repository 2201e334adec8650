"""NMPC in real time: sequential quadratic programming with exact derivatives on a structure-exploiting interior point.

Two modes. `rti`: one iteration per step, repeated only where it changed the plan much; `prepare()` may run before the
state is known, `make_step(z0)` does the rest. `converged`: iterations until the step is small, with a line search on the
exact L1 merit function. The Hessian is the Lagrangian's; where a subproblem's reduced Hessian is not positive, each
stage's eigenvalues are clipped and it is solved again.
"""

from __future__ import annotations

import time

import numpy as np
from numpy.typing import ArrayLike, NDArray

from softsoil.control.nmpc_clearance import NOWHERE, judged, placed, planned_gaps
from softsoil.control.nmpc_guess import move_on, straight_on
from softsoil.control.nmpc_status import Stats, Status
from softsoil.control.ocp import CIRCLES, Ocp
from softsoil.control.ocp_riccati import BROKEN, NOT_CONVEX, margins, penalised, solve_qp
from softsoil.control.ocp_stage import Stages

Array = NDArray[np.float64]
RESTLESS, RTI_MOST = 0.3, 3
"""A real-time iteration that moves any variable by more than this is repeated, so many iterations at most."""
OPEN_DEFECT = 0.05
"""A plan that has run out of iterations with a larger gap in its dynamics (any state's unit) is not followed."""
LEAST_CURVATURE = 1e-4
"""Eigenvalues of a clipped stage Hessian are at least this."""


class Nmpc:
    """Solver of an Ocp, warm-started from its last solution.

    mode: "rti" or "converged"; most: greatest number of iterations of the latter; tolerance: largest change of any
    variable at which it stops. Raises ValueError for another mode.

    Example:
        >>> import softsoil
        >>> vehicle = softsoil.load_vehicle("paper")
        >>> ocp = softsoil.Ocp(softsoil.bicycle(vehicle, softsoil.load_soil("clay")), vehicle)
        >>> solver = softsoil.Nmpc(ocp)
        >>> solver.w.shape == (ocp.settings.steps, 2)
        True
    """

    def __init__(self, ocp: Ocp, mode: str = "rti", most: int = 15, tolerance: float = 3e-3) -> None:
        if mode not in ("rti", "converged"):
            raise ValueError(f"nmpc: expected mode rti or converged, found {mode!r}")
        self.ocp, self.mode, self.most, self.tolerance = ocp, mode, most, tolerance
        self.stages = Stages(ocp)
        n, nz, nv = self.stages.n, self.stages.nz, self.stages.nv
        self.z, self.w = np.tile(ocp.z.nominal, (n + 1, 1)), np.zeros((n, nv - nz))
        self._box = np.array([ocp.z.index(name) for name in ocp.state_box] + [nz, nz + 1], dtype=np.int64)
        limits = [*ocp.state_box.values(), *((s.lower, s.upper) for s in ocp.w)]
        self._limits = np.array(limits)
        nb, rows = len(self._box), 2 * len(self._box) + self.stages.n_general
        self._soft = np.ones(rows, dtype=np.bool_)
        self._soft[2 * (nb - 2) : 2 * nb] = False
        self._on = np.ones((n + 1, rows), dtype=np.bool_)
        self._on[0, : 2 * (nb - 2)] = self._on[0, 2 * nb :] = False
        self._on[n, 2 * (nb - 2) : 2 * nb] = self._on[n, -2:] = False
        if not ocp.bears:
            self._on[:, -2:] = False
        self._no_obstacles()
        self._c, self._v = np.zeros((n + 1, rows)), np.zeros((n + 1, nv))
        self._hessian, self.pi = np.zeros((n + 1, nv, nv)), np.zeros((n + 1, nz))
        self._lam, self._t = np.zeros((n + 1, rows)), np.zeros((n + 1, rows))
        self._s, self._mu = np.zeros((n + 1, rows)), np.zeros((n + 1, rows))
        w, h = ocp.settings.weights, ocp.settings.dt
        self._rho = np.array([w.slack, w.slack_squared]) * h
        self._prepared, self._spent, self._warm = False, 0.0, False
        self.stats = Stats(Status.OUT_OF_ITERATIONS)
        self.set_parameters(ocp.s.nominal, np.zeros((n, len(ocp.r))), np.tile([0.0, 0.0, 0.0, 5.0], (n + 1, 1)))

    def set_parameters(self, s: ArrayLike, r: ArrayLike, ref: ArrayLike, obstacles: ArrayLike | None = None) -> None:
        """s (n_s,): model parameters, slip, slip_gain; r (N, n_r): histories; ref (N + 1, 4): x, y, psi, u of the path;
        obstacles (N + 1, n, 3): x, y, radius over the horizon, or (n, 3) where they stand; none beyond those given.

        Raises ValueError for other shapes or more obstacles than the Ocp watches.
        """
        n, most = self.stages.n, self.ocp.settings.obstacles
        places = placed(self.ocp, obstacles)
        s, r, ref = (np.asarray(value, dtype=float) for value in (s, r, ref))
        for name, value, shape in (
            ("s", s, (len(self.ocp.s),)), ("r", r, (n, len(self.ocp.r))), ("ref", ref, (n + 1, 4)),
        ):  # fmt: skip
            if value.shape != shape:
                raise ValueError(f"{name}: expected shape {shape}, found {value.shape}")
        self.stages.set_parameters(s, r, ref, places)
        self._obstacles = places
        nb = len(self._box)
        far = places[:, :, 0] >= NOWHERE
        self._on[1:, 2 * nb : 2 * nb + CIRCLES * most] = np.repeat(~far[1:], CIRCLES, axis=1)
        self._prepared = False

    def _no_obstacles(self) -> None:
        nb = len(self._box)
        self._on[:, 2 * nb : 2 * nb + CIRCLES * self.ocp.settings.obstacles] = False

    def set_initial_guess(self, z: ArrayLike, w: ArrayLike) -> None:
        """z (N + 1, n_z), w (N, n_w): where the next solve starts; multipliers start again. ValueError for other shapes."""
        z, w = np.asarray(z, dtype=float), np.asarray(w, dtype=float)
        if z.shape != self.z.shape or w.shape != self.w.shape:
            raise ValueError(f"guess: expected {self.z.shape} and {self.w.shape}, found {z.shape} and {w.shape}")
        self.z[:], self.w[:] = z, w
        self.pi[:], self._lam[:] = 0.0, 0.0
        self._prepared = self._warm = False

    def shift(self, seconds: float) -> None:
        """Move the last solution on by `seconds`, so that it starts the next solve."""
        share = seconds / self.ocp.settings.dt
        ahead = self.z[-1] + share * (self.z[-1] - self.z[-2])
        for array in (self.z, self.w, self.pi, self._lam):
            move_on(array, share)
        self.z[-1] = ahead
        self._prepared = False

    def prepare(self) -> None:
        """All that can be done before the state is known: linearisation and Hessian at the present guess."""
        began = time.perf_counter()
        self.stages.linearise(self.z, self.w)
        self.stages.lagrangian_hessian(self.z, self.w, self.pi, self._hessian)
        self._prepared, self._spent = True, time.perf_counter() - began

    def make_step(self, z0: ArrayLike) -> Array:
        """(n_w,) first input of the plan from the state z0 (n_z,); see `stats`, and `z`, `w` for the plan itself."""
        z0 = np.asarray(z0, dtype=float)
        if z0.shape != self.z[0].shape:
            raise ValueError(f"z0: expected shape {self.z[0].shape}, found {z0.shape}")
        if not np.isfinite(z0).all():
            self.stats = Stats(Status.BAD_STATE)
            return self.w[0].copy()
        began = time.perf_counter()
        if not self._prepared:
            self.prepare()
            began = time.perf_counter()
        before = self.w[0].copy()
        status, iterations, inner, step = self._iterate(z0)
        gap, touch = np.inf, -1
        objective, defect = float(self._objective()), self._defect()
        if status.usable:
            status, gap, touch = judged(status, planned_gaps(self.ocp, self.z, self._obstacles))
        elif status is not Status.NOT_CLOSED:  # which the next solve goes on from
            self._start_again(z0)
        feedback = time.perf_counter() - began
        self._prepared = False
        self.stats = Stats(
            status, iterations, inner, self._spent + feedback, feedback, objective, defect, step,
            gap, touch,
        )  # fmt: skip
        return self.w[0].copy() if status.usable else before

    def _start_again(self, z0: Array) -> None:
        """Where a solve has failed, the next one starts from straight on at the present speed, not from where this one broke."""
        self.z[:] = straight_on(self.ocp, z0)
        self.w[:], self.pi[:], self._lam[:], self._warm = 0.0, 0.0, 0.0, False

    def _iterate(self, z0: Array) -> tuple[Status, int, int, float]:
        total, step = 0, np.inf
        rti = self.mode == "rti"
        for iteration in range(1, RTI_MOST + 1 if rti else self.most + 1):
            if iteration > 1:
                if rti:
                    self.stages.linearise(self.z, self.w)
                self.stages.lagrangian_hessian(self.z, self.w, self.pi, self._hessian)
            outcome, inner = self._subproblem(z0)
            total += inner
            if outcome in (NOT_CONVEX, BROKEN):
                return (Status.NOT_CONVEX if outcome == NOT_CONVEX else Status.NOT_FINITE), iteration, total, step
            step = float(np.abs(self._v).max())
            if rti:
                self.z += self._v[:, : self.stages.nz]
                self.w += self._v[:-1, self.stages.nz :]
                if step < RESTLESS or iteration == RTI_MOST:
                    return Status.ITERATED, iteration, total, step
                continue
            if step < self.tolerance:
                self._arrive()
                return Status.CONVERGED, iteration, total, step
            self._search(z0)
        closed = self._defect() < OPEN_DEFECT
        return (Status.OUT_OF_ITERATIONS if closed else Status.NOT_CLOSED), self.most, total, step

    def _subproblem(self, z0: Array) -> tuple[int, int]:
        st = self.stages
        margins(self.z, self.w, self._box, self._limits, st.value, self._c)
        defect, away = st.end - self.z[1:], z0 - self.z[0]
        start = 1e-3 if self._warm else 1e-1
        outcome, used = BROKEN, 0
        finite = all(np.isfinite(part).all() for part in (self._hessian, st.AB, st.g, self._c))
        for clipped in (False, True) if finite else ():
            self._v[:] = 0.0
            hessian = clip(self._hessian) if clipped else self._hessian
            outcome, more = solve_qp(
                hessian, st.g, st.AB, defect, away, self._box, st.general, self._c, self._on, self._soft, self._rho,
                self._v, self.pi, self._lam, self._t, self._s, self._mu, start, 1e-6, 30,
            )  # fmt: skip
            used += more
            if outcome not in (NOT_CONVEX, BROKEN):
                break
            self._lam[:] = 0.0
            start = 1e-1
        self._warm = outcome not in (NOT_CONVEX, BROKEN)
        return outcome, used

    def _arrive(self) -> None:
        """Take the last step, so small that its linearisation stands for the dynamics where it lands."""
        st, v = self.stages, self._v
        self.z += v[:, : st.nz]
        self.w += v[:-1, st.nz :]
        st.end += (st.AB @ v[:-1, :, None])[:, :, 0]
        st.evaluate_terms(self.z, self.w)

    def _search(self, z0: Array) -> None:
        """The largest of the steps 1, 1/2, 1/4, 1/8 that lowers cost + nu |defects|_1; linearises where it lands."""
        nz = self.stages.nz
        nu = 1.2 * float(np.abs(self.pi).max()) + 1e-3
        before, z, w = self._merit(z0, nu), self.z.copy(), self.w.copy()
        for share in (1.0, 0.5, 0.25, 0.125):
            self.z[:], self.w[:] = z + share * self._v[:, :nz], w + share * self._v[:-1, nz:]
            self.stages.linearise(self.z, self.w)
            if self._merit(z0, nu) <= before + 1e-9 + 1e-6 * abs(before):
                return

    def _merit(self, z0: Array, nu: float) -> float:
        return self._objective() + nu * (
            float(np.abs(self.stages.end - self.z[1:]).sum()) + float(np.abs(z0 - self.z[0]).sum())
        )

    def _objective(self) -> float:
        """Cost with slacks at the last linearisation."""
        st = self.stages
        return float(penalised(self.z, self.w, self._box, self._limits, st.value, self._on, self._rho, st.cost))

    def _defect(self) -> float:
        return float(np.abs(self.stages.end - self.z[1:]).max())


def clip(hessian: Array) -> Array:
    """Each (n, n) block with its eigenvalues raised to LEAST_CURVATURE."""
    values, vectors = np.linalg.eigh(hessian)
    return (vectors * np.maximum(values, LEAST_CURVATURE)[:, None, :]) @ vectors.transpose(0, 2, 1)
