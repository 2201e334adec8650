"""`softsoil residual`: what a model leaves unexplained in a drive."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table

from softsoil.calibration.wheel_report import refuse_beside_archives
from softsoil.commands.error_table import error_table
from softsoil.commands.options import ColumnsOption, NoiseOption, SeedOption, SkipOption, open_drive
from softsoil.commands.options_model import (
    LawOption,
    ModelOption,
    OutOption,
    SoilOption,
    VehicleOption,
    about_vehicle,
    declaration,
    say_vehicle,
)
from softsoil.commands.output import console, output_folder, progress, say_written, write_result
from softsoil.commands.residual_wheel import is_wheel_data, report_on_wheel_data
from softsoil.commands.vehicle_check import doubt_another
from softsoil.estimator.horizons import START_UP
from softsoil.figures.labels import quantity
from softsoil.figures.residual import draw_residual
from softsoil.recording.log_names import named_soil
from softsoil.refinement.residual import WINDOW, DriveResidual
from softsoil.refinement.residual import residual as drive_residual
from softsoil.refinement.words import number

SMALL = 0.001
"""Smallest probability that is printed as a number."""


def residual(
    data: Annotated[
        Path, typer.Argument(help="A drive (CSV, CSV.gz, Parquet) or single-wheel runs (npz).", show_default=False)
    ],
    vehicle: VehicleOption = None,
    soil: SoilOption = None,
    law: LawOption = None,
    model: ModelOption = None,
    n: Annotated[
        float | None,
        typer.Option("--n", help="Sinkage exponent, both axles (default: the soil's).", show_default=False),
    ] = None,
    columns: ColumnsOption = None,
    wheel: Annotated[
        Path | None,
        typer.Option("--wheel", help="Wheel TOML: DATA is then a single-wheel table.", show_default=False),
    ] = None,
    noise: NoiseOption = "none",
    seed: SeedOption = 0,
    skip: SkipOption = START_UP,
    out: OutOption = None,
) -> None:
    """What the model leaves unexplained in a drive, per channel, axle and horizon; or the force laws on single-wheel runs.

    Example: softsoil residual data/multi_clay_n0.50.parquet --soil clay
    """
    folder = output_folder(out, "residual", ("residual.json", "residual.png", "force.png", "errors.png"))
    if is_wheel_data(data, wheel):
        given = {"--vehicle": vehicle, "--law": law, "--model": model, "--n": n}
        given |= {"--noise": noise != "none", "--seed": seed, "--skip": skip != START_UP}
        idle = [name for name, value in given.items() if value is not None and value is not False and value != 0]
        if idle:
            raise ValueError(f"{', '.join(idle)}: expected none beside single-wheel data, on which all laws are judged")
        refuse_beside_archives([data], columns, wheel, soil)
        report_on_wheel_data(data, columns, wheel, soil, folder)
        return
    say_vehicle(vehicle, model)
    clean, noisy = open_drive(data, columns, noise, seed, vehicle=vehicle, model=model)
    declared = declaration(vehicle, soil or (None if model else named_soil(clean.name)), law, model)
    doubt_another(noisy, declared.vehicle, named=bool(vehicle or model))
    with progress(clean.name):
        found = drive_residual(noisy, declared, n, start=skip)
    for note in noisy.notes:
        console.print(note, highlight=False)
    console.print(channel_table(found))
    console.print(error_table("Rms prediction error", found.mse))
    figure = draw_residual(clean.name, declared.build().name, found, folder / "residual.png")
    content = {"channels": found.channels, "axles": found.axles, "mse": found.mse}
    say_written([write_result(folder / "residual.json", content, about_vehicle(vehicle, model)), figure])


def chance_words(p: float) -> str:
    """A probability with two digits; none of its digits where it is tiny."""
    return "-" if not math.isfinite(p) else (f"{p:.2g}" if p >= SMALL else f"< {SMALL:g}")


def channel_table(found: DriveResidual) -> Table:
    """Residual of each state after one window, and of each axle's force."""
    table = Table(title=f"Unexplained after {WINDOW:g} s, {len(found.t)} windows", title_justify="left")
    for heading in ("channel", "rms", "p if it is noise alone"):
        table.add_column(heading, justify="left" if heading == "channel" else "right")
    for name, entry in found.channels.items():
        shown = quantity(name)
        table.add_row(shown.label, number(shown.factor * entry["rms"]), chance_words(entry["whiteness_p"]))
    for axle, force in found.axles.items():
        table.add_row(f"lateral force, {axle} axle, N", number(force["rms"]), "")
    return table
