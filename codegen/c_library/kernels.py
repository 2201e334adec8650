"""CasADi SX functions as C functions, one scalar at a time or several points at once (`softsoil_lanes.h`).

Every operation of the function becomes one C statement. In the lanes form an operation on what differs from point to
point works on the vector type `ssv`, and on `double` where all points share the value; with one lane `ssv` is `double`
and the text is plain C99.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from types import MappingProxyType

import casadi as ca

from softsoil.codegen.instruction_order import Instruction, instructions, interleaved
from softsoil.codegen.kernel_parts import PART, in_parts

DIGITS = 13
"""Significant digits of constants: quadrature nodes differ between processors in the last bit, written files must not."""

_INFIX = MappingProxyType(
    {
        ca.OP_ASSIGN: "{a}", ca.OP_ADD: "{a} + {b}", ca.OP_SUB: "{a} - {b}", ca.OP_MUL: "{a} * {b}",
        ca.OP_NEG: "-{a}", ca.OP_SQ: "{a} * {a}", ca.OP_TWICE: "2.0 * {a}",
    }
)  # fmt: skip
"""Operators: the same text for scalars and vectors, mixed ones included."""
_DIVISIONS = MappingProxyType({ca.OP_DIV: "{a}", ca.OP_INV: "1.0"})
_CALLS = MappingProxyType(
    {
        **{getattr(ca, f"OP_{name.upper()}"): name for name in (
            "exp", "log", "sqrt", "fabs", "sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "floor",
            "ceil", "asinh", "acosh", "atanh", "erf", "log1p", "expm1", "atan2", "fmin", "fmax", "fmod", "pow", "hypot",
            "copysign", "lt", "le", "eq", "ne", "not", "and", "or", "sign", "if_else_zero",
        )},
        ca.OP_CONSTPOW: "pow",
    }
)  # fmt: skip
"""Functions: ssv_<name> for vectors; for scalars C's own, or ss_<name> of softsoil_lanes.h where C has none."""
_GROUP = "@"
"""Stands for the number of a group until the statement is written."""
_OWN = frozenset({"lt", "le", "eq", "ne", "not", "and", "or", "sign", "if_else_zero", "fmin", "fmax"})


def number(value: float, digits: int = DIGITS) -> str:
    """A C literal of `value` with so many significant digits."""
    if math.isinf(value):
        return "HUGE_VAL" if value > 0 else "-HUGE_VAL"
    text = repr(float(f"{value:.{digits}g}"))
    return text if any(c in text for c in ".en") else f"{text}.0"


