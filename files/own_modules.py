"""Modules of a package that a user adds to: those of the package, and those of folders that an environment variable names."""

from __future__ import annotations

import os
import pkgutil
from collections.abc import Callable, Iterable
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import TypeVar

LARGE = 2**20
"""Bytes of a file beyond which it is not read to be compared."""
Made = TypeVar("Made")
EFFECTS, LAWS = "SOFTSOIL_EFFECTS", "SOFTSOIL_LAWS"
"""Environment variables: folders of effects and of force laws, one file each, separated as in PATH."""


def own_folders(variable: str) -> list[str]:
    """The folders that an environment variable names, in full."""
    return [str(Path(folder).resolve()) for folder in os.environ.get(variable, "").split(os.pathsep) if folder]


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


def own_file(name: str, variable: str) -> Path | None:
    """The user's file, or folder, of the module `name`; None for one of the package."""
    places = (Path(folder) / part for folder in own_folders(variable) for part in (f"{name}.py", f"{name}/__init__.py"))
    return next((path for path in places if path.is_file()), None)


def made(package: str, name: str, variable: str, make: Callable[[ModuleType], Made]) -> Made:
    """What `make` makes of the module `name` of a package. Raises ValueError naming a user's file that cannot be imported, or of
    which nothing can be made, and why."""
    try:
        return make(import_module(f"{package}.{name}"))
    except Exception as error:
        own = own_file(name, variable)
        if own is None or str(error).startswith(str(own)):
            raise
        raise ValueError(f"{own}: expected a file that can be used, found {type(error).__name__}: {error}") from error


def own_code() -> bytes:
    """The user's files of both kinds, as bytes, with all that is beside and below them but hidden files: what is kept of a model
    is that of these files. Of large ones size and time count."""
    folders = [Path(folder) for variable in (EFFECTS, LAWS) for folder in own_folders(variable)]
    paths = [path for folder in folders for path in sorted(folder.rglob("*")) if _counts(path.relative_to(folder), path)]
    return b"\0".join(part for path in paths for part in (str(path).encode(), _content(path)))


def _counts(inside: Path, path: Path) -> bool:
    return path.is_file() and path.suffix != ".pyc" and not any(part.startswith(".") for part in inside.parts)


def _content(path: Path) -> bytes:
    about = path.stat()
    return path.read_bytes() if about.st_size <= LARGE else f"{about.st_size} {about.st_mtime_ns}".encode()
