"""The tracing's rules: each with a unit, a meaning and a command that prints its evidence; and the caches that it owns."""

import ast
from dataclasses import FrozenInstanceError
from pathlib import Path

import pytest

from drives import MULTI_LOG, PROJECT, reference_vehicle
from softsoil.declaration.model_file import Declaration
from softsoil.recording.read import read_drive
from softsoil.refinement.rules import EVIDENCE, RULES
from softsoil.symbolic.soil import CLAY
from softsoil.windows import shooting
from softsoil.windows.shooting import Shooting, shooting_drive, shootings


def test_every_rule_says_what_it_is_and_where_its_evidence_is():
    for rule in RULES.table():
        assert rule.meaning and set(rule.evidence) <= set(EVIDENCE), rule.name
    with pytest.raises(FrozenInstanceError):
        RULES.least_gain = 0.1  # type: ignore[misc]


def test_the_commands_of_the_evidence_are_there():
    for command in EVIDENCE.values():
        words = command.split()
        if words[0] == "python":
            path = words[1] if words[1] != "-m" else words[2].replace(".", "/") + ".py"
            assert (PROJECT / path).is_file(), command


def mutable(path: Path) -> list[str]:
    """Names of dictionaries, lists and sets that a module creates empty: what fills up while it runs."""
    found = []
    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        value = getattr(node, "value", None) if isinstance(node, ast.Assign | ast.AnnAssign) else None
        empty = (isinstance(value, ast.Dict) and not value.keys) or (isinstance(value, ast.List) and not value.elts)
        if empty or (isinstance(value, ast.Call) and getattr(value.func, "id", "") in ("dict", "list", "set") and not value.args):
            found.append(ast.unparse(node))
    return found


KEEPERS = ("symbolic", "codegen", "windows", "estimator", "refinement", "recording", "importing", "calibration", "cases")


@pytest.mark.parametrize("room", KEEPERS)
def test_no_module_keeps_a_cache_without_a_bound(room, tmp_path):
    assert [hit for path in (PROJECT / room).rglob("*.py") for hit in mutable(path)] == []
    bad = tmp_path / "bad.py"
    bad.write_text("_FUNCTIONS: dict[str, int] = {}\n", encoding="utf-8")
    assert mutable(bad)


def test_windows_of_one_model_share_what_is_compiled(monkeypatch):
    model = Declaration(reference_vehicle(), CLAY).build()
    drive = shooting_drive(read_drive(MULTI_LOG), model, 1.0)
    one, two = shootings(model, [drive, drive], 0.5)
    monkeypatch.setattr(shooting.Compiled, "of", pytest.fail)
    assert one.compiled is two.compiled is one.ahead(1.0).compiled
    assert one.ahead(1.0).steps == round(1.0 / drive.dt) and isinstance(two, Shooting)
