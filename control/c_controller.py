"""The controller of an Ocp as C: the texts of its files.

`Nmpc` compiles and runs these texts itself, and `softsoil generate --controller` writes them into the library's folder: there
is one solver.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from importlib.metadata import version

import numpy as np

from softsoil.codegen.c_library.kernels import DIGITS, number, write_kernel
from softsoil.codegen.c_library.library import fill, template
from softsoil.control.c_statuses import status_cases, status_enum
from softsoil.control.nmpc_clearance import ABSENT, NEARER, closest
from softsoil.control.nmpc_settings import SETTINGS
from softsoil.control.ocp import CIRCLES, Ocp, half_width
from softsoil.control.ocp_kernels import Whole, curvature, force_use, model_inputs, rates, roll, stage_terms
from softsoil.estimator.tuning import Tuning, by_unit
from softsoil.symbolic.signals import Layout

HESSIANS = ("gauss_newton", "exact")
"""Of the subproblem: that of the cost alone, the default of real-time iterations, or the Lagrangian's."""
TEMPLATES = {
    "include/softsoil_nmpc.h": "softsoil_nmpc.h.in",
    "include/softsoil_qp.h": "softsoil_qp.h.in",
    "src/softsoil_nmpc.c": "softsoil_nmpc.c.in",
    "src/softsoil_nmpc_course.c": "softsoil_nmpc_course.c.in",
    "src/softsoil_nmpc_model.h": "softsoil_nmpc_model.h.in",
    "src/softsoil_nmpc_stages.h": "softsoil_nmpc_stages.h.in",
    "src/softsoil_riccati.h": "softsoil_riccati.h.in",
    "src/softsoil_lanes.h": "softsoil_lanes.h.in",
}
"""Where each template goes; the kernels come beside."""
_POINTS = (True, False)


def controller_files(ocp: Ocp, hessian: str = HESSIANS[0], digits: int = DIGITS) -> dict[str, str]:
    """Path inside the folder -> text of every file of the controller.

    hessian: "exact", the Lagrangian's, or "gauss_newton", the cost's alone; digits: significant digits of constants in the
    kernels. Raises ValueError for another Hessian, or a model whose dynamics C has no operations for.
    """
    if hessian not in HESSIANS:
        raise ValueError(f"nmpc: expected a Hessian of {', '.join(HESSIANS)}; found {hessian!r}")
    exact, values = hessian == "exact", controller_values(ocp)
    kernels, tables = _kernels(ocp, exact, digits)
    values |= tables
    out = {path: template(name) for path, name in TEMPLATES.items()} | kernels
    found = hashlib.sha256(repr((sorted(values.items()), sorted(kernels.items()))).encode()).hexdigest()
    values["nmpc_magic"] = found[:8]
    return {path: fill(text, values) for path, text in out.items()}


def controller_values(ocp: Ocp) -> dict[str, str]:
    """What stands for each @key@ of the templates, the numbers of the kernels left out."""
    return _sizes(ocp) | _numbers(ocp) | _names(ocp)


def sources(texts: Mapping[str, str]) -> list[str]:
    """Each C file of `texts` with the project's own headers put in where they are included: what a compiler is given."""
    headers = {path.rsplit("/", 1)[1]: text for path, text in texts.items() if path.endswith(".h")}
    return [_inlined(text, headers) for path, text in texts.items() if path.endswith(".c")]


def _inlined(text: str, headers: Mapping[str, str]) -> str:
    lines = []
    for line in text.split("\n"):
        name = line.split('"')[1] if line.startswith('#include "') else ""
        lines.append(_inlined(headers[name], headers) if name in headers else line)
    return "\n".join(lines)


def _kernels(ocp: Ocp, exact: bool, digits: int) -> tuple[dict[str, str], dict[str, str]]:
    """The kernels' files, and the numbers that the other files have of them.

    Those of the dynamics stand in files of their own: they take a compiler long, and do not depend on horizon or weights.
    """
    slopes, terms, curve = rates(ocp), stage_terms(ocp), curvature(ocp)
    files = {"src/softsoil_nmpc_rates.c": _source([_kernel(slopes.function, "rates", digits)])}
    used = force_use(ocp) if ocp.bears else None
    if used is not None:
        files["src/softsoil_nmpc_use.c"] = _source([_kernel(used.function, "use", digits)])
    if exact:
        parts = [_kernel(curve.gradient, "gradient", digits), _kernel(curve.rest.function, "rest", digits)]
        files["src/softsoil_nmpc_hessian.c"] = _source(parts)
    if ocp.model.memories:
        files["src/softsoil_nmpc_roll.c"] = _source(
            [_exported(write_kernel(roll(ocp), "softsoil_nmpc_roll", digits=digits, parts=True))]
        )
    wanted = [int(i) for i in curve.wanted]
    in_wanted = [
        wanted.index(column) if row in curve.costly and column in wanted else -1 for row, column in slopes.cells.T
    ]
    touched = sorted({*wanted, *map(int, curve.rest.cells.ravel())})
    stage = _kernel(terms.function, "stage", digits)
    inputs = write_kernel(model_inputs(ocp), "scalar_inputs", digits=digits)
    use_cells = np.zeros((2, 0), dtype=np.int64) if used is None else used.cells
    lists = [
        *_cells("rates", slopes.cells), *(_cells("use", use_cells) if used is not None else []),
        *_cells("cost", terms.hessian), *(_cells("gap", terms.gaps) if terms.gaps.shape[1] else []),
    ]  # fmt: skip
    if exact:
        lists += [*_cells("rest", curve.rest.cells), _table("rates_wanted", in_wanted), _table("wanted", wanted)]
        lists.append(_table("touched", touched))
    files["src/softsoil_nmpc_kernels.h"] = (
        "/* Where the entries of the kernels' results belong, and the cost; generated: never edited by hand. */\n"
        "#ifndef SOFTSOIL_NMPC_KERNELS_H\n#define SOFTSOIL_NMPC_KERNELS_H\n\n"
        + "\n".join(lists)
        + f"\n\n{stage}\n{inputs}\n#endif\n"
    )
    counts = {
        "exact": int(exact), "bears": int(used is not None), "entries": slopes.cells.shape[1],
        "use_entries": use_cells.shape[1], "cost_cells": terms.hessian.shape[1], "gap_cells": terms.gaps.shape[1],
        "wanted_count": max(len(wanted), 1), "direction_count": len(curve.directions),
        "rest_count": curve.rest.cells.shape[1], "rest_cells": max(curve.rest.cells.shape[1], 1),
        "touched_count": max(len(touched), 1),
    }  # fmt: skip
    return files, {name: str(count) for name, count in counts.items()}


