"""An effect's name means something in its own file only: no code elsewhere spells one out."""

import ast
from dataclasses import fields
from pathlib import Path

import pytest

from drives import PROJECT, reference_vehicle
from softsoil.plant.effects import Effects
from softsoil.symbolic.catalogue import catalogue

ROOMS = sorted(link.name for link in (PROJECT / "softsoil").iterdir() if link.is_symlink())
FILES = sorted(path for room in ROOMS for path in (PROJECT / room).rglob("*.py"))
NAMES = frozenset(catalogue(reference_vehicle()))
WORLD = frozenset(field.name for field in fields(Effects))
"""Switches of the simulated world, which has words of its own; some are also those of the catalogue."""


def spelled(path: Path, room: str) -> list[str]:
    """Names of effects among the string literals of a file."""
    own = NAMES - (WORLD if room == "plant" else set())
    tree = ast.parse(path.read_text(encoding="utf-8"))
    return [node.value for node in ast.walk(tree) if isinstance(node, ast.Constant) and node.value in own]


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(PROJECT)))
def test_no_effect_is_named_outside_its_file(path):
    inside = path.parent.name == "effects" and path.parent.parent.name == "symbolic"
    found = set(spelled(path, path.relative_to(PROJECT).parts[0]))
    assert found <= ({path.stem} | parameters(path.stem) if inside else set())


def parameters(name: str) -> set[str]:
    """Parameters of an effect, one of which may be called as another effect is."""
    effect = catalogue(reference_vehicle()).get(name)
    return set(effect.parameters.names) if effect else set()


def test_the_test_can_fail(tmp_path):
    bad = tmp_path / "bad.py"
    bad.write_text('LEAST = {"multipass": {"kappa": 1.0}, "payload": 3}\n', encoding="utf-8")
    assert spelled(bad, "control") == ["multipass", "payload"] and spelled(bad, "plant") == []
