"""Options that several commands share, and what they mean."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from recording.columns import load_columns
from recording.drive import CHANNEL_UNITS, Recording
from recording.noise import NOISES, add_noise
from recording.read import read_drive
from symbolic.declaration import Declaration, load_declaration
from symbolic.soil import SOILS, load_soil
from symbolic.vehicle import load_vehicle
from symbolic.wheel import law_names

PROJECT = Path(__file__).resolve().parents[1]
REFERENCE_VEHICLE = PROJECT / "vehicles" / "reference.toml"
OWN_LOGS = PROJECT / "data"

VehicleOption = Annotated[
    Path | None, typer.Option("--vehicle", help="Vehicle TOML (default: the reference vehicle).", show_default=False)
]
SoilOption = Annotated[
    str | None,
    typer.Option("--soil", help=f"{', '.join(SOILS)}, or a soil TOML.", show_default=False),
]
LawOption = Annotated[str, typer.Option("--law", help=f"Force law: {', '.join(law_names())}.")]
ModelOption = Annotated[
    Path | None,
    typer.Option(
        "--model", help="refined.toml: vehicle, soil, law and effects in one, in their place.", show_default=False
    ),
]
ColumnsOption = Annotated[
    Path | None,
    typer.Option("--columns", help='Column map TOML, e.g. u = {column = "speed", unit = "km/h"}.', show_default=False),
]
NoiseOption = Annotated[str, typer.Option("--noise", help=f"Sensor noise added to the log: {', '.join(NOISES)}.")]
SeedOption = Annotated[int, typer.Option("--seed", help="Seed of the noise.")]
OutOption = Annotated[
    Path | None, typer.Option("--out", help="Folder to write in (default: runs/<command>).", show_default=False)
]
SkipOption = Annotated[
    float, typer.Option("--skip", help="Seconds left out at the beginning of a log (start-up).", min=0)
]


def declaration(vehicle: Path | None, soil: str | None, law: str, model: Path | None) -> Declaration:
    """What the options declare: `model` alone, or vehicle, soil and law.

    Raises ValueError for a soil or vehicle beside a model, or for neither soil nor model.
    """
    if model is not None:
        for option, value in (("--soil", soil), ("--vehicle", vehicle)):
            if value is not None:
                raise ValueError(f"{option}: expected none beside --model, which declares it; found {str(value)!r}")
        return load_declaration(model)
    if soil is None:
        raise ValueError(f"--soil: expected one of {', '.join(SOILS)} or a TOML file (or --model), found none")
    return Declaration(load_vehicle(vehicle or REFERENCE_VEHICLE), load_soil(soil), law)


def open_drive(log: Path, columns: Path | None, noise: str = "none", seed: int = 0) -> tuple[Recording, Recording]:
    """The drive as recorded, and with sensor noise added."""
    clean = read_drive(log, load_columns(columns, CHANNEL_UNITS) if columns is not None else None)
    return clean, add_noise(clean, noise, seed)
