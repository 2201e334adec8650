"""One CasADi function at many points, as C that computes several points at once in vector registers.

The filter evaluates its model at every sigma point, multiple shooting at every window: the same operations on other
numbers. CasADi's own C runs the points one after the other; here each operation works on LANES points together, in the
vector type that gcc and clang have, which becomes whatever the processor offers. exp and log are branch-free polynomials
(within 2 units in the last place); what is the same for all points is computed once, with the C library.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from types import MappingProxyType

import casadi as ca

from symbolic.codegen import check_c_name

LANES = 4
"""Points per vector: 17 sigma points make five groups, with three lanes idle."""

_PLAIN = MappingProxyType(
    {
        ca.OP_ASSIGN: "{a}", ca.OP_ADD: "{a} + {b}", ca.OP_SUB: "{a} - {b}", ca.OP_MUL: "{a} * {b}", ca.OP_DIV: "{a} / {b}",
        ca.OP_NEG: "-{a}", ca.OP_SQ: "{a} * {a}", ca.OP_TWICE: "2.0 * {a}", ca.OP_INV: "1.0 / {a}",
    }
)  # fmt: skip
"""Operations that the vector type has, written alike for scalars."""
_VECTOR = MappingProxyType({ca.OP_EXP: "exp", ca.OP_LOG: "log", ca.OP_SQRT: "sqrt", ca.OP_FABS: "fabs"})
"""Functions that have a vector form in the preamble: lanes_<name>."""
_SCALAR = MappingProxyType(
    {
        **{getattr(ca, f"OP_{name.upper()}"): f"{name}({{a}})" for name in (
            "sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "asinh", "acosh", "atanh", "floor", "ceil",
            "exp", "log", "sqrt", "fabs", "erf", "log1p", "expm1",
        )},
        **{getattr(ca, f"OP_{name.upper()}"): f"{name}({{a}}, {{b}})" for name in (
            "pow", "atan2", "fmin", "fmax", "fmod", "hypot", "copysign",
        )},
        ca.OP_CONSTPOW: "pow({a}, {b})", ca.OP_LT: "({a} < {b})", ca.OP_LE: "({a} <= {b})", ca.OP_EQ: "({a} == {b})",
        ca.OP_NE: "({a} != {b})", ca.OP_NOT: "(!{a})", ca.OP_AND: "({a} && {b})", ca.OP_OR: "({a} || {b})",
        ca.OP_SIGN: "(({a} > 0) - ({a} < 0))", ca.OP_IF_ELSE_ZERO: "({a} ? {b} : 0.0)",
    }
)  # fmt: skip
"""The rest: C expressions, one lane after the other unless the compiler does better."""

_PREAMBLE = """#include <math.h>
#include <string.h>
typedef double lanes_t __attribute__((vector_size(8 * LANES)));
typedef long long lanes_bits __attribute__((vector_size(8 * LANES)));
#define LANES_EACH(expression) ({ lanes_t y_; for (int l = 0; l < LANES; ++l) y_[l] = (expression); y_; })
#define LANES_ALL(c) ((lanes_t){0} + (c))
static inline lanes_t lanes_pick(lanes_bits where, lanes_t yes, lanes_t no) {
  return (lanes_t)((where & (lanes_bits)yes) | (~where & (lanes_bits)no));
}
static inline lanes_t lanes_sqrt(lanes_t x) { return LANES_EACH(sqrt(x[l])); }
static inline lanes_t lanes_fabs(lanes_t x) { return (lanes_t)((lanes_bits)x & 0x7fffffffffffffffLL); }
/* 2^k e^r with |r| <= ln(2)/2, Taylor to r^13; beyond +-708 the ends are kept. */
static inline lanes_t lanes_exp(lanes_t x) {
  x = lanes_pick(x < -708.0, LANES_ALL(-708.0), x);
  x = lanes_pick(x > 709.0, LANES_ALL(709.0), x);
  lanes_t t = x * 1.4426950408889634 + 0x1.8p52, k = t - 0x1.8p52;
  lanes_t r = (x - k * 0x1.62e42fefa38p-1) - k * 0x1.ef35793c7673p-45;
  lanes_t p = r * (1.0 / 6227020800.0) + 1.0 / 479001600.0;
  p = p * r + 1.0 / 39916800.0; p = p * r + 1.0 / 3628800.0; p = p * r + 1.0 / 362880.0; p = p * r + 1.0 / 40320.0;
  p = p * r + 1.0 / 5040.0; p = p * r + 1.0 / 720.0; p = p * r + 1.0 / 120.0; p = p * r + 1.0 / 24.0;
  p = p * r + 1.0 / 6.0; p = p * r + 0.5; p = p * r + 1.0; p = p * r + 1.0;
  return p * (lanes_t)(((lanes_bits)t - 0x4338000000000000LL + 1023) << 52);
}
/* e ln(2) + log(m) with m in [sqrt(1/2), sqrt(2)), log(m) = 2 atanh((m - 1)/(m + 1)); NaN at and below zero. */
static inline lanes_t lanes_log(lanes_t x) {
  lanes_bits bits = (lanes_bits)x, e = (bits - 0x3fe6a09e667f3bcdLL) >> 52;
  lanes_t m = (lanes_t)(bits - (e << 52)), k = (lanes_t)(e + 0x4338000000000000LL) - 0x1.8p52;
  lanes_t f = m - 1.0, s = f / (f + 2.0), z = s * s;
  lanes_t p = z * (1.0 / 21.0) + 1.0 / 19.0;
  p = p * z + 1.0 / 17.0; p = p * z + 1.0 / 15.0; p = p * z + 1.0 / 13.0; p = p * z + 1.0 / 11.0;
  p = p * z + 1.0 / 9.0; p = p * z + 1.0 / 7.0; p = p * z + 1.0 / 5.0; p = p * z + 1.0 / 3.0;
  lanes_t y = k * 0x1.62e42fefa38p-1 + (2.0 * s + (2.0 * s * z * p + k * 0x1.ef35793c7673p-45));
  return (lanes_t)((lanes_bits)y | ~(x > 0.0));
}
"""


@dataclass
class _Writer:
    """Statements of one group of points, from a function's instructions in order."""

    function: ca.Function
    lines: list[str] = field(default_factory=list)
    value: dict[int, str] = field(default_factory=dict)
    varies: dict[int, bool] = field(default_factory=dict)

    def write(self) -> list[str]:
        for k in range(self.function.n_instructions()):
            self._instruction(k)
        return self.lines

    def _instruction(self, k: int) -> None:
        f, op = self.function, self.function.instruction_id(k)
        into, out = f.instruction_input(k), f.instruction_output(k)
        if op == ca.OP_OUTPUT:
            self._store(out[0], out[1], into[0])
        elif op == ca.OP_CONST:
            self._keep(out[0], f"({f.instruction_constant(k)!r})", False, None)
        elif op == ca.OP_INPUT:
            self._keep(out[0], f"x{into[1]}" if into[0] == 0 else f"a{into[0]}[{into[1]}]", into[0] == 0, None)
        else:
            self._keep(out[0], *self._operation(op, into), k)

    def _operation(self, op: int, slots: Sequence[int]) -> tuple[str, bool]:
        names = dict(zip("ab", (self.value[s] for s in slots), strict=False))
        varies = any(self.varies[s] for s in slots)
        if op in _PLAIN:
            return _PLAIN[op].format(**names), varies
        if op in _VECTOR and varies:
            return f"lanes_{_VECTOR[op]}({names['a']})", True
        if op not in _SCALAR:
            raise ValueError(f"lanes: expected operations of real C functions, found CasADi operation {op}")
        if not varies:
            return _SCALAR[op].format(**names), False
        each = {
            key: f"{name}[l]" if self.varies[s] else name for (key, name), s in zip(names.items(), slots, strict=False)
        }
        return f"LANES_EACH({_SCALAR[op].format(**each)})", True

    def _keep(self, slot: int, expression: str, varies: bool, k: int | None) -> None:
        if k is not None:
            self.lines.append(f"{'lanes_t' if varies else 'double'} t{k} = {expression};")
            expression = f"t{k}"
        self.value[slot], self.varies[slot] = expression, varies

    def _store(self, output: int, element: int, slot: int) -> None:
        rows = self.function.size1_out(output)
        value = f"{self.value[slot]}[l]" if self.varies[slot] else self.value[slot]
        self.lines.append(f"for (int l = 0; l < n; ++l) r{output}[l * {rows} + {element}] = {value};")


