"""`softsoil soil`: the numbers of a soil from drives of a known vehicle."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table

from softsoil.commands.error_table import error_table
from softsoil.commands.invocation import software
from softsoil.commands.options import ColumnsOption, NoiseOption, SeedOption, SkipOption, open_drive
from softsoil.commands.options_model import OutOption, VehicleOption, about_vehicle, declared_vehicle, say_vehicle
from softsoil.commands.output import console, output_folder, progress, say_written, write_result
from softsoil.commands.vehicle_check import refuse_another
from softsoil.declaration.model_file import soil_toml
from softsoil.estimator.horizons import START_UP
from softsoil.figures.soil_report import write_report
from softsoil.identification.soil_numbers import SoilIdentification, identify_soil
from softsoil.identification.words import SOIL_VERDICTS, STATES
from softsoil.refinement.words import with_error, with_unit
from softsoil.symbolic.soil import load_soil


def soil_command(
    logs: Annotated[
        list[Path], typer.Argument(help="One drive or more on that soil: CSV, CSV.gz or Parquet.", show_default=False)
    ],
    soil: Annotated[
        str,
        typer.Option("--soil", help="Soil TOML with a table \\[uncertainty]: what may be wrong, how much.", show_default=False),
    ],
    vehicle: VehicleOption = None,
    columns: ColumnsOption = None,
    noise: NoiseOption = "none",
    seed: SeedOption = 0,
    skip: SkipOption = START_UP,
    out: OutOption = None,
) -> None:
    """What drives of a known vehicle say of the soil that they were on: its friction, its shear modulus, n of each drive.

    The numbers of the soil's file are fitted within the errors that it states, the vehicle's within their joint error. The last
    third of each drive judges. Only sensor channels are read.

    Example: softsoil soil multi.csv lock.csv --vehicle vehicle.toml --soil field.toml
    """
    folder = output_folder(out, "soil", ("soil.json", "soil.toml", "report.html"))
    say_vehicle(vehicle)
    declared, geometry = load_soil(soil), declared_vehicle(vehicle, None)
    drives = [open_drive(path, columns, noise, seed + 10 * i, geometry=geometry)[1] for i, path in enumerate(logs)]
    for drive in drives:
        refuse_another(drive, geometry)
    with progress(", ".join(drive.name for drive in drives)) as told:
        found = identify_soil(drives, declared, geometry, start=skip, progress=told)
    _say(found)
    path = folder / "soil.toml"
    path.write_text(soil_toml(found.soil, (f"{found.verdict}: {found.reason}",)), encoding="utf-8")
    about = about_vehicle(vehicle)
    report = write_report(found, folder / "report.html", {"software": software(), "vehicle": about})
    say_written([write_result(folder / "soil.json", found.as_json(), about), path, report])


def _say(found: SoilIdentification) -> None:
    console.print(f"{SOIL_VERDICTS[found.verdict]}. {found.reason}", style="bold", highlight=False)
    table = Table(title=f"Numbers of {found.soil.name}", title_justify="left")
    for heading in ("number", "value ± std", "state", "given"):
        table.add_column(heading, justify="right" if heading in ("value ± std", "given") else "left")
    for name, one in found.numbers.items():
        given = with_unit(one.given, one.given_std, one.unit)
        table.add_row(name, with_unit(one.value, one.std, one.unit), STATES[one.state], given)
    console.print(table)
    for log, (value, std) in found.n.items():
        before = with_error(*found.n_before[log])
        console.print(f"{log}: n {with_error(value, std)}, with the class as given {before}", highlight=False)
    console.print(error_table("Rms error on the last third of each drive", found.before, found.after))
    console.print(f"computed in {found.seconds:.0f} s", highlight=False)
