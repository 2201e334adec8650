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
from softsoil.windows.shooting import Shooting

Array = NDArray[np.float64]

FEWEST_PATHS = 4
"""Held-out windows that a picture of paths shows at least, where the drive has them."""


@dataclass(frozen=True)
class DriveView:
    """One drive before and after.

    name; held_from: time from which the drive judges (s); before, after: residuals; structure_before, structure_after:
    shares and correlations; signals: name -> (M,) mean per residual window; refined: whether the refined model differs from the
    declared one: equal lines are not drawn twice; horizon (s) of the paths; clock (N,): time within a path (s); recorded,
    path_before, path_after (W, N, 3): x, y, psi of the held-out windows, W = 0 where the part that judges holds none.
    """

    name: str
    held_from: float
    before: DriveResidual
    after: DriveResidual
    structure_before: Structure
    structure_after: Structure
    signals: dict[str, Array]
    refined: bool
    horizon: float
    clock: Array
    recorded: Array
    path_before: Array
    path_after: Array


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
    horizon = held_horizon(shooting, row)
    recorded, path_before = _paths(shooting, horizon, first, row)
    _, path_after = _paths(after.shootings[i], horizon, second, row)
    return DriveView(
        name=recording.name,
        held_from=float(shooting.drive.t[row]),
        before=residual,
        after=drive_residual(recording, after.model, vehicle, second, start),
        structure_before=structure(recording, before.model, declared, first, start),
        structure_after=result.structure[i],
        signals=signals,
        refined=bool(result.effects or result.contradicted),
        horizon=horizon,
        clock=shooting.drive.dt * np.arange(1, recorded.shape[1] + 1),
        recorded=recorded,
        path_before=path_before,
        path_after=path_after,
    )


def held_horizon(shooting: Shooting, row: int) -> float:
    """The longest horizon of which the part from `row` on holds windows, FEWEST_PATHS where it is long enough; 0 without one."""
    starts = {horizon: shooting.starts(horizon) for horizon in HORIZONS}
    held = {horizon: int((rows >= row).sum()) for horizon, rows in starts.items() if len(rows) > 1}
    several = [horizon for horizon, count in held.items() if count >= FEWEST_PATHS]
    return max(several or [horizon for horizon, count in held.items() if count], default=0.0)


def _paths(shooting: Shooting, horizon: float, p: Array, row: int) -> tuple[Array, Array]:
    """x, y, psi recorded and predicted over the windows of that length from `row` on."""
    if horizon == 0.0:
        return np.empty((0, 0, 3)), np.empty((0, 0, 3))
    windows = shooting.ahead(horizon)
    chosen = windows.rows >= row
    return windows.recorded[chosen][:, :, :3], windows.predict(p)[chosen][:, :, :3]
