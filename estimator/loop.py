"""A model's step run over a whole log in one call of generated C, restarted where it should be."""

from __future__ import annotations

import ctypes
import tempfile
from collections.abc import Callable

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike, NDArray

from estimator.compiled import CompiledFunction, build_library, find_compiler
from symbolic.codegen import write_c

Array = NDArray[np.float64]

_DRIVER = """#include <string.h>
int {name}(const double** arg, double** res, long long* iw, double* w, int mem);
int {name}_loop(long n, long every, const double* starts, const double* memories, const double* u, const double* p,
                double* states, double* outputs, double* histories) {{
  double x[{nx} + 1], m[{nm} + 1], xn[{nx} + 1], mn[{nm} + 1], w[{sz_w} + 1];
  long long iw[{sz_iw} + 1];
  const double* arg[{sz_arg} + 1];
  double* res[{sz_res} + 1];
  memcpy(m, memories, {nm} * sizeof(double));
  for (long k = 0; k < n; ++k) {{
    if (k % every == 0) {{
      memcpy(x, starts + (k / every) * {nx}, {nx} * sizeof(double));
      if (!histories) memcpy(m, memories + (k / every) * {nm}, {nm} * sizeof(double));
    }}
    memcpy(states + k * {nx}, x, {nx} * sizeof(double));
    if (histories) memcpy(histories + k * {nm}, m, {nm} * sizeof(double));
    arg[0] = x; arg[1] = m; arg[2] = u + k * {nu}; arg[3] = p;
    res[0] = xn; res[1] = mn; res[2] = outputs + k * {ny};
    if ({name}(arg, res, iw, w, 0)) return 1;
    memcpy(x, xn, {nx} * sizeof(double));
    memcpy(m, mn, {nm} * sizeof(double));
  }}
  return 0;
}}
"""


class StepLoop:
    """Rollouts of one step function over many windows, or along known states, in one C call.

    function: [x, m, u, p] -> [x_next, m_next, y], m the memory. Without a compiler the same loop runs in Python.
    """

    def __init__(self, function: ca.Function) -> None:
        self.sizes = [function.size1_in(i) for i in range(4)]
        self.n_y = function.size1_out(2)
        self._run = self._compiled(function) or self._interpreted(function)

    def windows(self, starts: ArrayLike, memories: ArrayLike, u: ArrayLike, p: ArrayLike) -> tuple[Array, Array]:
        """States (W, N, n_x) and outputs (W, N, n_y) of W windows of N steps.

        starts (W, n_x); memories (W, n_m): at the start of each; u (W, N, n_u); p (n_p,).
        """
        u = np.ascontiguousarray(u, dtype=float)
        count, steps = u.shape[:2]
        states, outputs, _ = self._run(count * steps, steps, starts, memories, u.reshape(count * steps, -1), p, False)
        return states.reshape(count, steps, -1), outputs.reshape(count, steps, -1)

    def along(self, x: ArrayLike, m0: ArrayLike, u: ArrayLike, p: ArrayLike) -> tuple[Array, Array]:
        """Outputs (N, n_y) and memories (N, n_m) along known states x (N, n_x) with inputs u (N, n_u) from memory m0 (n_m,)."""
        u = np.ascontiguousarray(u, dtype=float)
        _, outputs, histories = self._run(len(u), 1, x, np.asarray(m0, dtype=float)[None], u, p, True)
        return outputs, histories

    def _compiled(self, function: ca.Function) -> Callable | None:
        if find_compiler() is None:
            return None
        n_x, n_m, n_u, _ = self.sizes
        name = function.name()
        with tempfile.TemporaryDirectory() as scratch:
            step = write_c([function], scratch, header=False)[0].read_text(encoding="utf-8")
        sizes = {"nx": n_x, "nm": n_m, "nu": n_u, "ny": self.n_y, "sz_w": function.sz_w(), "sz_iw": function.sz_iw()}
        sizes |= {"sz_arg": function.sz_arg(), "sz_res": function.sz_res()}
        library = build_library(f"{name}_loop", (step, _DRIVER.format(name=name, **sizes)))
        if library is None:
            return None
        loop = getattr(ctypes.CDLL(str(library)), f"{name}_loop")
        loop.argtypes = [ctypes.c_long, ctypes.c_long, *[ctypes.c_void_p] * 7]

        def run(n, every, starts, memories, u, p, along):
            held = [np.ascontiguousarray(a, dtype=float) for a in (starts, memories, u, p)]
            states, outputs = np.empty((n, n_x)), np.empty((n, self.n_y))
            histories = np.empty((n, n_m)) if along else None
            pointers = [a.ctypes.data for a in (*held, states, outputs)]
            loop(n, every, *pointers, histories.ctypes.data if histories is not None else None)
            return states, outputs, histories

        return run

    def _interpreted(self, function: ca.Function) -> Callable:
        step = CompiledFunction(function, compiled=False)
        n_x, n_m, _, _ = self.sizes

        def run(n, every, starts, memories, u, p, along):
            starts, memories = np.asarray(starts, dtype=float), np.asarray(memories, dtype=float)
            states, outputs, histories = np.empty((n, n_x)), np.empty((n, self.n_y)), np.empty((n, n_m))
            x, m = starts[0], memories[0]
            for k in range(n):
                if k % every == 0:
                    x = starts[k // every]
                    m = m if along else memories[k // every]
                states[k], histories[k] = x, m
                x, m, outputs[k] = (np.atleast_1d(part) for part in step(x, m, u[k], p))
            return states, outputs, histories if along else None

        return run
