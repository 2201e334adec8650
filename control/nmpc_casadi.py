"""The same Ocp through CasADi's solvers: IPOPT or fatrop as robust fallback, sqpmethod with qrqp as self-contained C.

The programme is an MX graph that calls the SX step; it is never expanded. Slacks of soft limits are variables here.
"""

from __future__ import annotations

import subprocess
import sys
import time
from functools import lru_cache
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike, NDArray

from softsoil.codegen.c_source import write_c
from softsoil.control.nmpc_clearance import closest, gaps_now, judged, placed, planned_gaps
from softsoil.control.nmpc_status import Stats, Status
from softsoil.control.ocp import CIRCLES, OBSTACLE, REFERENCE, Ocp

Array = NDArray[np.float64]

SOLVERS: dict[str, dict[str, Any]] = {
    "ipopt": {
        "print_time": False, "calc_multipliers": False,
        "ipopt": {"print_level": 0, "sb": "yes", "tol": 1e-7, "max_iter": 200, "warm_start_init_point": "yes"},
    },
    "fatrop": {"structure_detection": "auto", "print_time": False, "fatrop": {"print_level": 0, "tol": 1e-6, "max_iter": 300}},
    "sqpmethod": {
        "qpsol": "qrqp", "hessian_approximation": "exact", "convexify_strategy": "eigen-clip", "convexify_margin": 1e-4,
        "print_header": False, "print_iteration": False, "print_status": False, "print_time": False, "max_iter": 30,
        "tol_pr": 1e-6, "tol_du": 1e-5,
        "qpsol_options": {"print_iter": False, "print_header": False, "print_info": False, "error_on_fail": False},
    },
}  # fmt: skip
"""Options by solver."""


PROBE_SECONDS = 20.0
"""A plugin that has not answered a problem of one variable after so long never will."""
_PROBE = (
    "import casadi as ca; x = ca.MX.sym('x'); o = {'print_time': False, 'fatrop': {'print_level': 0}};"
    "ca.nlpsol('s', 'fatrop', {'x': x, 'f': x**2}, o)(x0=1.0)"
)


def answers_in_time(code: str, seconds: float = PROBE_SECONDS) -> bool:
    """Whether Python `code` ends well in a process of its own within so many seconds."""
    try:
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, timeout=seconds, check=False)
    except subprocess.TimeoutExpired:
        return False
    return done.returncode == 0


@lru_cache(maxsize=1)
def fatrop_answers() -> bool:
    """Whether CasADi's fatrop works here; with another package's BLASFEO on the loader's path it never returns."""
    return answers_in_time(_PROBE)


def fallback() -> str:
    """The robust solver that CasADi has here: fatrop where it answers, else IPOPT."""
    return "fatrop" if fatrop_answers() and ca.has_nlpsol("fatrop") else "ipopt"


