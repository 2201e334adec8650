"""What a compiler makes of the long kernels: its own time and that of a call, whole and in parts, at several levels.

Run: python -m benchmarks.kernel_compilers
The kernels are the controller's rates (points of the horizon share parameters) and the step of a model's windows, both of the
reference vehicle on clay. Every line is compared with the first of its kernel, in the same run.
"""

from __future__ import annotations

import ctypes
import subprocess
import tempfile
import time
from collections.abc import Sequence
from importlib.resources import files
from pathlib import Path

import casadi as ca
import numpy as np

from softsoil.codegen.c_library.kernels import write_kernel
from softsoil.codegen.compiled import FLAGS, find_compiler
from softsoil.codegen.discretize import step_with_memory
from softsoil.control.declared import for_control
from softsoil.control.ocp import Ocp
from softsoil.control.ocp_kernels import rates
from softsoil.declaration.model_file import Declaration
from softsoil.symbolic.soil import CLAY
from softsoil.symbolic.vehicle import load_vehicle

CALLS, ROUNDS = 500, 5
CONTROLLER = ((False, "-O2"), (True, "-O2"), (True, "-Og"))
WINDOWS = ((False, "-O3"), (True, "-O3"), (True, "-O1"), (True, "-Og"))
"""Whether in parts, and the level, of each line; the project takes the controller's second and the windows' last."""


def main() -> None:
    """Print one line per kernel, form and level."""
    compiler = find_compiler()
    if compiler is None:
        raise SystemExit("kernel_compilers: expected a C compiler ($CC, cc, gcc or clang), found none")
    declared = for_control(Declaration(load_vehicle("reference"), CLAY))
    model = declared.build()
    slopes, step = rates(Ocp(model, declared.vehicle)).function, step_with_memory(model, 0.012)
    kernels = {
        "controller's rates": (slopes if slopes.is_a("SXFunction") else slopes.expand(), (True, False), CONTROLLER),
        "step of windows": (step, (True,) * step.n_in(), WINDOWS),
    }
    for title, (function, varies, forms) in kernels.items():
        first: tuple[float, float] | None = None
        for parts, level in forms:
            made, call = timed(compiler, write_kernel(function, "kernel", varies, parts=parts), function, varies, level)
            first = first or (made, call)
            form = "in parts" if parts else "whole"
            ratios = f"{made / first[0]:5.2f} and {call / first[1]:5.2f} of the first"
            print(f"{title:20s} {form:8s} {level}: compiled in {made:6.2f} s, a call {1e6 * call:7.1f} us; {ratios}", flush=True)


def timed(compiler: str, text: str, function: ca.Function, varies: Sequence[bool], level: str) -> tuple[float, float]:
    """Seconds of the compiler, and of one call for as many points as a vector holds (the best of ROUNDS)."""
    header = (files("softsoil.codegen.c_library") / "templates" / "softsoil_lanes.h.in").read_text(encoding="utf-8")
    sizes = [function.size1_in(i) for i in range(function.n_in())]
    kinds = ["ssv" if flag else "double" for flag in varies]
    rooms = [f"{kind} a{i}[{max(size, 1)}];" for i, (kind, size) in enumerate(zip(kinds, sizes, strict=True))]
    rooms += [f"static ssv r{i}[{function.size1_out(i)}];" for i in range(function.n_out())]
    zero = "ssv_all(0.0) + "
    fill = [
        f"for (int i = 0; i < {size}; ++i) a{n}[i] = {zero if flag else ''}x[k++];"
        for n, (flag, size) in enumerate(zip(varies, sizes, strict=True))
    ]
    names = ", ".join([f"a{i}" for i in range(function.n_in())] + [f"r{i}" for i in range(function.n_out())])
    run = f"""void run(const double *x, int calls) {{
  int k = 0;
  static {' static '.join(rooms[: len(sizes)])}
  {' '.join(rooms[len(sizes):])}
  {' '.join(fill)}
  for (int c = 0; c < calls; ++c) {{ kernel({names}); __asm__ volatile("" ::: "memory"); }}
}}"""
    with tempfile.TemporaryDirectory() as folder:
        source, library = Path(folder) / "kernel.c", Path(folder) / "kernel.so"
        source.write_text(f"{header}\n{text}\n{run}\n", encoding="utf-8")
        began = time.perf_counter()
        subprocess.run([compiler, level, *FLAGS[1:], "-shared", str(source), "-lm", "-o", str(library)], check=True)
        made = time.perf_counter() - began
        c = ctypes.CDLL(str(library)).run
        c.argtypes = [ctypes.c_void_p, ctypes.c_int]
        x = np.full(sum(sizes), 0.1)
        seconds = []
        for _ in range(ROUNDS):
            began = time.perf_counter()
            c(x.ctypes.data, CALLS)
            seconds.append((time.perf_counter() - began) / CALLS)
    return made, min(seconds)


if __name__ == "__main__":
    main()
