"""A type error in a room fails `make test`: mypy follows the links of the package to the rooms."""

import re
import shutil
import subprocess
import sys

import pytest

from drives import PROJECT

SEEDED = '''"""A module with a type error."""


def length(words: list[str]) -> str:
    """Number of words."""
    return len(words)
'''


@pytest.fixture
def copy(tmp_path):
    """The package with two of its rooms, its configuration and links as they are."""
    shutil.copy(PROJECT / "pyproject.toml", tmp_path)
    shutil.copytree(PROJECT / "softsoil", tmp_path / "softsoil", symlinks=True, ignore=shutil.ignore_patterns("__pycache__"))
    for room in ("files", "recording"):
        shutil.copytree(PROJECT / room, tmp_path / room)
    for link in (tmp_path / "softsoil").iterdir():
        if link.is_symlink() and not link.exists():
            link.unlink()
    return tmp_path


def mypy(folder):
    # As `make test` calls it, in a folder of its own: without arguments, by the configuration alone.
    return subprocess.run([sys.executable, "-m", "mypy"], cwd=folder, capture_output=True, text=True, check=False)


@pytest.mark.slow
def test_a_seeded_type_error_fails(copy):
    clean = mypy(copy)
    assert clean.returncode == 0, clean.stdout
    (copy / "files" / "seeded.py").write_text(SEEDED, encoding="utf-8")
    found = mypy(copy)
    assert found.returncode == 1
    assert re.search(r"files/seeded\.py:6: error: Incompatible return value type", found.stdout)


def test_make_test_runs_mypy_and_all_tests():
    """Two halves side by side: the folders of FIRST, and all but those."""
    text = (PROJECT / "Makefile").read_text(encoding="utf-8")
    recipe = re.search(r"^test:.*\n((?:\t.*\n)+)", text, re.M)
    first = re.search(r"^FIRST := \$\(addprefix tests/,(.*)\)$", text, re.M)
    assert recipe is not None and first is not None and "not slow" not in text
    assert re.search(r"^\t\$\(BIN\)/mypy$", recipe[1], re.M) and re.search(r"-j2 test-first test-rest$", recipe[1], re.M)
    assert all((PROJECT / "tests" / folder).is_dir() for folder in first[1].split())
    assert "pytest $(FIRST)\n" in text and "pytest tests $(addprefix --ignore=,$(FIRST))\n" in text
