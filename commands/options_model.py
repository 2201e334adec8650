"""Options that say what is modelled: read without the libraries that model it, so that a command starts at once."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from softsoil.files.package_data import REFERENCE_VEHICLE, VEHICLE_NAMES, source_name, vehicle_file
from softsoil.symbolic.soil import SOILS, load_soil
from softsoil.symbolic.vehicle import load_vehicle
from softsoil.symbolic.wheel import law_names

if TYPE_CHECKING:
    from softsoil.symbolic.declaration import Declaration

VehicleOption = Annotated[
    Path | None,
    typer.Option(
        "--vehicle", help=f"{', '.join(VEHICLE_NAMES)} (default: reference), or a vehicle TOML.", show_default=False
    ),
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
OutOption = Annotated[
    Path | None, typer.Option("--out", help="Folder to write in (default: runs/<command>).", show_default=False)
]


def declaration(vehicle: Path | None, soil: str | None, law: str, model: Path | None) -> Declaration:
    """What the options declare: `model` alone, or vehicle, soil and law.

    Raises ValueError for a soil or vehicle beside a model, or for neither soil nor model.
    """
    from softsoil.symbolic.declaration import Declaration, load_declaration

    if model is not None:
        for option, value in (("--soil", soil), ("--vehicle", vehicle)):
            if value is not None:
                raise ValueError(f"{option}: expected none beside --model, which declares it; found {str(value)!r}")
        return load_declaration(model)
    if soil is None:
        raise ValueError(f"--soil: expected one of {', '.join(SOILS)} or a TOML file (or --model), found none")
    return Declaration(load_vehicle(vehicle or REFERENCE_VEHICLE), load_soil(soil), law)


def about_vehicle(vehicle: Path | None, model: Path | None = None) -> dict[str, str]:
    """Name and file of the vehicle that a result rests on, from the options that name it."""
    if model is not None:
        from softsoil.symbolic.declaration import load_declaration

        return {"name": load_declaration(model).vehicle.name, "file": str(model)}
    path = vehicle_file(vehicle or REFERENCE_VEHICLE)
    return {"name": load_vehicle(path).name, "file": source_name(path)}
