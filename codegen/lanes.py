"""One CasADi function at many points, as C that computes several points at once in vector registers.

The filter evaluates its model at every sigma point, multiple shooting at every window: the same operations on other
numbers. CasADi's own C runs the points one after the other; here each operation works on as many points as a register of
the processor holds (`clibrary/templates/softsoil_lanes.h.in`, chosen when the C code is compiled). What is the same for all
points is computed once, with the C library.
"""

from __future__ import annotations

from collections.abc import Sequence
from importlib.resources import files

import casadi as ca

from softsoil.codegen.c_library.kernels import write_kernel
from softsoil.codegen.c_source import check_c_name
from softsoil.codegen.instruction_order import instructions, occupancy

LANES = 8
"""Points in the widest vector: a loop that hands over so many at a time fills it, and two of the next width."""
NARROW = 1.0
"""Functions with less occupancy than this leave a processor waiting: two vectors of points are computed side by side."""
DIGITS = 17
"""Significant digits of constants: all there are, since this C is compiled where it is written."""


def write_lanes(function: ca.Function, count: int, name: str, repeats: int = 1) -> str:
    """C source of `name`: [X (n, count), shared inputs ...] -> [Y (m, count), ...], CasADi's calling convention.

    function: SX, dense; its first input is a point (n,), the others (u, p ...) are the same for all points, each output is
    a vector (m,); repeats: times that it is applied, its one output (n,) in the place of the point. Raises ValueError for
    a name that is no C identifier, matrices, sparse results or an operation without C.
    """
    check_c_name(name)
    ins = [function.size_in(i) for i in range(function.n_in())]
    outs = [function.size_out(i) for i in range(function.n_out())]
    dense = all(function.sparsity_out(i).is_dense() for i in range(function.n_out()))
    if count < 1 or not dense or any(columns != 1 for _, columns in ins + outs):
        raise ValueError(f"lanes: expected dense vectors and at least one point, found {function} at {count} points")
    if repeats < 1 or (repeats > 1 and (len(outs) != 1 or outs[0] != ins[0])):
        raise ValueError(f"lanes: expected one output in the shape of the point to apply {function} {repeats} times")
    side = 2 if count > LANES and occupancy(instructions(function)) < NARROW else 1
    shapes = [_shapes(name, "in", [(ins[0][0], count), *ins[1:]])]
    shapes += [_shapes(name, "out", [(rows, count) for rows, _ in outs])]
    driver = _driver(name, count, repeats, side, ins[0][0], len(ins), [rows for rows, _ in outs])
    return "\n".join([write_group(function, f"{name}_group", side), driver, *shapes])


def write_group(function: ca.Function, name: str, side: int = 1, parts: bool = False) -> str:
    """C source of `static void name(const ssv *x, shared inputs ..., ssv *results ...)` for one vector of points, and of `ssv`.

    function, its inputs and results: as of `write_lanes`; side: vectors that are computed at once; parts: as of `write_kernel`. A
    vector is SOFTSOIL_LANES points wide, which the compiler's machine decides.
    """
    header = (files("softsoil.codegen.c_library") / "templates" / "softsoil_lanes.h.in").read_text(encoding="utf-8")
    kernel = write_kernel(function, name, (True, *[False] * (function.n_in() - 1)), side, DIGITS, parts)
    return f"{header}\n{kernel}"


def _driver(name: str, count: int, repeats: int, side: int, n_x: int, n_in: int, rows: Sequence[int]) -> str:
    """The loop over groups of points; lanes without a point of their own repeat the last one."""
    shared = "".join(f", arg[{i}]" for i in range(1, n_in))
    results = "".join(f", r{i}" for i in range(len(rows)))
    stores = "\n    ".join(
        f"for (int i = 0; i < {side * m}; ++i) ssv_store(lane[i], r{o}[i]);\n"
        f"    for (int l = 0; l < n; ++l)\n"
        f"      for (int j = 0; j < {m}; ++j)\n"
        f"        res[{o}][(k + l) * {m} + j] = lane[l / SOFTSOIL_LANES * {m} + j][l % SOFTSOIL_LANES];"
        for o, m in enumerate(rows)
    )
    call = f"{name}_group(x{shared}{results});"
    if repeats > 1:
        again = f"for (int i = 0; i < {side * n_x}; ++i) x[i] = r0[i];"
        call = f"for (int step = 0; step < {repeats}; ++step) {{\n      {call}\n      {again}\n    }}"
    return f"""int {name}(const double **arg, double **res, long long *iw, double *w, int mem) {{
  enum {{ COUNT = {count}, WIDTH = {side} * SOFTSOIL_LANES }};
  (void)iw; (void)w; (void)mem;
  for (int k = 0; k < COUNT; k += WIDTH) {{
    const int n = COUNT - k < WIDTH ? COUNT - k : WIDTH;
    double lane[{side * max(n_x, *rows)}][SOFTSOIL_LANES];
    ssv x[{side * n_x}]{"".join(f", r{i}[{side * m}]" for i, m in enumerate(rows))};
    for (int l = 0; l < WIDTH; ++l) {{
      const double *from = arg[0] + (k + (l < n ? l : n - 1)) * {n_x};
      for (int j = 0; j < {n_x}; ++j) lane[l / SOFTSOIL_LANES * {n_x} + j][l % SOFTSOIL_LANES] = from[j];
    }}
    for (int i = 0; i < {side * n_x}; ++i) x[i] = ssv_load(lane[i]);
    {call}
    {stores}
  }}
  return 0;
}}"""


def _shapes(name: str, side: str, shapes: Sequence[tuple[int, int]]) -> str:
    """What CasADi asks an external function: how many inputs (outputs), and the shape of each, all dense."""
    table = ", ".join(f"{{{rows}, {columns}, 1}}" for rows, columns in shapes)
    return (
        f"long long {name}_n_{side}(void) {{ return {len(shapes)}; }}\n"
        f"const long long *{name}_sparsity_{side}(long long i) {{\n"
        f"  static const long long shapes[][3] = {{{table}}};\n  return shapes[i];\n}}"
    )
