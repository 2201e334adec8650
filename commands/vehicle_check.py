"""Which vehicle a command takes, said first, and whether a log can be of that vehicle."""

from __future__ import annotations

from pathlib import Path

from softsoil.commands.output import console
from softsoil.recording.drive import Recording
from softsoil.refinement.geometry_check import beyond_doubt
from softsoil.symbolic.vehicle import Vehicle


def say_vehicle(vehicle: Path | None, model: Path | None, name: str) -> None:
    """Say which vehicle is taken where neither --vehicle nor --model names one."""
    if vehicle is None and model is None:
        console.print(f"vehicle: {name}, since --vehicle names none", highlight=False)


def refuse_another(log: Recording, vehicle: Vehicle) -> None:
    """ValueError for a log whose motion contradicts the vehicle's geometry beyond doubt."""
    words = beyond_doubt(log, vehicle)
    if words:
        raise ValueError(f"{words}: --vehicle names the vehicle that drove")


def warn_of_another(log: Recording, vehicle: Vehicle) -> None:
    """The same as a remark, for commands that look for what such a contradiction may be: a sensor that stands elsewhere."""
    words = beyond_doubt(log, vehicle)
    if words:
        console.print(f"{words}: another vehicle, or a sensor that is wrong", highlight=False)
