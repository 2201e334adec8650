"""One room per idea: who may import whom, read from the code's own imports; and the rules that code can be held to."""

import ast
import sys
from pathlib import Path

import pytest

import benchmarks.house
from benchmarks.judges.house import FILES, PROJECT, ROOMS, allowed, circles, imported, lines_of, room_of

OUTSIDE = {"files": {"numpy"}, "symbolic": {"casadi", "numpy"}, "recording": {"numpy", "pandas", "scipy"},
           "checking": {"numpy", "pandas", "scipy"}, "importing": {"numpy", "pandas", "rosbags", "pymap3d", "scipy"}}  # fmt: skip
"""Rooms that may use these libraries only."""
LARGEST = {"checking": 2500, "mpc_demo": 2000, "recording": 2500, "symbolic": 2500}
"""Lines of Python that a room may hold without its catalogues, 4000 where nothing is said."""


@pytest.mark.parametrize("room", sorted(ROOMS))
def test_no_room_outgrows_its_idea(room):
    held, most = lines_of(room), LARGEST.get(room, 4000)
    assert held <= most, f"room {room}: {held} lines of Python, at most {most} (LARGEST in this file)"


@pytest.mark.parametrize("room", sorted(ROOMS))
def test_the_package_holds_a_link_to_every_room(room):
    assert (PROJECT / "softsoil" / room).resolve() == PROJECT / room
    assert not (PROJECT / room).is_symlink()


def test_there_is_code_in_every_room():
    assert {path.relative_to(PROJECT).parts[0] for path in FILES} == set(ROOMS)


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(PROJECT)))
def test_imports_point_down(path):
    for module in imported(path):
        if module.split(".")[0] in ROOMS:
            assert allowed(module, ROOMS[room_of(path)]), f"{room_of(path)} may not import {module}"


def test_an_import_against_the_arrows_is_seen(tmp_path):
    bad = tmp_path / "bad.py"
    bad.write_text("from softsoil.plant.world import Plant\n", encoding="utf-8")
    (module,) = imported(bad)
    assert module == "plant.world" and not allowed(module, ROOMS["estimator"]) and allowed(module, ROOMS["mpc_demo"])
    bad.write_text("from . import world\n", encoding="utf-8")
    with pytest.raises(ValueError, match="expected absolute imports"):
        imported(bad)


def test_the_drawing_has_no_fault(capsys):
    assert benchmarks.house.main() == 0
    said = capsys.readouterr().out
    assert all(room in said for room in ROOMS) and "no circle" in said


def test_circles_are_seen():
    assert circles({"a": {"b"}, "b": {"c"}, "c": {"a"}, "d": {"a"}}) == [("a", "b", "c")]
    assert circles({"a": {"b"}, "b": {"c"}, "c": set()}) == []


@pytest.mark.parametrize("room", sorted(OUTSIDE))
def test_libraries_of_the_lower_rooms(room):
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
    [p for p in FILES if p.parent.name in ("estimator", "mapping", "refinement", "identification", "calibration", "control")],
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
