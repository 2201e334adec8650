"""A model's step run over many windows, or its histories along known states, for many parameter sets, in one call of generated C.

Windows and parameter sets are jobs that know nothing of each other: they run side by side in vector lanes
(`softsoil.codegen.lanes`), histories included.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike, NDArray

from softsoil.codegen.compiled import find_compiler, group_library

Array = NDArray[np.float64]

_DRIVER = """enum {{ NX = {nx}, NM = {nm}, NU = {nu}, NP = {np}, NY = {ny}, NZ = NX + NM + NU + NP, WIDE = SOFTSOIL_LANES }};

/* Row i of z takes number i of each lane's own. */
static void gather(ssv *z, int size, const double *const from[WIDE]) {{
  double lane[WIDE];
  for (int i = 0; i < size; ++i) {{
    for (int l = 0; l < WIDE; ++l) lane[l] = from[l][i];
    z[i] = ssv_load(lane);
  }}
}}

static void scatter(const ssv *z, int size, int lanes, double *const to[WIDE]) {{
  double lane[WIDE];
  for (int i = 0; i < size; ++i) {{
    ssv_store(lane, z[i]);
    for (int l = 0; l < lanes; ++l) to[l][i] = lane[l];
  }}
}}

/* Memories are kept at the rows (sorted) where wanted. */
int {name}_loop(long jobs, long n, const double* x, const double* m, const double* u, long u_stride,
                const double* p, double* outputs, long n_rows, const long* rows, double* kept) {{
  ssv z[NZ + 1], {states}ms[NM + 1], ys[NY + 1];
  const double *from[WIDE];
  double *to[WIDE];
  for (long first = 0; first < jobs; first += WIDE) {{
    const int lanes = jobs - first < WIDE ? (int)(jobs - first) : WIDE;
    long job[WIDE];
    for (int l = 0; l < WIDE; ++l) job[l] = first + (l < lanes ? l : lanes - 1);
    for (int l = 0; l < WIDE; ++l) from[l] = x + job[l] * {stride} * NX;
    gather(z, NX, from);
    for (int l = 0; l < WIDE; ++l) from[l] = m + job[l] * NM;
    gather(z + NX, NM, from);
    for (int l = 0; l < WIDE; ++l) from[l] = p + job[l] * NP;
    gather(z + NX + NM + NU, NP, from);
    for (long k = 0, r = 0; k < n; ++k) {{
{before}      for (int l = 0; l < WIDE; ++l) from[l] = u + job[l] * u_stride + k * NU;
      gather(z + NX + NM, NU, from);
      if (r < n_rows && rows[r] == k) {{
        for (int l = 0; l < lanes; ++l) to[l] = kept + (job[l] * n_rows + r) * NM;
        scatter(z + NX, NM, lanes, to);
        ++r;
      }}
      {call}
      for (int l = 0; l < lanes; ++l) to[l] = outputs + (job[l] * n + k) * NY;
      scatter(ys, NY, lanes, to);
{after}      for (int i = 0; i < NM; ++i) z[NX + i] = ms[i];
    }}
  }}
  return 0;
}}
"""
_PREDICTED = {
    "states": "xs[NX + 1], ", "stride": "1", "before": "", "call": "{name}_group(z, xs, ms, ys);",
    "after": "      for (int i = 0; i < NX; ++i) z[i] = xs[i];\n",
}  # fmt: skip
_KNOWN = {
    "states": "", "stride": "n", "call": "{name}_group(z, ms, ys);", "after": "",
    "before": "      for (int l = 0; l < WIDE; ++l) from[l] = x + (job[l] * n + k) * NX;\n      gather(z, NX, from);\n",
}  # fmt: skip


class _Loop:
    """One function compiled with the loop around it: [x, m, u, p] -> [m_next, y] where the states are `known` at every step, else
    -> [x_next, m_next, y].

    Without a compiler the same loop runs in the CasADi VM.
    """

    def __init__(self, function: ca.Function, known: bool) -> None:
        self.sizes, self.known = [function.size1_in(i) for i in range(4)], known
        self.n_y = function.size1_out(function.n_out() - 1)
        z = ca.SX.sym("z", sum(self.sizes))
        self._joined = ca.Function(f"{function.name()}_lanes", [z], [ca.densify(r) for r in function(*self._split(z))])
        self.run = self._compiled() or self._interpreted()

    def _split(self, z):
        ends = np.cumsum([0, *self.sizes])
        return [z[int(a) : int(b)] for a, b in zip(ends[:-1], ends[1:], strict=True)]

    def _compiled(self) -> Callable | None:
        if find_compiler() is None:
            return None
        n_x, n_m, n_u, n_p = self.sizes
        name = self._joined.name()
        texts = _KNOWN if self.known else _PREDICTED
        texts = texts | {"call": texts["call"].format(name=name)}
        driver = _DRIVER.format(name=name, nx=n_x, nm=n_m, nu=n_u, np=n_p, ny=self.n_y, **texts)
        library = group_library(self._joined, driver)
        if library is None:
            return None
        loop = getattr(ctypes.CDLL(str(library)), f"{name}_loop")
        pointer, integer = ctypes.c_void_p, ctypes.c_long
        loop.argtypes = [integer, integer, pointer, pointer, pointer, integer, pointer, pointer, integer, pointer, pointer]

        def run(x, m, u, stride, p, rows):
            jobs, n = len(x), u.shape[-2]
            outputs, kept = np.empty((jobs, n, self.n_y)), np.empty((jobs, len(rows), n_m))
            data = [a.ctypes.data for a in (x, m, u)]
            tail = [len(rows), rows.ctypes.data, kept.ctypes.data]
            loop(jobs, n, *data, stride, p.ctypes.data, outputs.ctypes.data, *tail)
            return outputs, kept

        return run

    def _interpreted(self) -> Callable:
        n_m = self.sizes[1]

        def run(x, m, u, stride, p, rows):
            jobs, n = len(x), u.shape[-2]
            many = self._joined.map(jobs)
            outputs = np.empty((jobs, n, self.n_y))
            kept = [np.empty((jobs, 0, n_m))]
            states = x
            for k in range(n):
                states = x[:, k] if self.known else states
                if k in rows:
                    kept.append(m[:, None])
                now = u[:, k] if stride else np.tile(u[k], (jobs, 1))
                found = [part.full().T for part in many(np.hstack([states, m, now, p]).T)]
                states, (m, outputs[:, k]) = found[0], found[-2:]
            return outputs, np.concatenate(kept, axis=1)

        return run


class StepLoop(_Loop):
    """Predictions of one step function for many jobs in one C call.

    function: SX, [x, m, u, p] -> [x_next, m_next, y], m the memory.
    """

    def __init__(self, function: ca.Function) -> None:
        super().__init__(function, known=False)

    def windows(self, starts: ArrayLike, memories: ArrayLike, u: ArrayLike, p: ArrayLike) -> Array:
        """Outputs (J, N, n_y) of J jobs of N steps: starts (J, n_x), memories (J, n_m), u (J, N, n_u), p (J, n_p)."""
        starts, memories, u, p = (np.ascontiguousarray(a, dtype=float) for a in (starts, memories, u, p))
        return self.run(starts, memories, u, u.shape[1] * u.shape[2], p, np.empty(0, dtype=np.int64))[0]


class PathLoop(_Loop):
    """Histories, and what depends on them, along known states for many jobs in one C call.

    function: SX, [x, m, u, p] -> [m_next, y], m the memory: no state is integrated, which is most of a step's work.
    """

    def __init__(self, function: ca.Function) -> None:
        super().__init__(function, known=True)

    def along(self, x: ArrayLike, m0: ArrayLike, u: ArrayLike, p: ArrayLike, rows: ArrayLike) -> tuple[Array, Array]:
        """Along known states x (J, N, n_x) with common inputs u (N, n_u), from memories m0 (J, n_m), for p (J, n_p):

        outputs (J, N, n_y), and the memories (J, R, n_m) at the sorted rows (R,).
        """
        x, m0, u, p = (np.ascontiguousarray(a, dtype=float) for a in (x, m0, u, p))
        return self.run(x, m0, u, 0, p, np.ascontiguousarray(rows, dtype=np.int64))
