"""The interior point of the controller's C code at sizes of one's own, compiled and called with plain arrays."""

import ctypes
from dataclasses import dataclass

import numpy as np

from softsoil.codegen.c_library.library import fill, template
from softsoil.codegen.compiled import build_library

SOLVED, SHORT, NOT_CONVEX, BROKEN = range(4)
_CALL = """
int solve(const double *H, const double *g, const double *AB, const double *b, const double *G, const double *c,
          const double *on, const double *soft, const double *rho, const double *z0, double start, double tolerance, int most,
          double *v, double *pi) {
  static softsoil_qp_t p;
  int used = 0;
  memset(&p, 0, sizeof p);
  for (int k = 0; k < STAGES; ++k)
    for (int i = 0; i < NV; ++i) {
      p.g[k][i] = g[k * NV + i];
      for (int j = 0; j < NV; ++j) p.H[k][i][j] = H[(k * NV + i) * NV + j];
      for (int r = 0; r < NG; ++r) p.G[k][r][i] = p.GT[k][i][r] = G[(k * NG + r) * NV + i];
      for (int r = 0; r < NZ && k < QP_N; ++r) p.AB[k][r][i] = p.ABT[k][i][r] = AB[(k * NZ + r) * NV + i];
      if (i < NZ && k < QP_N) p.b[k][i] = b[k * NZ + i];
    }
  for (int k = 0; k < STAGES; ++k)
    for (int i = 0; i < 2 * NB + NG; ++i) {
      p.c[k * WR + i] = c[k * (2 * NB + NG) + i];
      p.on[k * WR + i] = on[k * (2 * NB + NG) + i];
      p.soft[k * WR + i] = p.on[k * WR + i] * soft[i];
    }
  p.rho[0] = rho[0];
  p.rho[1] = rho[1];
  const int outcome = qp_solve(&p, z0, start, tolerance, most, &used);
  for (int k = 0; k < STAGES; ++k) {
    for (int j = 0; j < NV; ++j) v[k * NV + j] = p.v[k][j];
    for (int j = 0; j < NZ; ++j) pi[k * NZ + j] = p.pi[k][j];
  }
  return outcome;
}
"""


@dataclass(frozen=True)
class Problem:
    """H (N + 1, nv, nv), g (N + 1, nv), AB (N, nz, nv), b (N, nz), z0 (nz,), box: limited variables, general
    (N + 1, ng, nv), c, on (N + 1, 2 nb + ng), soft (2 nb + ng,), rho (2,): see softsoil_riccati.h.
    """

    H: np.ndarray
    g: np.ndarray
    AB: np.ndarray
    b: np.ndarray
    z0: np.ndarray
    box: tuple[int, ...]
    general: np.ndarray
    c: np.ndarray
    on: np.ndarray
    soft: np.ndarray
    rho: np.ndarray


def random_problem(seed: int, nw: int = 2, n: int = 6, nz: int = 3) -> Problem:
    """A convex problem with limits on one state (soft) and all inputs (hard), and one general soft row."""
    rng, nv, nb = np.random.default_rng(seed), nz + nw, 1 + nw
    root = rng.standard_normal((n + 1, nv, nv))
    H = root @ root.transpose(0, 2, 1) + 0.1 * np.eye(nv)
    general = rng.standard_normal((n + 1, 1, nv))
    general[n, :, nz:] = 0.0
    rows = 2 * nb + 1
    on, soft = np.ones((n + 1, rows)), np.zeros(rows)
    on[n, 2 : 2 * nb] = on[0, :2] = on[0, 2 * nb] = 0.0
    soft[[0, 1, 2 * nb]] = 1.0
    return Problem(
        H, rng.standard_normal((n + 1, nv)), 0.5 * rng.standard_normal((n, nz, nv)), rng.standard_normal((n, nz)),
        rng.standard_normal(nz), (1, *range(nz, nv)), general, rng.uniform(0.1, 0.6, (n + 1, rows)), on, soft,
        np.array([1.0, 4.0]),
    )  # fmt: skip


def solve(problem: Problem, tolerance: float = 1e-10) -> tuple[int, np.ndarray, np.ndarray]:
    """(outcome, v (N + 1, nv), pi (N + 1, nz)) of the C code."""
    n, nz, nv = problem.AB.shape
    sizes = {"steps": n, "nz": nz, "nw": nv - nz, "nb": len(problem.box), "ng": problem.general.shape[1]}
    values = {name: str(size) for name, size in sizes.items()} | {"box": ", ".join(map(str, problem.box))}
    text = "\n".join(fill(template(name), values) for name in ("softsoil_qp.h.in", "softsoil_riccati.h.in"))
    path = build_library("riccati", [text.replace('#include "softsoil_qp.h"', "") + _CALL])
    v, pi = np.zeros((n + 1, nv)), np.zeros((n + 1, nz))
    given = ("H", "g", "AB", "b", "general", "c", "on", "soft", "rho", "z0")
    arrays = [np.ascontiguousarray(getattr(problem, name), dtype=float) for name in given]
    numbers = (ctypes.c_double(0.1), ctypes.c_double(tolerance), 50)
    pointers = [ctypes.c_void_p(array.ctypes.data) for array in arrays]
    out = [ctypes.c_void_p(array.ctypes.data) for array in (v, pi)]
    return ctypes.CDLL(str(path)).solve(*pointers, *numbers, *out), v, pi