class CasadiNmpc:
    """The Ocp as a nonlinear programme; the same calls as `Nmpc`.

    solver: of SOLVERS (`fallback()` is the robust one that is here); options: over those that stand there. Raises ValueError
    for a solver that is not known or not part of this CasADi.
    """

    def __init__(self, ocp: Ocp, solver: str = "ipopt", options: dict[str, Any] | None = None) -> None:
        if solver not in SOLVERS:
            raise ValueError(f"nmpc: expected a solver of {', '.join(SOLVERS)}; found {solver!r}")
        if (solver == "fatrop" and not fatrop_answers()) or not ca.has_nlpsol(solver):
            raise ValueError(
                f"nmpc: expected a solver that this CasADi has, found {solver}, which is not among its plugins"
            )
        self.ocp, self.solver = ocp, solver
        self.problem = programme(ocp)
        chosen = {**SOLVERS[solver], "error_on_fail": False, **(options or {})}
        if solver == "fatrop":
            # It finds the stages itself, from which rows are dynamics.
            chosen["equality"] = [bool(same) for same in self.problem.g_lower == self.problem.g_upper]
        self.nlp = ca.nlpsol("nmpc", solver, self.problem.nlp, chosen)
        n = ocp.settings.steps
        self.z, self.w = np.tile(ocp.z.nominal, (n + 1, 1)), np.zeros((n, len(ocp.w)))
        self._parameters: list[Array] = []
        self._obstacles = placed(ocp, None)
        self._duals: dict[str, Any] = {}
        self.stats = Stats(Status.OUT_OF_ITERATIONS)

    def set_parameters(self, s: ArrayLike, r: ArrayLike, ref: ArrayLike, obstacles: ArrayLike | None = None) -> None:
        """As `Nmpc.set_parameters`: s, r, ref, obstacles."""
        n = self.ocp.settings.steps
        self._obstacles = placed(self.ocp, obstacles)
        parts = (s, np.asarray(r), np.asarray(ref), self._obstacles.reshape(n + 1, -1))
        self._parameters = [np.asarray(part, dtype=float).reshape(-1) for part in parts]

    def set_initial_guess(self, z: ArrayLike, w: ArrayLike) -> None:
        """As `Nmpc.set_initial_guess`: z, w."""
        self.z[:], self.w[:] = z, w
        self._duals = {}

    def shift(self, seconds: float) -> None:
        """As `Nmpc.shift` by `seconds`; multipliers start again."""
        share = seconds / self.ocp.settings.dt
        ahead = self.z[-1] + share * (self.z[-1] - self.z[-2])
        for array in (self.z, self.w):
            move_on(array, share)
        self.z[-1] = ahead
        self._duals = {}

    def make_step(self, z0: ArrayLike) -> Array:
        """(n_w,) first input from the state z0 (n_z,); the plan stands in `z`, `w`, the outcome in `stats`.

        Raises ValueError before `set_parameters` has said what is to be driven.
        """
        if not self._parameters:
            raise ValueError("nmpc: expected set_parameters (s, r, ref, obstacles) before make_step, found none was called")
        if not np.isfinite(np.asarray(z0, dtype=float)).all():
            self.stats = Stats(Status.BAD_STATE)
            return self.w[0].copy()
        began = time.perf_counter()
        problem, n = self.problem, self.ocp.settings.steps
        lower, upper = problem.lower.copy(), problem.upper.copy()
        nz = self.z.shape[1]
        lower[:nz] = upper[:nz] = z0
        guess = problem.pack(self.z, self.w)
        found = self.nlp(
            x0=guess, p=np.concatenate(self._parameters), lbx=lower, ubx=upper, lbg=problem.g_lower, ubg=problem.g_upper,
            **self._duals,
        )  # fmt: skip
        ok = bool(self.nlp.stats()["success"])
        if ok:
            self.z[:], self.w[:] = problem.unpack(np.array(found["x"]).ravel())
            self._duals = {"lam_x0": found["lam_x"], "lam_g0": found["lam_g"]}
        status, gap, touch = Status.SOLVER_FAILED, np.inf, -1
        if ok:
            gaps, now = planned_gaps(self.ocp, self.z, self._obstacles), gaps_now(self.ocp, self.z[0], self._obstacles[0])
            status, gap, touch = judged(Status.CONVERGED, gaps, now, closest(self.ocp))
        seconds = time.perf_counter() - began
        iterations = int(self.nlp.stats().get("iter_count", n))
        self.stats = Stats(status, iterations, 0, seconds, seconds, float(found["f"]), gap=gap, touch=touch)
        return self.w[0].copy()


