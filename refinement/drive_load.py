"""Another mass, as one drive by itself shows it to `softsoil estimate`: both commands say the same of one log."""

from __future__ import annotations

from softsoil.declaration.model_file import Declaration
from softsoil.estimator.modes import run_guess, standing
from softsoil.estimator.moving_horizon import HorizonRules, drive_windows
from softsoil.estimator.strain import vehicle_change
from softsoil.estimator.verdict import initial_guesses
from softsoil.recording.drive import Recording


def load_of_drive(recording: Recording, declaration: Declaration, start: float) -> tuple[float, float] | None:
    """Share of its mass by which a drive has the vehicle heavier than declared, and its standard deviation.

    start: seconds left out at the beginning. None where the vehicle's file states no errors of its numbers. Raises ValueError for
    a drive that holds no two windows.
    """
    rules = HorizonRules()
    windows = drive_windows(recording, declaration.build(), start, rules)
    runs, _ = standing([run_guess(windows, guess, True, rules) for guess in initial_guesses(float(declaration.soil.n))])
    change = vehicle_change(windows, runs[0].horizon)
    return None if change is None else (change.load, change.load_std)
