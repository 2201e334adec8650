"""Column maps: which column of a user's table is which channel, and in which unit."""

from __future__ import annotations

import difflib
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

from softsoil.files.toml_file import read_toml

UNITS: Mapping[str, tuple[str, float]] = MappingProxyType(
    {
        "s": ("s", 1.0), "ms": ("s", 1e-3), "us": ("s", 1e-6), "ns": ("s", 1e-9), "min": ("s", 60.0),
        "m": ("m", 1.0), "mm": ("m", 1e-3), "cm": ("m", 1e-2), "km": ("m", 1e3), "ft": ("m", 0.3048),
        "rad": ("rad", 1.0), "deg": ("rad", math.pi / 180), "mrad": ("rad", 1e-3),
        "m/s": ("m/s", 1.0), "km/h": ("m/s", 1 / 3.6), "mm/s": ("m/s", 1e-3), "mph": ("m/s", 0.44704),
        "rad/s": ("rad/s", 1.0), "deg/s": ("rad/s", math.pi / 180), "rpm": ("rad/s", math.pi / 30),
        "m/s^2": ("m/s^2", 1.0), "m/s2": ("m/s^2", 1.0), "g": ("m/s^2", 9.80665),
        "N": ("N", 1.0), "kN": ("N", 1e3), "N m": ("N m", 1.0), "Nm": ("N m", 1.0),
        "": ("", 1.0), "1": ("", 1.0), "%": ("", 0.01),
    }
)  # fmt: skip
"""Unit name -> (SI unit, factor to it)."""


@dataclass(frozen=True)
class Source:
    """Where a channel comes from: column of the file, factor to SI, offset added after the factor (SI)."""

    column: str
    factor: float = 1.0
    offset: float = 0.0


def load_columns(path: str | Path, units: Mapping[str, str]) -> dict[str, Source]:
    """Column map from TOML: `u = {column = "speed_kmh", unit = "km/h"}` or `u = "speed"`; optional `sign` (1 or -1),
    `factor` (beside the unit's own), `offset` (SI).

    units: channel -> SI unit that it has in the project. Raises ValueError naming file, key, expected and found.
    """
    path = Path(path)
    table = read_toml(path, "column map")
    table = table.get("columns", table)
    return {channel: _source(path, channel, entry, units) for channel, entry in table.items()}


def _source(path: Path, channel: str, entry: object, units: Mapping[str, str]) -> Source:
    if channel not in units:
        near = difflib.get_close_matches(channel, units, n=1)
        hint = f" (did you mean {near[0]!r}?)" if near else ""
        raise ValueError(f"{path}: expected channels of {', '.join(units)}; found {channel!r}{hint}")
    if isinstance(entry, str):
        return Source(entry)
    if not isinstance(entry, dict) or not isinstance(entry.get("column"), str):
        raise ValueError(f'{path}: {channel}: expected {{column = "name", unit = "unit"}}, found {entry!r}')
    for key in entry:
        if key not in ("column", "unit", "sign", "factor", "offset"):
            raise ValueError(f"{path}: {channel}: expected keys column, unit, sign, factor, offset; found {key!r}")
    for key in ("sign", "factor", "offset"):
        value = entry.get(key, 1)
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise ValueError(f"{path}: {channel}: expected a number for {key}, found {value!r}")
        if not math.isfinite(value) or (key == "factor" and value == 0):
            raise ValueError(f"{path}: {channel}: expected a finite number other than 0 for {key}, found {value!r}")
    if entry.get("sign", 1) not in (1, -1):
        raise ValueError(f"{path}: {channel}: expected sign of 1 or -1 (a scale is `factor`), found {entry['sign']!r}")
    unit = entry.get("unit", units[channel])
    si, factor = UNITS.get(unit, (None, 0.0)) if isinstance(unit, str) else (None, 0.0)
    if si != units[channel]:
        known = ", ".join(name for name, (to, _) in UNITS.items() if to == units[channel])
        raise ValueError(f"{path}: {channel}: expected a unit of {known}; found {unit!r}")
    factor *= float(entry.get("factor", 1)) * float(entry.get("sign", 1))
    return Source(entry["column"], factor, float(entry.get("offset", 0.0)))
