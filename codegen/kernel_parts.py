"""A long straight line of C cut into functions: compilers need time that grows with more than the length of one.

What a later part reads is put down in an array of vectors or of plain numbers, in places that are used again; with thousands of
values for sixteen registers it would lie in memory anyway.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

PART = 1200
"""Statements in a part: a half to a seventh of the compiler's time, at most two per cent more at run time; much shorter ones cost
more of either."""
_VALUE = re.compile(r"\bt\d+\b")
_KEPT = {"ssv": "w", "double": "d"}
"""Type of a value -> the array that it is put down in."""
_APART = "#ifdef __GNUC__\n__attribute__((noinline))\n#endif\n"


def in_parts(name: str, arguments: Sequence[str], statements: Sequence[str], size: int = PART) -> str:
    """C text of `static void name(arguments)` that runs the statements in parts of `size`.

    arguments: declarations of pointers, "const ssv *a0"; statements: "const ssv t<number> = ...;" or "const double t<number> =
    ...;", read by later ones, or "r<output>[...] = ...;". What fits in one part is one function.
    """
    if len(statements) <= size:
        return one_function(name, arguments, [unread([argument.rpartition("*")[2] for argument in arguments]), *statements])
    parts = [statements[i : i + size] for i in range(0, len(statements), size)]
    last = {value: k for k, part in enumerate(parts) for line in part for value in _VALUE.findall(line)}
    place: dict[str, str] = {}
    free: dict[str, list[str]] = {kind: [] for kind in _KEPT}
    count, bodies = dict.fromkeys(_KEPT, 0), []
    for k, part in enumerate(parts):
        lines: list[str] = []
        kept: dict[str, str] = {}
        for line in part:
            to, _, what = line.partition(" = ")
            lines.append(f"{to} = {_from(place, what)}")
            *_, kind, value = ("", "", *to.split())
            if last.get(value, k) > k:
                if not free[kind]:
                    free[kind], count[kind] = [f"{_KEPT[kind]}[{count[kind]}]"], count[kind] + 1
                kept[value] = free[kind].pop()
                lines.append(f"{kept[value]} = {value};")
        bodies.append(lines)
        for value in [value for value in place if last[value] == k]:
            at = place.pop(value)
            free["ssv" if at[0] == _KEPT["ssv"] else "double"].append(at)
        place |= kept
    rooms = {kind: at for kind, at in _KEPT.items() if count[kind]}
    pointers = [*arguments, *(f"{kind} *{at}" for kind, at in rooms.items())]
    shared = [pointer.replace("*", "*__restrict ") for pointer in pointers]  # C99's word is none of C++
    names = [pointer.rpartition("*")[2] for pointer in pointers]
    unused = unread(names)
    texts = [_APART + one_function(f"{name}_{k}", shared, [unused, *lines]) for k, lines in enumerate(bodies)]
    calls = [f"{kind} {at}[{count[kind]}];" for kind, at in rooms.items()]
    calls += [f"{name}_{k}({', '.join(names)});" for k in range(len(parts))]
    return "".join(texts) + one_function(name, arguments, calls)


def unread(names: Sequence[str]) -> str:
    """C that says of each pointer that it may not be read."""
    return " ".join(f"(void){name};" for name in names)


def _from(place: Mapping[str, str], expression: str) -> str:
    """The expression with values that earlier parts have put down read from there."""
    return _VALUE.sub(lambda found: place.get(found[0], found[0]), expression)


def one_function(name: str, arguments: Sequence[str], lines: Sequence[str]) -> str:
    """C text of `static void name(arguments)`, one statement in a line."""
    body = "\n  ".join(lines)
    return f"static void {name}({', '.join(arguments)}) {{\n  {body}\n}}\n"