@dataclass
class _Writer:
    """Statements of one function, for one group of points or for several side by side."""

    function: ca.Function
    varies_in: Sequence[bool]
    groups: int
    digits: int
    lines: list[str] = field(default_factory=list)
    value: dict[int, str] = field(default_factory=dict)
    varies: dict[int, bool] = field(default_factory=dict)

    def write(self) -> list[str]:
        sequence = instructions(self.function)
        for k in interleaved(sequence, self.groups):
            item = sequence[k]
            if item.op == ca.OP_OUTPUT:
                self._store(item)
            elif item.op == ca.OP_CONST:
                literal = number(item.constant, self.digits)
                self.value[k], self.varies[k] = f"({literal})" if literal[0] == "-" else literal, False
            elif item.op == ca.OP_INPUT:
                self._load(k, item.place)
            else:
                self._compute(k, item)
        return self.lines

    def _load(self, k: int, place: tuple[int, int]) -> None:
        varies = self.varies[k] = self.varies_in[place[0]]
        along = f" + {_GROUP} * {self.function.size1_in(place[0])}" if varies and self.groups > 1 else ""
        self.value[k] = f"a{place[0]}[{place[1]}{along}]"

    def _store(self, item: Instruction) -> None:
        output, element = item.place
        along = f" + {_GROUP} * {self.function.size1_out(output)}" if self.groups > 1 else ""
        self._each(f"r{output}[{element}{along}] = {self._as(item.reads[0], any(self.varies_in))};")

    def _compute(self, k: int, item: Instruction) -> None:
        expression, varies = self._operation(item.op, item.reads)
        name = f"t{k}_{_GROUP}" if varies and self.groups > 1 else f"t{k}"
        self._each(f"const {'ssv' if varies else 'double'} {name} = {expression};")
        self.value[k], self.varies[k] = name, varies

    def _each(self, statement: str) -> None:
        """The statement once, or for each group where it differs between groups."""
        groups = self.groups if _GROUP in statement else 1
        self.lines.append(" ".join(statement.replace(_GROUP, str(g)) for g in range(groups)))

    def _as(self, slot: int, vector: bool) -> str:
        return f"ssv_all({self.value[slot]})" if vector and not self.varies[slot] else self.value[slot]

    def _operation(self, op: int, slots: Sequence[int]) -> tuple[str, bool]:
        varies = any(self.varies[s] for s in slots)
        names = dict(zip("ab", (self.value[s] for s in slots), strict=False))
        if op in _INFIX:
            return _INFIX[op].format(**names), varies
        if op in _DIVISIONS:
            return self._quotient(_DIVISIONS[op].format(**names), slots, varies), varies
        if op not in _CALLS:
            raise ValueError(f"C library: expected operations that C has, found CasADi operation {op}")
        name = _CALLS[op]
        arguments = ", ".join(self._as(s, varies) for s in slots[: 1 if name in _ONE else 2])
        prefix = "ssv_" if varies else "ss_" if name in _OWN else ""
        return f"{prefix}{name}({arguments})", varies

    def _quotient(self, numerator: str, slots: Sequence[int], varies: bool) -> str:
        below = slots[-1]
        if not varies:
            return f"{numerator} / {self.value[below]}"
        if not self.varies[below]:
            return f"{numerator} * (1.0 / {self.value[below]})"
        over = numerator if len(slots) == 2 and self.varies[slots[0]] else f"ssv_all({numerator})"
        return f"ssv_div({over}, {self.value[below]})"


_ONE = frozenset(
    {"exp", "log", "sqrt", "fabs", "sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "asinh",
     "acosh", "atanh", "floor", "ceil", "erf", "log1p", "expm1", "not", "sign"}
)  # fmt: skip
"""Functions of one argument."""


def write_kernel(
    function: ca.Function,
    name: str,
    varies: Sequence[bool] | None = None,
    groups: int = 1,
    digits: int = DIGITS,
    parts: bool = False,
) -> str:
    """C text of `static void name(inputs ..., outputs ...)`: pointers to vectors, in CasADi's order.

    function: SX, dense vectors; varies: which inputs differ from point to point (ssv), None for plain scalars;
    groups: how many vectors of points are computed side by side, for functions whose operations wait for one another:
    what varies then stands in arrays of so many rows; digits: significant digits of constants; parts: cut into several functions
    where it is long, for one group.
    Raises ValueError for sparse results, matrices, an operation that C does not have, or parts of several groups.
    """
    lanes = varies is not None and any(varies)
    flags = tuple(varies) if varies is not None and lanes else (False,) * function.n_in()
    dense = all(function.sparsity_out(i).is_dense() for i in range(function.n_out()))
    columns = [function.size2_in(i) for i in range(function.n_in())]
    if not dense or len(flags) != function.n_in() or any(c > 1 for c in columns):
        raise ValueError(f"C library: expected dense vectors and a flag for each input, found {function}")
    kind = ["ssv" if flag else "double" for flag in flags]
    result = "ssv" if lanes else "double"
    inputs = [f"const {kind[i]} *a{i}" for i in range(function.n_in())]
    outputs = [f"{result} *r{i}" for i in range(function.n_out())]
    statements = _Writer(function, flags, groups if lanes else 1, digits).write()
    if parts and groups > 1:
        raise ValueError(f"C library: expected one group of points to cut {function} in parts, found {groups}")
    return in_parts(name, [*inputs, *outputs], statements, PART if parts else len(statements))
