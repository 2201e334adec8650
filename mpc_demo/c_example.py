"""What goes beside the generated C: a README and an example that runs one step."""

from __future__ import annotations

from pathlib import Path

from symbolic.model import Model
from symbolic.signals import Layout

_README = """# {name}: generated C

Written by `softsoil generate`; do not edit. C99, no allocation, no globals, libm only. Build and run the example:

    cc -O2 -std=c99 example.c {stem}.c -o example -lm && ./example

Functions, in CasADi's calling convention `int f(const double **arg, double **res, long long *iw, double *w, int mem)`; sizes of
the work arrays are the macros `f_SZ_ARG`, `f_SZ_RES`, `f_SZ_IW`, `f_SZ_W` of the header; matrices are stored by columns:

| function | arguments | results |
|---|---|---|
| `ode` | x, u, p | xdot |
| `step` | x, u, p | x after {dt:g} s |
| `predict` | x, P, u, p, Q | x, P: the filter's prediction over {dt:g} s |
| `update` | x, P, u, p, y, valid, R, gate | x, P, innovation, S, NIS, used |

`ode` has the states {states}; `step`, `predict` and `update` have {augmented}.

| vector | entries |
|---|---|
{tables}
"""

_EXAMPLE = """#include <stdio.h>
#include "{stem}.h"

/* One step of {dt:g} s from the nominal state. */
int main(void) {{
  double x[] = {{{x}}}, u[] = {{{u}}}, p[] = {{{p}}}, next[{n_x}];
  double w[step_SZ_W + 1];
  long long iw[step_SZ_IW + 1];
  const double *arg[step_SZ_ARG] = {{x, u, p}};
  double *res[step_SZ_RES] = {{next}};
  const char *names[] = {{{names}}};
  if (step(arg, res, iw, w, 0)) return 1;
  for (int i = 0; i < {n_x}; ++i) printf("%s %.17g\\n", names[i], next[i]);
  return 0;
}}
"""


def write_beside(folder: Path, stem: str, model: Model, augmented: Model, dt: float) -> list[Path]:
    """README.md and example.c for the C files `stem` in `folder`; returns their paths.

    model: what `ode` computes; augmented: the filter's model, what the other functions compute; dt: their step (s).
    """
    tables = "\n".join(
        f"| {label} | {_entries(layout)} |"
        for label, layout in (("x", augmented.x), ("u", augmented.u), ("p", augmented.p), ("y", augmented.y))
    )
    readme = _README.format(
        name=model.name,
        stem=stem,
        dt=dt,
        tables=tables,
        states=", ".join(model.x.names),
        augmented=", ".join(augmented.x.names),
    )
    numbers = {key: _numbers(layout) for key, layout in (("x", augmented.x), ("u", augmented.u), ("p", augmented.p))}
    names = ", ".join(f'"{name}"' for name in augmented.x.names)
    example = _EXAMPLE.format(stem=stem, dt=dt, n_x=len(augmented.x), names=names, **numbers)
    written = []
    for name, text in (("README.md", readme), ("example.c", example)):
        (folder / name).write_text(text, encoding="utf-8")
        written.append(folder / name)
    return written


def _entries(layout: Layout) -> str:
    return ", ".join(f"{s.name} ({s.unit or '1'})" for s in layout)


def _numbers(layout: Layout) -> str:
    return ", ".join(repr(float(value)) for value in layout.nominal)