class programme:
    """min f(x, p) s.t. g: nlp (dict of MX), bounds; pack and unpack between x and (z, w).

    x = z_0, w_0, slack_0, z_1, ..., z_N, slack_N; p = s, r, ref, obstacles. Stage-wise order, as fatrop needs it.
    """

    def __init__(self, ocp: Ocp) -> None:
        self.ocp, settings = ocp, ocp.settings
        n, weights = settings.steps, settings.weights
        nz, nw = len(ocp.z), len(ocp.w)
        boxes = [ocp.z.index(name) for name in ocp.state_box]
        self.slacks = CIRCLES * settings.obstacles + 2 + len(boxes)
        s = ca.MX.sym("s", len(ocp.s))
        r, ref = ca.MX.sym("r", len(ocp.r), n), ca.MX.sym("ref", len(REFERENCE), n + 1)
        places = ca.MX.sym("obstacles", len(OBSTACLE) * settings.obstacles, n + 1)
        z = [ca.MX.sym(f"z{k}", nz) for k in range(n + 1)]
        w = [ca.MX.sym(f"w{k}", nw) for k in range(n)]
        slack = [ca.MX.sym(f"slack{k}", self.slacks) for k in range(n + 1)]
        step, cost, clear, rates = ocp.step(), ocp.cost(), ocp.clearance(), ocp.dynamics()
        rest = ca.MX.zeros(nw)
        f, g, g_lower, g_upper, x = ca.MX(0), [], [], [], []
        for k in range(n + 1):
            x += [z[k], *([w[k]] if k < n else []), slack[k]]
            scale = settings.dt * (1.0 if k < n else weights.terminal)
            f += scale * cost(z[k], w[k] if k < n else rest, ref[:, k])
            f += settings.dt * (weights.slack * ca.sum1(slack[k]) + 0.5 * weights.slack_squared * ca.sumsqr(slack[k]))
            if k < n:
                g.append(z[k + 1] - step(z[k], w[k], r[:, k], s))
                g_lower.append(np.zeros(nz))
                g_upper.append(np.zeros(nz))
            if k == 0:
                continue
            rows = [clear(z[k], places[3 * i : 3 * i + 3, k]) for i in range(settings.obstacles)]
            if k < n and ocp.bears:
                use = rates(z[k], w[k], r[:, k], s)[1]
                rows.append(1.0 - settings.reserve - ca.sqrt(use**2 + 1e-4))
            count = sum(row.numel() for row in rows)
            if rows:
                g.append(ca.vertcat(*rows) + slack[k][:count])
                g_lower.append(np.zeros(count))
                g_upper.append(np.full(count, np.inf))
            at = self.slacks - len(boxes)
            for i, (index, (low, high)) in enumerate(zip(boxes, ocp.state_box.values(), strict=True)):
                g += [z[k][index] - low + slack[k][at + i], high - z[k][index] + slack[k][at + i]]
                g_lower.append(np.zeros(2))
                g_upper.append(np.full(2, np.inf))
        p = ca.vertcat(s, ca.vec(r), ca.vec(ref), ca.vec(places))
        self.nlp = {"x": ca.vertcat(*x), "f": f, "g": ca.vertcat(*g), "p": p}
        self.g_lower, self.g_upper = np.concatenate(g_lower), np.concatenate(g_upper)
        self._z, self._w, self._slack = _places(nz, nw, self.slacks, n)
        self.lower, self.upper = np.full(self.nlp["x"].numel(), -np.inf), np.full(self.nlp["x"].numel(), np.inf)
        self.lower[self._w], self.upper[self._w] = ocp.w.lower, ocp.w.upper
        self.lower[self._slack] = 0.0

    def pack(self, z: Array, w: Array) -> Array:
        """x of a plan, slacks zero."""
        x = np.zeros(len(self.lower))
        x[self._z], x[self._w] = z, w
        return x

    def unpack(self, x: Array) -> tuple[Array, Array]:
        """(z, w) of x."""
        return x[self._z], x[self._w]


def _places(nz: int, nw: int, slacks: int, n: int) -> tuple[NDArray[np.int_], NDArray[np.int_], NDArray[np.int_]]:
    """Where z (n + 1, nz), w (n, nw) and the slacks (n + 1, slacks) stand in x."""
    stride = nz + nw + slacks
    starts = stride * np.arange(n + 1)
    z = starts[:, None] + np.arange(nz)
    w = starts[:n, None] + nz + np.arange(nw)
    behind = np.where(np.arange(n + 1) < n, nz + nw, nz)
    return z, w, (starts + behind)[:, None] + np.arange(slacks)


def move_on(array: Array, share: float) -> None:
    """Move the rows of `array` towards the front by a share of a row (linear between rows), the last one kept; in place."""
    whole, rest = int(share), share - int(share)
    if whole:
        array[:-whole] = array[whole:]
        array[-whole:] = array[-1]
    if rest:
        array[:-1] += rest * (array[1:] - array[:-1])


def write_solver(ocp: Ocp, directory: str | Path) -> list[Path]:
    """The whole solver (sqpmethod with qrqp) as self-contained C in `directory`: no library but libm; returns the paths."""
    solver = CasadiNmpc(ocp, "sqpmethod").nlp
    return write_c([solver], directory, "nmpc_solver")
