"""CasADi functions to self-contained C."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import casadi as ca

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,62}\Z")


def check_c_name(name: str) -> str:
    """`name`, if it may stand in C and in a path: letters, digits and _, a letter first. ValueError otherwise."""
    if not _NAME.match(name):
        raise ValueError(f"expected a name of letters, digits and _ that starts with a letter, found {name!r}")
    return name


def write_c(
    functions: Sequence[ca.Function], directory: str | Path, name: str = "model", header: bool = True
) -> list[Path]:
    """Write `functions` as one C file (and its header) into `directory`; the bytes are the same on every run.

    Returns the paths written. Raises ValueError for no functions, a name that is no C identifier, or a directory that
    is a file.
    """
    if not functions:
        raise ValueError("write_c: expected at least one function, found none")
    for function in functions:
        check_c_name(function.name())
    check_c_name(name)
    folder = Path(directory)
    if folder.exists() and not folder.is_dir():
        raise ValueError(f"write_c: expected a folder, found a file at {folder}")
    folder.mkdir(parents=True, exist_ok=True)
    generator = ca.CodeGenerator(f"{name}.c", {"with_header": header})
    for function in functions:
        generator.add(function)
    generator.generate(f"{folder}/")
    return [folder / f"{name}.c", *([folder / f"{name}.h"] if header else [])]
