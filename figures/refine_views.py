"""What the report shows of one drive: residual and held-out predictions of the declared and of the refined model."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from softsoil.estimator.horizons import HORIZONS
from softsoil.recording.drive import Recording
from softsoil.refinement.residual import DriveResidual, drive_residual
from softsoil.refinement.result import Refinement
from softsoil.refinement.structure import Structure, axle_windows, structure
from softsoil.refinement.trace import Bench

Array = NDArray[np.float64]

FEWEST_PATHS = 4
"""Held-out windows that a picture of paths shows at least, where the drive has them."""


@dataclass(frozen=True)
class DriveView:
    """One drive before and after.

    name; held_from: time from which the drive judges (s); before, after: residuals; structure_before, structure_after:
    shares and correlations; signals: name -> (M,) mean per residual window; horizon (s) of the paths; clock (N,): time
    within a path (s); recorded, path_before, path_after (W, N, 3): x, y, psi of the held-out windows.
    """

    name: str
    held_from: float
    before: DriveResidual
    after: DriveResidual
    structure_before: Structure
    structure_after: Structure
    signals: dict[str, Array]
    horizon: float
    clock: Array
    recorded: Array
    path_before: Array
    path_after: Array

    @property
    def refined(self) -> bool:
        """Whether the refined model differs from the declared one; equal lines are not drawn twice."""
        return not np.array_equal(self.path_before, self.path_after, equal_nan=True)


def drive_views(result: Refinement, start: float) -> list[DriveView]:
    """A view of each drive that was refined on.

    result: what came of refine; start: seconds left out at the beginning, as given to it.
    """
    return [_view(recording, result, i, start) for i, recording in enumerate(result.recordings)]


def _view(recording: Recording, result: Refinement, i: int, start: float) -> DriveView:
    before, after = result.bench, result.selection.bench
    declared, vehicle = before.model.geometry, result.declaration.vehicle
    first, second = before.absent[i], after.absent[i]
    residual = drive_residual(recording, before.model, declared, first, start)
    _, _, signals = axle_windows(recording, before.model, declared, residual.t)
    shooting, held = before.shootings[i], before.held[i]
    row = shooting.rows[held[0]]
    horizon, recorded, path_before = _paths(before, i, first, row)
    _, _, path_after = _paths(after, i, second, row)
    return DriveView(
        name=recording.name,
        held_from=float(shooting.drive.t[row]),
        before=residual,
        after=drive_residual(recording, after.model, vehicle, second, start),
        structure_before=structure(recording, before.model, declared, first, start),
        structure_after=result.structure[i],
        signals=signals,
        horizon=horizon,
        clock=shooting.drive.dt * np.arange(1, recorded.shape[1] + 1),
        recorded=recorded,
        path_before=path_before,
        path_after=path_after,
    )


def _paths(bench: Bench, i: int, p: Array, row: int) -> tuple[float, Array, Array]:
    """The longest horizon that the held-out part holds, and x, y, psi recorded and predicted over its windows there."""
    drive = bench.shootings[i].drive
    rest = (len(drive.t) - row - 1) * drive.dt
    horizon = max((h for h in HORIZONS if h <= rest / FEWEST_PATHS), default=HORIZONS[0])
    windows = bench.shootings[i].ahead(horizon)
    chosen = windows.rows >= row
    return horizon, windows.recorded[chosen][:, :, :3], windows.predict(p)[chosen][:, :, :3]
