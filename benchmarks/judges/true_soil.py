"""The nominal drives of the independent simulator and their true soils, from the names of the logs."""

from __future__ import annotations

from pathlib import Path

from softsoil.recording.log_names import named_n, named_soil
from softsoil.symbolic.soil import SOILS, Soil

NOMINAL = ("paper", "multi", "steps")
"""Beginnings of the names of drives without an added effect."""


def true_soil(name: str) -> Soil:
    """Soil class with the true n of a drive called e.g. `multi_sandyloam_n0.55`; ValueError for a name without them."""
    n, soil = named_n(name), named_soil(name)
    if n is None or soil is None:
        raise ValueError(f"drive: expected a name such as multi_clay_n0.50, found {name!r}")
    return SOILS[soil].with_(n=n)


def nominal_logs(folder: Path) -> list[Path]:
    """Nominal drives (CSV.gz) in a folder, in the order of their names."""
    return [path for path in sorted(folder.glob("*.csv.gz")) if path.name.split("_")[0] in NOMINAL]


def drive_name(path: Path) -> str:
    """Name of a drive from its file."""
    return path.name.removesuffix(".csv.gz")
