"""Modules of a package that a user adds to: those of the package, and those of folders that an environment variable names."""

from __future__ import annotations

import os
import pkgutil
from collections.abc import Iterable
from importlib import import_module
from pathlib import Path
from types import ModuleType

EFFECTS, LAWS = "SOFTSOIL_EFFECTS", "SOFTSOIL_LAWS"
"""Environment variables: folders of effects and of force laws, one file each, separated as in PATH."""


def own_folders(variable: str) -> list[str]:
    """The folders that an environment variable names."""
    return [folder for folder in os.environ.get(variable, "").split(os.pathsep) if folder]


def module_names(paths: Iterable[str], variable: str) -> tuple[str, ...]:
    """Names of the modules in `paths` (a package's) and in the user's folders, alphabetically; a leading underscore makes none.

    Raises ValueError for a folder that is not there, and for a name that two files have.
    """
    found: dict[str, str] = {}
    for folder in dict.fromkeys([*paths, *own_folders(variable)]):
        if not Path(folder).is_dir():
            raise ValueError(f"{variable}: expected a folder, found none at {folder}")
        for module in pkgutil.iter_modules([folder]):
            if module.name.startswith("_"):
                continue
            if module.name in found:
                words = f"expected names that no other file has, found {module.name}.py in {folder} and in {found[module.name]}"
                raise ValueError(f"{variable}: {words}")
            found[module.name] = folder
    return tuple(sorted(found))


def loaded(package: str, name: str, variable: str) -> ModuleType:
    """The module `name` of a package. Raises ValueError naming a user's file that cannot be imported, and why."""
    try:
        return import_module(f"{package}.{name}")
    except Exception as error:
        own = [path for folder in own_folders(variable) if (path := Path(folder) / f"{name}.py").is_file()]
        if not own:
            raise
        raise ValueError(f"{own[0]}: expected a file that can be imported, found {type(error).__name__}: {error}") from error


def own_code() -> bytes:
    """The user's files of both kinds, as bytes: what is kept of a model is that of these files."""
    folders = [Path(folder) for variable in (EFFECTS, LAWS) for folder in own_folders(variable)]
    paths = [path for folder in folders for path in sorted(folder.glob("*.py"))]
    return b"\0".join(part for path in paths for part in (path.name.encode(), path.read_bytes()))
