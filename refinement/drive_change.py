"""How one drive would have the vehicle other than its file, as `softsoil estimate` sees it: of one log both say the same."""

from __future__ import annotations

from softsoil.declaration.model_file import Declaration
from softsoil.estimator.evidence import gather
from softsoil.estimator.moving_horizon import HorizonRules, drive_windows
from softsoil.estimator.strain import VehicleChange
from softsoil.estimator.verdict import initial_guesses
from softsoil.recording.drive import Recording


def change_of_drive(recording: Recording, declaration: Declaration, start: float) -> VehicleChange | None:
    """Strain of the vehicle's numbers and another mass by the windows of one drive.

    start: seconds left out at the beginning. None where the vehicle's file states no errors of its numbers. Raises ValueError for
    a drive that holds no two windows.
    """
    windows = drive_windows(recording, declaration.build(), start, HorizonRules())
    return gather(windows, initial_guesses(float(declaration.soil.n)), tied=True).change
