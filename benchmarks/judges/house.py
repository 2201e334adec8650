"""The rooms of the house and the imports between them, read from the code itself; and the rules that imports are held to."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator, Mapping, Set
from pathlib import Path
from types import MappingProxyType

PROJECT = Path(__file__).resolve().parents[2]
ORDER = (
    "files", "recording", "checking", "importing", "symbolic", "declaration", "codegen", "windows", "estimator", "plant",
    "control", "mapping", "calibration", "refinement", "identification", "cases", "mpc_demo", "figures", "commands",
)  # fmt: skip
"""Rooms from the ground up: a room imports from rooms below it only."""
NOT_BELOW: Mapping[str, Set[str]] = MappingProxyType(
    {
        "recording": {"files"},
        "checking": {"files", "recording"},
        "symbolic": {"files"},
        "declaration": {"files", "symbolic"},
        "windows": {"files", "recording", "symbolic", "declaration", "codegen"},
        "estimator": {"files", "recording", "checking", "symbolic", "declaration", "codegen", "windows"},
        "plant": {"files", "recording", "symbolic.signals", "symbolic.soil"},
        "control": {"files", "recording", "symbolic", "declaration", "codegen", "windows", "estimator"},
        "mapping": {"files", "recording", "checking", "importing", "symbolic", "declaration", "codegen", "windows", "estimator"},
        "refinement": {"files", "recording", "checking", "symbolic", "declaration", "codegen", "windows", "estimator"},
        "identification": {
            "files", "recording", "checking", "symbolic", "declaration", "codegen", "windows", "estimator", "refinement",
        },
        "cases": {
            "files", "recording", "checking", "symbolic", "declaration", "codegen", "windows", "estimator", "calibration",
            "refinement",
        },
    }
)
"""Rooms that may import less than all below them: the plant shares no equation with the model, and neither what estimates nor
what controls knows it. Control stands on the estimator: a driver carries its filter, a folder of C holds both."""
ROOMS: Mapping[str, Set[str]] = MappingProxyType(
    {room: {room, *NOT_BELOW.get(room, ORDER[:i])} for i, room in enumerate(ORDER)}
)
"""Room -> rooms and modules that it may import."""
FILES = tuple(sorted(path for room in ROOMS for path in (PROJECT / room).rglob("*.py")))
_DOTTED = re.compile(r"softsoil(\.[a-z_]\w*)+\Z")


def imported(path: Path, literal: bool = True) -> set[str]:
    """Modules that a file imports; rooms without the package's name.

    literal: also those whose dotted name stands in a string, which are loaded by name (as the laws are) when asked for.
    Raises ValueError for a relative or a star import.
    """
    found: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            if node.level or node.module is None or any(alias.name == "*" for alias in node.names):
                raise ValueError(f"{path}, line {node.lineno}: expected absolute imports of names, found {ast.unparse(node)}")
            found |= {node.module} if node.module.count(".") > 1 else {f"{node.module}.{a.name}" for a in node.names}
        elif literal and isinstance(node, ast.Constant) and isinstance(node.value, str) and _DOTTED.match(node.value):
            found.add(node.value)
    return {name.removeprefix("softsoil.") for name in found}


def allowed(module: str, rules: Set[str]) -> bool:
    """Whether the rules of a room let it import a module."""
    return any(module == rule or module.startswith(f"{rule}.") for rule in rules)


def room_of(path: Path) -> str:
    """The room that a file stands in."""
    return path.relative_to(PROJECT).parts[0]


CATALOGUES = ("symbolic/effects", "symbolic/laws")
"""Folders of one file per effect or law, which users add to: they count to no room's size."""


def lines_of(room: str) -> int:
    """Lines of Python in a room, less its catalogues."""
    own = (p for p in FILES if room_of(p) == room and not p.relative_to(PROJECT).as_posix().startswith(CATALOGUES))
    return sum(len(path.read_text(encoding="utf-8").splitlines()) for path in own)


def arrows() -> dict[tuple[str, str], int]:
    """(importing room, imported room) -> number of imports, between different rooms."""
    counts: dict[tuple[str, str], int] = {}
    for path in FILES:
        for module in imported(path):
            pair = (room_of(path), module.split(".")[0])
            if pair[1] in ROOMS and pair[0] != pair[1]:
                counts[pair] = counts.get(pair, 0) + 1
    return counts


def upward(counts: Mapping[tuple[str, str], int]) -> list[tuple[str, str]]:
    """Arrows from a room to one above it."""
    return [pair for pair in counts if ORDER.index(pair[0]) < ORDER.index(pair[1])]


def forbidden() -> Iterator[tuple[Path, str]]:
    """(file, module) of imports that the rules of the file's room do not allow."""
    for path in FILES:
        for module in sorted(imported(path)):
            if module.split(".")[0] in ROOMS and not allowed(module, ROOMS[room_of(path)]):
                yield path, module


def circles(edges: Mapping[str, Set[str]]) -> list[tuple[str, ...]]:
    """Groups of nodes that reach each other, of two at least (strongly connected components, Tarjan 1972)."""
    index: dict[str, int] = {}
    low: dict[str, int] = {}
    stack: list[str] = []
    found: list[tuple[str, ...]] = []

    def visit(node: str) -> None:
        index[node] = low[node] = len(index)
        stack.append(node)
        for other in sorted(edges.get(node, ())):
            if other not in index:
                visit(other)
                low[node] = min(low[node], low[other])
            elif other in stack:
                low[node] = min(low[node], index[other])
        if low[node] == index[node]:
            group: list[str] = []
            while not group or group[-1] != node:
                group.append(stack.pop())
            if len(group) > 1:
                found.append(tuple(sorted(group)))

    for node in edges:
        if node not in index:
            visit(node)
    return found


def modules() -> dict[str, set[str]]:
    """Module -> modules of the project that it imports; those loaded by name later make no circle."""
    names = {".".join(path.relative_to(PROJECT).with_suffix("").parts).removesuffix(".__init__"): path for path in FILES}

    def known(module: str) -> str | None:
        return module if module in names else module.rpartition(".")[0] if module.rpartition(".")[0] in names else None

    return {
        name: {found for module in imported(path, literal=False) if (found := known(module)) is not None and found != name}
        for name, path in names.items()
    }
