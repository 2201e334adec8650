"""A long straight line of C cut into functions: compilers need time that grows with more than the length of one.

What a later part reads is put down in an array of vectors, in places that are used again; with thousands of values for sixteen
registers it would lie in memory anyway.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

PART = 1200
"""Statements in a part: half the compiler's time, one to two per cent more at run time; much shorter ones cost more of either."""
_VALUE = re.compile(r"\bt\d+\b")
_APART = "#ifdef __GNUC__\n__attribute__((noinline))\n#endif\n"


def in_parts(name: str, arguments: Sequence[str], statements: Sequence[str], size: int = PART) -> str:
    """C text of `static void name(arguments)` that runs the statements in parts of `size`.

    arguments: declarations of pointers, "const ssv *a0"; statements: "const ssv t<number> = ...;", read by later ones, or
    "r<output>[...] = ...;". What fits in one part is one function.
    """
    if len(statements) <= size:
        return one_function(name, arguments, statements)
    parts = [statements[i : i + size] for i in range(0, len(statements), size)]
    last = {value: k for k, part in enumerate(parts) for line in part for value in _VALUE.findall(line)}
    place: dict[str, int] = {}
    free: list[int] = []
    count, texts = 0, []
    shared = [argument.replace("*", "*restrict ") for argument in (*arguments, "ssv *w")]
    for k, part in enumerate(parts):
        lines: list[str] = []
        kept: dict[str, int] = {}
        for line in part:
            to, _, what = line.partition(" = ")
            lines.append(f"{to} = {_from(place, what)}")
            value = to.split()[-1]
            if last.get(value, k) > k:
                if not free:
                    free, count = [count], count + 1
                kept[value] = free.pop()
                lines.append(f"w[{kept[value]}] = {value};")
        texts.append(_APART + one_function(f"{name}_{k}", shared, lines))
        free += [place.pop(value) for value in list(place) if last[value] == k]
        place |= kept
    names = ", ".join([*(argument.rpartition("*")[2] for argument in arguments), "w"])
    calls = [f"ssv w[{max(count, 1)}];", *(f"{name}_{k}({names});" for k in range(len(parts)))]
    return "".join(texts) + one_function(name, arguments, calls)


def _from(place: Mapping[str, int], expression: str) -> str:
    """The expression with values that earlier parts have put down read from there."""
    return _VALUE.sub(lambda found: f"w[{place[found[0]]}]" if found[0] in place else found[0], expression)


def one_function(name: str, arguments: Sequence[str], lines: Sequence[str]) -> str:
    """C text of `static void name(arguments)`, one statement in a line."""
    body = "\n  ".join(lines)
    return f"static void {name}({', '.join(arguments)}) {{\n  {body}\n}}\n"