def _kernel(function, name: str, digits: int) -> str:
    f = function if function.is_a("SXFunction") else function.expand()
    return _exported(write_kernel(f, f"softsoil_nmpc_{name}", _POINTS, 1, digits, parts=True))


def _exported(kernel: str) -> str:
    """A kernel that other files call: its declaration and its body, after the parts that it calls."""
    before, _, text = kernel.rpartition("static void ")
    text = f"void {text}"
    return f"{before}{text[: text.index(' {')]};\n{text}"


def _source(kernels: list[str]) -> str:
    return (
        "/* The controller's equations, statement by statement, generated: never edited by hand. */\n"
        "/* What a higher level does to text this long makes it slower and takes the compiler longer. */\n"
        '#if defined(__GNUC__) && !defined(__clang__)\n#pragma GCC optimize("O2")\n#endif\n'
        '#include "softsoil_lanes.h"\n\n' + "\n".join(kernels)
    )


def _cells(name: str, cells: Whole) -> list[str]:
    return [_table(f"{name}_row", cells[0]), _table(f"{name}_column", cells[1])]


def _table(name: str, values) -> str:
    return f"static const int {name}[] = {{{', '.join(str(int(v)) for v in values) or '-1'}}};"


def _sizes(ocp: Ocp) -> dict[str, str]:
    settings, nz, nw = ocp.settings, len(ocp.z), len(ocp.w)
    box = [*(ocp.z.index(name) for name in ocp.state_box), *range(nz, nz + nw)]
    sizes = {
        "steps": settings.steps, "nz": nz, "nw": nw, "ns": len(ocp.s), "nr": len(ocp.r), "nm": len(ocp.model.cells),
        "nu": len(ocp.model.external),
        "nb": len(box), "ng": CIRCLES * settings.obstacles + (2 if ocp.bears else 0), "obstacles": settings.obstacles,
        "circles": CIRCLES, "repeats": SETTINGS.repeats, "clear_steps": SETTINGS.clear_steps, "most": SETTINGS.most,
        "qp_most": SETTINGS.qp_most,
    }  # fmt: skip
    return {name: str(size) for name, size in sizes.items()} | {"box": ", ".join(map(str, box))}


def _numbers(ocp: Ocp) -> dict[str, str]:
    settings, weights = ocp.settings, ocp.settings.weights
    limits = [*ocp.state_box.values(), *((signal.lower, signal.upper) for signal in ocp.w)]
    reals = {
        "ocp_dt": settings.dt, "reserve": settings.reserve, "terminal": weights.terminal, "slack": weights.slack,
        "slack_squared": weights.slack_squared, "wheelbase": ocp.vehicle.wheelbase,
        "half_width": half_width(ocp.vehicle), "body": ocp.body - settings.margin,
        **{name: value for name, value in vars(SETTINGS).items() if isinstance(value, float)},
    }  # fmt: skip
    pairs = [f"{{{number(low, 17)}, {number(high, 17)}}}" for low, high in limits]
    return {name: number(value, 17) for name, value in reals.items()} | {
        "default_limits": ", ".join(pairs),
        "absent": _list(ABSENT), "nearer": number(NEARER, 17), "closest": number(closest(ocp), 17),
        "beyond": _list(by_unit(ocp.z, Tuning().output_limit, 1e9)),
        "nominal_z": _list(ocp.z.nominal), "nominal_s": _list(ocp.s.nominal),
    }  # fmt: skip


def _names(ocp: Ocp) -> dict[str, str]:
    limited = [*ocp.state_box, *ocp.w.names]
    effects = ocp.model.effects
    return {
        "model": ocp.model.name, "effects": f" with {', '.join(effects)}" if effects else "",
        "version": version("softsoil"), "casadi": version("casadi"),
        "nmpc_states": _enum("Z", ocp.z), "nmpc_inputs": _enum("W", ocp.w), "nmpc_parameters": _enum("S", ocp.s),
        "nmpc_limits": ", ".join(f"SOFTSOIL_NMPC_LIMIT_{name}" for name in limited),
        "nmpc_status_enum": status_enum(), "nmpc_status_cases": status_cases(),
    }  # fmt: skip


def _enum(prefix: str, layout: Layout) -> str:
    return ", ".join(f"SOFTSOIL_NMPC_{prefix}_{name}" for name in layout.names)


def _list(values) -> str:
    return ", ".join(number(float(value), 17) for value in values)