def write_lanes(function: ca.Function, count: int, name: str) -> str:
    """C source of `name`: [X (n, count), shared inputs ...] -> [Y (m, count), ...], CasADi's calling convention.

    function: SX, dense; its first input is a point (n,), the others (u, p ...) are the same for all points, each output is
    a vector (m,). Raises ValueError for a name that is no C identifier, matrices, sparse results or an operation without C.
    """
    check_c_name(name)
    ins = [function.size_in(i) for i in range(function.n_in())]
    outs = [function.size_out(i) for i in range(function.n_out())]
    dense = all(function.sparsity_out(i).is_dense() for i in range(function.n_out()))
    if count < 1 or not dense or any(columns != 1 for _, columns in ins + outs):
        raise ValueError(f"lanes: expected dense vectors and at least one point, found {function} at {count} points")
    shared = "".join(f", const double *a{i}" for i in range(1, len(ins)))
    results = "".join(f", double *r{i}" for i in range(len(outs)))
    loads = [
        f"lanes_t x{j} = LANES_EACH(p[(l < n ? l : n - 1) * {ins[0][0]} + {j}]);" for j in range(ins[0][0])
    ]  # idle lanes repeat the last point
    body = "\n  ".join([*loads, *_Writer(function).write()])
    passed = "".join(f", arg[{i}]" for i in range(1, len(ins)))
    places = "".join(f", res[{i}] + k * {rows}" for i, (rows, _) in enumerate(outs))
    return f"""#define LANES {LANES}
{_PREAMBLE}
static void {name}_group(const double *p, int n{shared}{results}) {{
  {body}
}}
int {name}(const double **arg, double **res, long long *iw, double *w, int mem) {{
  (void)iw; (void)w; (void)mem;
  for (int k = 0; k < {count}; k += LANES)
    {name}_group(arg[0] + k * {ins[0][0]}, {count} - k < LANES ? {count} - k : LANES{passed}{places});
  return 0;
}}
{_shapes(name, "in", [(ins[0][0], count), *ins[1:]])}
{_shapes(name, "out", [(rows, count) for rows, _ in outs])}
"""


def _shapes(name: str, side: str, shapes: Sequence[tuple[int, int]]) -> str:
    """What CasADi asks an external function: how many inputs (outputs), and the shape of each, all dense."""
    table = ", ".join(f"{{{rows}, {columns}, 1}}" for rows, columns in shapes)
    return (
        f"long long {name}_n_{side}(void) {{ return {len(shapes)}; }}\n"
        f"const long long *{name}_sparsity_{side}(long long i) {{\n"
        f"  static const long long shapes[][3] = {{{table}}};\n  return shapes[i];\n}}"
    )
