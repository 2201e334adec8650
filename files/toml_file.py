"""TOML files that users write: read, with or without a byte-order mark, or refused naming the file."""

from __future__ import annotations

import math
import tomllib
from pathlib import Path
from typing import Any


def read_toml(path: Path, what: str) -> dict[str, Any]:
    """The table in a TOML file that holds `what`; ValueError naming the file where there is none, or no TOML in it."""
    if not path.is_file():
        raise ValueError(f"{what}: expected a TOML file, found {'a folder' if path.is_dir() else 'none'} at {path}")
    try:
        return tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ValueError(f"{path}: expected TOML, found: {error}") from None


def finite_number(value: Any, where: str) -> float:
    """The number `value` of a TOML file; ValueError naming `where` it stands for text, a truth value, nan and inf."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise ValueError(f"{where}: expected a finite number, found {value!r}")
    return float(value)
