"""docs/tutorials/add-an-effect.md, followed to the letter in a copy of the project."""

import os
import re
import shutil
import subprocess
import sys

import pytest

from drives import PROJECT

PAGE = PROJECT / "docs" / "tutorials" / "add-an-effect.md"
ROOMS = sorted(link.name for link in (PROJECT / "softsoil").iterdir() if link.is_symlink())
HEAVY = shutil.ignore_patterns("__pycache__", "*.parquet", "*.csv.gz", "clibrary_corpus")


@pytest.fixture(scope="module")
def copy(tmp_path_factory):
    """The project without its logs, with the page's first block where the page says."""
    folder = tmp_path_factory.mktemp("project")
    for name in (*ROOMS, "tests"):
        shutil.copytree(PROJECT / name, folder / name, ignore=HEAVY)
    shutil.copytree(PROJECT / "softsoil", folder / "softsoil", symlinks=True, ignore=HEAVY)
    shutil.copy(PROJECT / "pyproject.toml", folder)
    text = PAGE.read_text(encoding="utf-8")
    name, room, code = re.search(r"`(\w+\.py)` in `([\w/]+)/`:\n\n```python\n(.*?)```", text, re.S).groups()
    assert not (PROJECT / room / name).exists()
    (folder / room / name).write_text(code, encoding="utf-8")
    return folder


def run(folder, *words):
    env = {**os.environ, "PYTHONPATH": f"{folder}{os.pathsep}{folder / 'tests'}"}
    return subprocess.run([sys.executable, *words], cwd=folder, env=env, capture_output=True, text=True, check=False)


@pytest.mark.slow
def test_it_is_found_and_keeps_the_contract(copy):
    words = re.search(r"^    python (-m pytest .*) -k \"(.*)\"$", PAGE.read_text(encoding="utf-8"), re.M)
    done = run(copy, *words[1].split(), "-k", words[2])
    assert done.returncode == 0, done.stdout + done.stderr
    listed = run(copy, *words[1].split(), "-k", words[2], "--collect-only")
    assert "[air_drag]" in listed.stdout and "any_order_of_two" in listed.stdout


@pytest.mark.study
def test_it_is_declared_and_traced(copy):
    code = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.S)[1]
    (copy / "traced.py").write_text(code, encoding="utf-8")
    done = run(copy, "traced.py")
    assert done.returncode == 0, done.stderr
    name, value = re.fullmatch(r"(\w+) \{'drag': ([\d.]+)\}\n", done.stdout).groups()
    assert name == "air_drag" and float(value) == pytest.approx(5.0, rel=0.15)
