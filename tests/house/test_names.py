"""Every name that a file imports from the project stands there: files that no test runs, benchmarks and examples, too."""

import ast
from functools import cache
from pathlib import Path

import pytest

from drives import PROJECT

OWN = ("softsoil", "benchmarks")
FILES = sorted(
    path
    for folder in PROJECT.iterdir()
    if folder.is_dir() and not folder.is_symlink() and not folder.name.startswith(".") and folder.name not in ("runs", "build")
    for path in folder.rglob("*.py")
    if not path.is_relative_to(PROJECT / "softsoil") or path.parent == PROJECT / "softsoil"
)


def place(module: str) -> Path | None:
    """File or folder of a module of the project, None where there is none."""
    parts = module.split(".")
    path = PROJECT.joinpath(*(parts[1:] if parts[0] == "softsoil" and len(parts) > 1 else parts))
    return path.with_suffix(".py") if path.with_suffix(".py").is_file() else path if path.is_dir() else None


@cache
def names(path: Path) -> frozenset[str]:
    """Names at the top level of a file; of a folder, its modules and what its __init__ has."""
    if path.is_dir():
        own = names(path / "__init__.py") if (path / "__init__.py").is_file() else frozenset()
        return own | {entry.stem for entry in path.iterdir()}
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        match node:
            case ast.FunctionDef(name=name) | ast.ClassDef(name=name):
                found.add(name)
            case ast.Name(id=name, ctx=ast.Store()):
                found.add(name)
            case ast.Import(names=aliases) | ast.ImportFrom(names=aliases):
                found |= {(alias.asname or alias.name).split(".")[0] for alias in aliases}
    return frozenset(found)


def missing(path: Path) -> list[str]:
    """What a file imports from the project and what is not there."""
    found = []
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module and node.module.split(".")[0] in OWN and "." in node.module:
            target = place(node.module)
            if target is None:
                found.append(node.module)
            else:
                found += [f"{node.module}.{a.name}" for a in node.names if a.name not in names(target)]
    return found


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(PROJECT)))
def test_imported_names_exist(path):
    assert missing(path) == []


def test_a_missing_name_is_seen(tmp_path):
    file = tmp_path / "bad.py"
    file.write_text("from softsoil.files.toml_file import nothing_of_the_kind\nfrom benchmarks.gone import x\n", encoding="utf-8")
    assert missing(file) == ["softsoil.files.toml_file.nothing_of_the_kind", "benchmarks.gone"]
