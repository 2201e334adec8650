"""Data that comes with the package: vehicles and example logs."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

VEHICLES = Path(str(files("softsoil"))) / "vehicles"
LOGS = Path(str(files("softsoil"))) / "data"
REFERENCE_VEHICLE = VEHICLES / "reference.toml"
"""The vehicle that a command takes where none is named."""
PLANT_VEHICLE = VEHICLES / "plant.toml"
"""The simulated vehicle as its model declares it."""


def example_logs() -> list[Path]:
    """Drives that come with the package, in order of their names."""
    return sorted(path for path in LOGS.iterdir() if path.name.endswith((".csv.gz", ".parquet")))
