"""A CasADi function as straight-line NumPy code: the same equations where CasADi is not wanted, and what it costs there."""

from __future__ import annotations

from types import MappingProxyType

import casadi as ca

from softsoil.codegen.c_source import check_c_name

_OPERATIONS = MappingProxyType(
    {
        ca.OP_ASSIGN: "{a}", ca.OP_ADD: "{a} + {b}", ca.OP_SUB: "{a} - {b}", ca.OP_MUL: "{a} * {b}", ca.OP_DIV: "{a} / {b}",
        ca.OP_NEG: "-{a}", ca.OP_SQ: "{a} * {a}", ca.OP_TWICE: "2.0 * {a}", ca.OP_INV: "1.0 / {a}",
        ca.OP_SQRT: "sqrt({a})", ca.OP_EXP: "exp({a})", ca.OP_LOG: "log({a})", ca.OP_SIN: "sin({a})", ca.OP_COS: "cos({a})",
        ca.OP_TAN: "tan({a})", ca.OP_ASIN: "arcsin({a})", ca.OP_ACOS: "arccos({a})", ca.OP_ATAN: "arctan({a})",
        ca.OP_ATAN2: "arctan2({a}, {b})", ca.OP_TANH: "tanh({a})", ca.OP_FABS: "fabs({a})", ca.OP_FLOOR: "floor({a})",
        ca.OP_FMIN: "fmin({a}, {b})", ca.OP_FMAX: "fmax({a}, {b})", ca.OP_POW: "{a} ** {b}", ca.OP_CONSTPOW: "{a} ** {b}",
        ca.OP_SIGN: "sign({a})", ca.OP_LT: "1.0 * ({a} < {b})", ca.OP_LE: "1.0 * ({a} <= {b})",
        ca.OP_IF_ELSE_ZERO: "{a} * {b}",
    }
)  # fmt: skip
_IMPORTS = "arccos, arcsin, arctan, arctan2, array, cos, exp, fabs, floor, fmax, fmin, log, sign, sin, sqrt, tan, tanh"


def write_numpy(function: ca.Function, name: str) -> str:
    """Source of a module with one function `name(x, u, p)` that returns the first output as an array.

    function: SX, its inputs vectors. Raises ValueError for a name that is no identifier or an operation that is not here.
    """
    check_c_name(name)
    f = function if function.is_a("SXFunction") else function.expand()
    arguments = [check_c_name(f.name_in(i)) for i in range(f.n_in())]
    rows = f.size1_out(0)
    lines: list[str] = []
    for k in range(f.n_instructions()):
        op, into, out = f.instruction_id(k), f.instruction_input(k), f.instruction_output(k)
        if op == ca.OP_OUTPUT:
            lines.append(f"y{out[1]} = w{into[0]}")
        elif op == ca.OP_CONST:
            lines.append(f"w{out[0]} = {f.instruction_constant(k)!r}")
        elif op == ca.OP_INPUT:
            lines.append(f"w{out[0]} = {arguments[into[0]]}[{into[1]}]")
        elif op in _OPERATIONS:
            names = dict(zip("ab", (f"w{slot}" for slot in into), strict=False))
            lines.append(f"w{out[0]} = {_OPERATIONS[op].format(**names)}")
        else:
            raise ValueError(f"numpy code: expected operations that NumPy has, found CasADi operation {op}")
    body = "\n    ".join(lines)
    return (
        f"from numpy import {_IMPORTS}\n\n\ndef {name}({', '.join(arguments)}):\n    {body}\n"
        f"    return array([{', '.join(f'y{i}' for i in range(rows))}])\n"
    )
