"""A model's step run over many windows, or along known states, for many parameter sets, in one call of generated C.

Windows and parameter sets are jobs that know nothing of each other: they run side by side in vector lanes
(`softsoil.codegen.lanes`), histories included.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike, NDArray

from softsoil.codegen.compiled import build_library, find_compiler
from softsoil.codegen.lanes import write_group

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

/* known: states are given at every step, else only at the first; memories are kept at the rows (sorted) where wanted. */
int {name}_loop(long jobs, long n, int known, const double* x, const double* m, const double* u, long u_stride,
                const double* p, double* outputs, long n_rows, const long* rows, double* kept) {{
  ssv z[NZ + 1], xs[NX + 1], ms[NM + 1], ys[NY + 1];
  const double *from[WIDE];
  double *to[WIDE];
  for (long first = 0; first < jobs; first += WIDE) {{
    const int lanes = jobs - first < WIDE ? (int)(jobs - first) : WIDE;
    long job[WIDE];
    for (int l = 0; l < WIDE; ++l) job[l] = first + (l < lanes ? l : lanes - 1);
    for (int l = 0; l < WIDE; ++l) from[l] = x + job[l] * (known ? n : 1) * NX;
    gather(z, NX, from);
    for (int l = 0; l < WIDE; ++l) from[l] = m + job[l] * NM;
    gather(z + NX, NM, from);
    for (int l = 0; l < WIDE; ++l) from[l] = p + job[l] * NP;
    gather(z + NX + NM + NU, NP, from);
    for (long k = 0, r = 0; k < n; ++k) {{
      if (known) {{
        for (int l = 0; l < WIDE; ++l) from[l] = x + (job[l] * n + k) * NX;
        gather(z, NX, from);
      }}
      for (int l = 0; l < WIDE; ++l) from[l] = u + job[l] * u_stride + k * NU;
      gather(z + NX + NM, NU, from);
      if (r < n_rows && rows[r] == k) {{
        for (int l = 0; l < lanes; ++l) to[l] = kept + (job[l] * n_rows + r) * NM;
        scatter(z + NX, NM, lanes, to);
        ++r;
      }}
      {name}_group(z, xs, ms, ys);
      for (int l = 0; l < lanes; ++l) to[l] = outputs + (job[l] * n + k) * NY;
      scatter(ys, NY, lanes, to);
      for (int i = 0; i < NX; ++i) z[i] = xs[i];
      for (int i = 0; i < NM; ++i) z[NX + i] = ms[i];
    }}
  }}
  return 0;
}}
"""


class StepLoop:
    """Rollouts of one step function for many jobs in one C call.

    function: SX, [x, m, u, p] -> [x_next, m_next, y], m the memory. Without a compiler the same loop runs in the CasADi VM.
    """

    def __init__(self, function: ca.Function) -> None:
        self.sizes = [function.size1_in(i) for i in range(4)]
        self.n_y = function.size1_out(2)
        z = ca.SX.sym("z", sum(self.sizes))
        self._joined = ca.Function(f"{function.name()}_lanes", [z], [ca.densify(r) for r in function(*self._split(z))])
        self._run = self._compiled() or self._interpreted()

    def _split(self, z):
        ends = np.cumsum([0, *self.sizes])
        return [z[int(a) : int(b)] for a, b in zip(ends[:-1], ends[1:], strict=True)]

    def windows(self, starts: ArrayLike, memories: ArrayLike, u: ArrayLike, p: ArrayLike) -> Array:
        """Outputs (J, N, n_y) of J jobs of N steps: starts (J, n_x), memories (J, n_m), u (J, N, n_u), p (J, n_p)."""
        starts, memories, u, p = (np.ascontiguousarray(a, dtype=float) for a in (starts, memories, u, p))
        return self._run(len(starts), u.shape[1], False, starts, memories, u, u.shape[1] * u.shape[2], p, None)[0]

    def along(self, x: ArrayLike, m0: ArrayLike, u: ArrayLike, p: ArrayLike, rows: ArrayLike) -> tuple[Array, Array]:
        """Along known states x (J, N, n_x) with common inputs u (N, n_u), from memories m0 (J, n_m), for p (J, n_p):

        outputs (J, N, n_y), and the memories (J, R, n_m) at the sorted rows (R,).
        """
        x, m0, u, p = (np.ascontiguousarray(a, dtype=float) for a in (x, m0, u, p))
        return self._run(len(x), len(u), True, x, m0, u, 0, p, np.ascontiguousarray(rows, dtype=np.int64))

    def _compiled(self) -> Callable | None:
        if find_compiler() is None:
            return None
        n_x, n_m, n_u, n_p = self.sizes
        name = self._joined.name()
        driver = _DRIVER.format(name=name, nx=n_x, nm=n_m, nu=n_u, np=n_p, ny=self.n_y)
        library = build_library(f"{name}_loop", (f"{write_group(self._joined, f'{name}_group')}\n{driver}",))
        if library is None:
            return None
        loop = getattr(ctypes.CDLL(str(library)), f"{name}_loop")
        pointer, integer = ctypes.c_void_p, ctypes.c_long
        loop.argtypes = [integer, integer, ctypes.c_int, pointer, pointer, pointer, integer, pointer, pointer, integer]
        loop.argtypes += [pointer, pointer]

        def run(jobs, n, known, x, m, u, stride, p, rows):
            outputs = np.empty((jobs, n, self.n_y))
            rows = np.empty(0, dtype=np.int64) if rows is None else rows
            kept = np.empty((jobs, len(rows), n_m))
            data = [a.ctypes.data for a in (x, m, u)]
            tail = [len(rows), rows.ctypes.data, kept.ctypes.data]
            loop(jobs, n, known, *data, stride, p.ctypes.data, outputs.ctypes.data, *tail)
            return outputs, kept

        return run

    def _interpreted(self) -> Callable:
        n_m = self.sizes[1]

        def run(jobs, n, known, x, m, u, stride, p, rows):
            many = self._joined.map(jobs)
            outputs = np.empty((jobs, n, self.n_y))
            kept = [np.empty((jobs, 0, n_m))]
            states = x[:, 0] if known else x
            for k in range(n):
                states = x[:, k] if known else states
                if rows is not None and k in rows:
                    kept.append(m[:, None])
                now = u[:, k] if stride else np.tile(u[k], (jobs, 1))
                after = many(np.hstack([states, m, now, p]).T)
                states, m, outputs[:, k] = (part.full().T for part in after)
            return outputs, np.concatenate(kept, axis=1)

        return run
