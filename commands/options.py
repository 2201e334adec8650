"""Options that say which log is read and how."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from softsoil.checking.usable import checked, mark_checked, whole
from softsoil.commands.options_model import declared_vehicle
from softsoil.commands.output import console
from softsoil.declaration.late_steering import late_steering
from softsoil.recording.columns import load_columns
from softsoil.recording.drive import CHANNEL_UNITS, Recording
from softsoil.recording.noise import NOISES, add_noise
from softsoil.recording.read import read_drive
from softsoil.symbolic.vehicle import Vehicle

ColumnsOption = Annotated[
    Path | None,
    typer.Option("--columns", help='Column map TOML, e.g. u = {column = "speed", unit = "km/h"}.', show_default=False),
]
NoiseOption = Annotated[str, typer.Option("--noise", help=f"Sensor noise added to the log: {', '.join(NOISES)}.")]
SeedOption = Annotated[int, typer.Option("--seed", help="Seed of the noise.")]
MethodOption = Annotated[
    str, typer.Option("--method", help="Estimator: ukf (the paper's filter) or horizon (windows with free initial states).")
]
SkipOption = Annotated[
    float, typer.Option("--skip", help="Seconds left out at the beginning of a log (start-up).", min=0)
]


def open_drive(
    log: Path,
    columns: Path | None,
    noise: str = "none",
    seed: int = 0,
    *,
    vehicle: Path | None = None,
    model: Path | None = None,
    geometry: Vehicle | None = None,
) -> tuple[Recording, Recording]:
    """The drive as recorded, and with sensor noise added; absent channels are derived, doubtful ones are warned about.

    vehicle, model: files that declare the vehicle, default the reference vehicle, or geometry: the vehicle itself. Raises
    ValueError for channels that contradict each other beyond doubt.
    """
    clean = read_drive(log, load_columns(columns, CHANNEL_UNITS) if columns is not None else None)
    geometry = geometry or declared_vehicle(vehicle, model)
    clean, doubts = checked(clean, geometry, late_steering(geometry))
    for doubt in doubts:
        console.print(f"warning: {log.name}: {doubt}", style="yellow", highlight=False, soft_wrap=True)
    # Noise first: what is derived carries that of the sensors it is derived from.
    return whole(clean, geometry), whole(mark_checked(add_noise(clean, noise, seed)), geometry)
