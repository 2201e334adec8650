"""TOML files that users write: read (with or without a byte-order mark) or refused naming the file; numbers and text as TOML."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any


def read_toml(path: Path, what: str) -> dict[str, Any]:
    """The table in a TOML file (with or without a byte-order mark); ValueError where it is none, beginning with `what` it was
    to hold where there is no file.
    """
    if not path.is_file():
        raise ValueError(f"{what}: expected a TOML file, found {'a folder' if path.is_dir() else 'none'} at {path}")
    try:
        return tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ValueError(f"{path}: expected TOML, found: {error}") from None
    except OSError as error:
        raise ValueError(f"{path}: expected a TOML file that can be read, found: {error.strerror}") from None


def table_inside(table: Mapping[str, Any], name: str, keys: Collection[str], where: str) -> dict[str, Any]:
    """The table called `name` inside another one, which is that table itself where it has none of that name.

    keys: of the table called `name`. Raises ValueError, naming `where`, for one of them beside it, which would not be read.
    """
    inside = table.get(name, table)
    if not isinstance(inside, dict):
        raise ValueError(f"{where}: expected a table [{name}], found {name} = {inside!r}")
    beside = [key for key in table if key in keys and key != "name"] if name in table else []
    if beside:
        raise ValueError(f"{where}: expected {beside[0]} inside [{name}], as {name}.{beside[0]}; found it beside")
    return inside


def finite(value: Any, where: str) -> float:
    """A finite number of a TOML table; ValueError naming `where` for anything else (value)."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise ValueError(f"{where}: expected a finite number, found {value!r}")
    return float(value)


def number_table(
    table: Mapping[str, Any], name: str, where: str, bounds: Mapping[str, tuple[float, float]] | None = None
) -> dict[str, float]:
    """The table called `name` inside another one, all numbers, empty where there is none.

    bounds: of each key that may be there, default any. Raises ValueError naming `where`, key, what was expected and found.
    """
    values = table.get(name, {})
    if not isinstance(values, dict):
        raise ValueError(f"{where}: expected a table [{name}] of numbers, found {values!r}")
    found = {key: finite(value, f"{where}: {name}.{key}".replace("effects: ", "effects.")) for key, value in values.items()}
    if bounds is None:
        return found
    for key, value in found.items():
        if key not in bounds:
            raise ValueError(f"{where}: {name}: expected keys {', '.join(bounds)}; found {key!r}")
        if not bounds[key][0] <= value <= bounds[key][1]:
            raise ValueError(f"{where}: {name}.{key}: expected {bounds[key][0]:g} to {bounds[key][1]:g}, found {value:g}")
    return found


def toml_number(value: float) -> str:
    """A number (value) as TOML text that reads back the same."""
    return repr(float(value))


def toml_text(value: str) -> str:
    """A string as TOML text, quoted and escaped."""
    return f'"{"".join(map(_escaped, value))}"'


def _escaped(c: str) -> str:
    if c.isprintable() and c not in '"\\':
        return c
    return f"\\u{ord(c):04x}" if ord(c) <= 0xFFFF else f"\\U{ord(c):08x}"
