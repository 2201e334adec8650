"""`softsoil generate`: a model and its filter as a C library."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from softsoil.codegen.c_library.folder import write_library
from softsoil.codegen.sampling import STEP
from softsoil.codegen.text_cache import asked_for, texts_from_cache
from softsoil.commands.generate_again import remember
from softsoil.commands.options_model import (
    LawOption,
    ModelOption,
    OutOption,
    SoilOption,
    VehicleOption,
    declaration,
    said_of,
    say_vehicle,
)
from softsoil.commands.output import output_folder, say_written
from softsoil.files.package_data import REFERENCE_VEHICLE, vehicle_file
from softsoil.symbolic.soil import SOILS


def generate(
    folder: Annotated[
        Path | None, typer.Argument(help="Folder to write in (default: runs/generate).", show_default=False)
    ] = None,
    vehicle: VehicleOption = None,
    soil: SoilOption = None,
    law: LawOption = None,
    model: ModelOption = None,
    dt: Annotated[float, typer.Option("--dt", help="Nominal step of the model and the filter (s).")] = STEP,
    controller: Annotated[
        bool,
        typer.Option("--controller", help="Also the controller: NMPC on the filter's estimate, and a closed loop."),
    ] = False,
    hessian: Annotated[
        str | None,
        typer.Option("--hessian", help="Of the controller: gauss_newton (default) or exact.", show_default=False),
    ] = None,
    fmi: Annotated[bool, typer.Option("--fmi", help="Also FMI 3.0 units: of the model, and of the driver.")] = False,
    out: OutOption = None,
) -> None:
    """Write a model and its filter as a C library: header, sources, README, example, CMake and formulation.json.

    The vehicle's declared effects are in it; with effects one n stands for both axles, without them
    front and rear have their own.

    With --controller the same model predictive controller as in Python stands beside them, and example_drive.c closes
    the loop; a vehicle without declared effects then gets those that a controller's model carries.

    Example: softsoil generate build/clay --soil clay --controller
    """
    if folder is not None and out is not None:
        raise ValueError(f"--out: expected none beside the folder {folder}, found {out}")
    if hessian is not None and not controller:
        raise ValueError(f"--hessian: expected --controller beside it, whose it is; found {hessian} alone")
    hessian = hessian or "gauss_newton"
    first, declared = say_vehicle(vehicle, model), declaration(vehicle, soil, law, model)

    def make() -> dict[str, str]:
        if controller:
            from softsoil.control.c_folder import controller_texts

            return controller_texts(declared, dt, fmi, hessian=hessian)
        from softsoil.control.c_estimator import c_library_texts

        return c_library_texts(declared, dt, fmi)

    written = output_folder(folder or out, "generate").path
    ground = Path(soil) if soil is not None and soil not in SOILS else soil
    said = (vehicle_file(vehicle or REFERENCE_VEHICLE), ground, law, model, dt, fmi, controller, hessian)
    texts = texts_from_cache(asked_for(*said), make)
    paths = write_library(written, texts)
    if not fmi:
        remember(sys.argv[1:], said, written, first, said_of(declared))
    else:
        from softsoil.codegen.c_library.pack_fmu import pack_fmus

        paths += pack_fmus(written)
    say_written(paths)
