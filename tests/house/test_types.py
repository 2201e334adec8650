"""A type error in a room, and an import of what is not there, fail `make test`: mypy follows the links of the package."""

import re
import shutil
import subprocess
import sys

import pytest

from benchmarks.judges.house import ROOMS
from drives import PROJECT

SEEDED = '''"""A module with a type error."""


def length(words: list[str]) -> str:
    """Number of words."""
    return len(words)
'''
MISSING = """from softsoil.files.toml_file import nothing_of_the_kind
from softsoil.files.gone import anything
"""


@pytest.mark.slow
def test_what_is_seeded_fails(tmp_path):
    shutil.copy(PROJECT / "pyproject.toml", tmp_path)
    for folder in ("softsoil", "benchmarks", *ROOMS):
        shutil.copytree(PROJECT / folder, tmp_path / folder, symlinks=True, ignore=shutil.ignore_patterns("__pycache__"))
    if (PROJECT / ".mypy_cache").is_dir():  # what mypy knows of the rest
        shutil.copytree(PROJECT / ".mypy_cache", tmp_path / ".mypy_cache")
    (tmp_path / "files" / "seeded.py").write_text(SEEDED, encoding="utf-8")
    (tmp_path / "benchmarks" / "seeded.py").write_text(MISSING, encoding="utf-8")
    # As `make test` calls it, in a folder of its own: without arguments, by the configuration alone.
    done = subprocess.run([sys.executable, "-m", "mypy"], cwd=tmp_path, capture_output=True, text=True, check=False)
    errors = [line for line in done.stdout.splitlines() if ": error:" in line]
    assert done.returncode == 1 and len(errors) == 3, done.stdout
    assert re.search(r"files/seeded\.py:6: error: Incompatible return value type", done.stdout)
    assert re.search(r"benchmarks/seeded\.py:1: error: .* has no attribute \"nothing_of_the_kind\"", done.stdout)
    assert re.search(r"benchmarks/seeded\.py:2: error: Cannot find implementation", done.stdout)


def test_make_test_runs_mypy_and_all_tests():
    """Types and two halves of the tests side by side: the folders of FIRST, and all but those; studies have a command."""
    text = (PROJECT / "Makefile").read_text(encoding="utf-8")
    recipe, types = (re.search(rf"^{name}:.*\n((?:\t.*\n)+)", text, re.M) for name in ("test", "test-types"))
    first = re.search(r"^FIRST := \$\(addprefix tests/,(.*)\)$", text, re.M)
    assert recipe is not None and types is not None and first is not None and "not slow" not in text
    assert types[1] == "\t$(BIN)/mypy\n" and re.search(r"-j3 test-types test-first test-rest$", recipe[1], re.M)
    assert all((PROJECT / "tests" / folder).is_dir() for folder in first[1].split())
    halves = ("$(FIRST)\n", "tests $(addprefix --ignore=,$(FIRST))\n")
    assert all(f'pytest -m "not study" {half}' in text for half in halves) and "pytest -m study tests\n" in text
