"""Whether a log can be of the vehicle that a command takes."""

from __future__ import annotations

from softsoil.checking.geometry_check import beyond_doubt
from softsoil.commands.output import console
from softsoil.recording.drive import Recording
from softsoil.symbolic.vehicle import Vehicle

CURE = "a sensor is wrong or stands elsewhere ([mount] in the map of softsoil import)"
"""What it is where the log is of the vehicle."""


def refuse_another(log: Recording, vehicle: Vehicle) -> None:
    """ValueError for a log whose motion contradicts the vehicle's geometry beyond doubt."""
    words = beyond_doubt(log, vehicle)
    if words:
        raise ValueError(f"{words}: --vehicle names the vehicle that drove; if it is this one, {CURE}")


def doubt_another(log: Recording, vehicle: Vehicle, named: bool) -> None:
    """The same, for commands that look for what such a contradiction may be, as a sensor that stands elsewhere: a remark where
    the vehicle is the one that the user named (`named`)."""
    if not named:
        refuse_another(log, vehicle)
    words = beyond_doubt(log, vehicle)
    if words:
        console.print(f"{words}: another vehicle, or {CURE}", highlight=False)
