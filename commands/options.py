"""Options that say which log is read and how."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from softsoil.recording.columns import load_columns
from softsoil.recording.drive import CHANNEL_UNITS, Recording
from softsoil.recording.noise import NOISES, add_noise
from softsoil.recording.read import read_drive

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


def open_drive(log: Path, columns: Path | None, noise: str = "none", seed: int = 0) -> tuple[Recording, Recording]:
    """The drive as recorded, and with sensor noise added."""
    clean = read_drive(log, load_columns(columns, CHANNEL_UNITS) if columns is not None else None)
    return clean, add_noise(clean, noise, seed)
