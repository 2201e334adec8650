"""Data that comes with the package: vehicles and example logs."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

VEHICLES = Path(str(files("softsoil"))) / "vehicles"
LOGS = Path(str(files("softsoil"))) / "data"
VEHICLE_NAMES = ("reference", "paper", "plant", "heavy")
"""Built-in vehicles: of the reference logs, the same in the paper's structure, two simulated ones as their models say."""
REFERENCE_VEHICLE = VEHICLES / "reference.toml"
"""The vehicle that a command takes where none is named."""
PLANT_VEHICLE = VEHICLES / "plant.toml"
"""The simulated vehicle as its model declares it."""


def vehicle_file(source: str | Path) -> Path:
    """Path of a vehicle's TOML: of the package for a built-in name, else `source` itself.

    Raises ValueError for a bare name that is none of them, and no file.
    """
    if str(source) in VEHICLE_NAMES:
        return VEHICLES / f"{source}.toml"
    path = Path(source)
    if path.suffix == "" and path.name == str(source) and not path.exists():
        raise ValueError(f"vehicle: expected one of {', '.join(VEHICLE_NAMES)}, or a TOML file; found {str(source)!r}")
    return path


def plant_file(name: str, source: str | Path = "") -> Path:
    """Path of the plant's vehicle that a declared one describes: NAME_plant.toml beside its file or of the package, else the
    reference vehicle's. name: of the declared vehicle; source: its file."""
    for folder in (Path(source).parent, VEHICLES):
        if (path := folder / f"{name}_plant.toml").is_file():
            return path
    return VEHICLES / "reference_plant.toml"


def source_name(path: str | Path) -> str:
    """How a file is named in results: relative to the package for its own data, else as given."""
    path = Path(path)
    return f"softsoil/vehicles/{path.name}" if path.parent == VEHICLES else str(path)


def example_logs() -> list[Path]:
    """Drives that come with the package, in order of their names.

    Example:
        >>> import softsoil
        >>> [log.name for log in softsoil.example_logs()][0]
        'multi_clay_n0.50.parquet'
    """
    return sorted(path for path in LOGS.iterdir() if path.name.endswith((".csv.gz", ".parquet")))
