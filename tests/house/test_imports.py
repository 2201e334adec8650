"""One room per idea: who may import whom, read from the code's own imports; and the rules that code can be held to."""

import ast
import re
from pathlib import Path

import pytest

PROJECT = Path(__file__).resolve().parents[2]
ORDER = (
    "files", "recording", "symbolic", "codegen", "estimator", "plant", "control", "calibration", "refinement", "cases",
    "mpc_demo", "figures", "commands",
)  # fmt: skip
"""Rooms from the ground up: a room imports from rooms below it only."""
NOT_BELOW = {
    "recording": {"files"},
    "symbolic": {"files"},
    "estimator": {"files", "recording", "symbolic", "codegen"},
    "plant": {"files", "recording", "symbolic.signals", "symbolic.soil"},
    "control": {"files", "recording", "symbolic", "codegen", "estimator"},
    "refinement": {"files", "recording", "symbolic", "codegen", "estimator"},
    "cases": {"files", "recording", "symbolic", "codegen", "estimator", "calibration", "refinement"},
}
"""Rooms that may import less than all below them: the plant shares no equation with the model, and neither what estimates nor
what controls knows it. Control stands on the estimator: a driver carries its filter, a folder of C holds both."""
ROOMS = {room: {room, *NOT_BELOW.get(room, ORDER[:i])} for i, room in enumerate(ORDER)}
OUTSIDE = {"files": {"numpy"}, "symbolic": {"casadi", "numpy"}, "recording": {"numpy", "pandas"}}
"""Rooms that may use these libraries only."""
FILES = sorted(path for room in ROOMS for path in (PROJECT / room).rglob("*.py"))
LARGEST = {"mpc_demo": 2000}
"""Lines of Python that a room may hold, 4000 where nothing is said."""


DOTTED = re.compile(r"softsoil(\.[a-z_]\w*)+\Z")


def imported(path: Path) -> set[str]:
    """Modules that a file imports, `import_module("...")` with a literal included."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: expected absolute imports"
            assert all(alias.name != "*" for alias in node.names), f"{path}: expected no star import"
            found |= {node.module} if node.module.count(".") > 1 else {f"{node.module}.{a.name}" for a in node.names}
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and DOTTED.match(node.value):
            found.add(node.value)
    return {name.removeprefix("softsoil.") for name in found}


def allowed(module: str, rules: set[str]) -> bool:
    return any(module == rule or module.startswith(f"{rule}.") for rule in rules)


@pytest.mark.parametrize("room", sorted(ROOMS))
def test_no_room_outgrows_its_idea(room):
    lines = sum(len(path.read_text(encoding="utf-8").splitlines()) for path in (PROJECT / room).rglob("*.py"))
    assert lines <= LARGEST.get(room, 4000)


@pytest.mark.parametrize("room", sorted(ROOMS))
def test_the_package_holds_a_link_to_every_room(room):
    assert (PROJECT / "softsoil" / room).resolve() == PROJECT / room
    assert not (PROJECT / room).is_symlink()


def test_there_is_code_in_every_room():
    assert {path.relative_to(PROJECT).parts[0] for path in FILES} == set(ROOMS)


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(PROJECT)))
def test_imports_point_down(path):
    room = path.relative_to(PROJECT).parts[0]
    for module in imported(path):
        if module.split(".")[0] in ROOMS:
            assert allowed(module, ROOMS[room]), f"{room} may not import {module}"


@pytest.mark.parametrize("room", sorted(OUTSIDE))
def test_libraries_of_the_lower_rooms(room):
    import sys

    for path in (PROJECT / room).rglob("*.py"):
        for module in imported(path):
            top = module.split(".")[0]
            assert top in OUTSIDE[room] or top in ROOMS or top in sys.stdlib_module_names, (
                f"{path.name} imports {module}"
            )


def _reads_truth(path: Path) -> list[int]:
    lines = []
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        named = isinstance(node, ast.Attribute) and node.attr == "truth"
        spelled = isinstance(node, ast.Constant) and isinstance(node.value, str) and node.value.startswith("true_")
        if named or spelled or (isinstance(node, ast.Name) and node.id == "TRUTH_PREFIX"):
            lines.append(node.lineno)
    return lines


@pytest.mark.parametrize(
    "path",
    [p for p in FILES if p.parent.name in ("estimator", "refinement", "calibration", "control")],
    ids=lambda path: path.stem,
)
def test_nothing_that_estimates_reads_the_truth(path):
    assert _reads_truth(path) == []


def test_the_truth_test_can_fail(tmp_path):
    bad = tmp_path / "bad.py"
    bad.write_text("def f(log):\n    return log.truth['true_fy_fl']\n", encoding="utf-8")
    assert _reads_truth(bad) == [2, 2]


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(PROJECT)))
def test_files_stay_readable_and_data_stays_data(path):
    text = path.read_text(encoding="utf-8")
    assert len(text.splitlines()) <= 350
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
            assert node.func.id not in ("eval", "exec"), f"line {node.lineno}"
        if isinstance(node, ast.ExceptHandler):
            assert node.type is not None, f"line {node.lineno}: expected a named exception"
        if isinstance(node, ast.keyword) and node.arg == "shell":
            assert isinstance(node.value, ast.Constant) and node.value.value is False
    assert not {"pickle", "marshal", "shelve"} & {module.split(".")[0] for module in imported(path)}
