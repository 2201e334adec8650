"""The soil along the way: the sinkage exponent per cell of the ground, fused over windows and drives by information.

Each window with a free initial state is a quadratic in n (`estimator/moving_horizon.py`); its minimum and curvature belong to the
cell where the vehicle is in its middle. A cell's n is the mean of its windows weighted by information, its standard deviation
that of noise and scatter, with the error that is common to all windows of a model.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from softsoil.declaration.ground import refuse_hard_ground
from softsoil.estimator.driveline_choice import log_driveline, with_choice
from softsoil.estimator.estimate import judged_without_wheels
from softsoil.estimator.evidence import gather
from softsoil.estimator.horizons import START_UP
from softsoil.estimator.modes import run_horizon
from softsoil.estimator.moving_horizon import HorizonRules, drive_windows
from softsoil.estimator.tuning import common_error
from softsoil.estimator.verdict import Verdict, decide, initial_guesses
from softsoil.estimator.verdict_rules import VerdictRules
from softsoil.recording.drive import Recording
from softsoil.symbolic.model import Model
from softsoil.symbolic.soil import SOIL_SIGNALS

Array = NDArray[np.float64]

FEWEST = 2
"""Windows that a cell needs, so that their scatter says something."""
ON_THE_WAY = VerdictRules(parts=np.inf)
"""Of the verdict on a drive: soils that change along the way are what a map is for."""


@dataclass(frozen=True)
class DriveSoil:
    """What one drive says of the soil along its way.

    log; verdict: on the drive as a whole; x, y (W,): middle of each window (m); n, information (W,): minimum and curvature of its
    quadratic in n; common: share of n that an error common to all windows of the model makes; origin: latitude and longitude
    (deg) of x = y = 0, where the log has them.
    """

    log: str
    verdict: Verdict
    x: Array
    y: Array
    n: Array
    information: Array
    common: float
    origin: tuple[float, float] | None = None


@dataclass(frozen=True)
class Cell:
    """One cell: column, row; n, std: fused; windows: how many; drives: how many logs crossed it."""

    column: int
    row: int
    n: float
    std: float
    windows: int
    drives: int


def drive_soil(recording: Recording, model: Model, n0: float, start: float = START_UP) -> DriveSoil:
    """The soil along one drive, from sensor channels only.

    model: bicycle with declared effects; n0: initial guess of n; start: seconds left out at the beginning.
    Raises ValueError for a drive that the model cannot use, or a model of hard ground.
    """
    refuse_hard_ground(model)
    rules = HorizonRules()
    choice = log_driveline(recording, model, n0, start)
    model = model if choice is None else with_choice(model, choice)
    windows = drive_windows(recording, model, start, rules)
    evidence = gather(windows, initial_guesses(n0), True, rules)
    summary = run_horizon(windows, evidence.guess, True, rules).summary
    which = np.arange(len(windows.rows))
    at, hessian, gradient = (np.array(part).reshape(len(which)) for part in (summary.at, summary.hessian, summary.gradient))
    bounds = SOIL_SIGNALS["n"]
    n = np.clip(at - gradient / np.maximum(hessian, 1e-9), bounds.lower, bounds.upper)
    middle = windows.rows + windows.steps // 2
    x, y = (windows.drive.smooth[middle, i] for i in (0, 1))
    information = hessian * rules.stride / rules.length
    common = float(np.hypot(common_error(rules.common_error, windows.compiled.model), evidence.soil.more))
    verdict = judged_without_wheels(recording, decide(evidence, evidence.n, rules=ON_THE_WAY.of(model)), choice)
    return DriveSoil(recording.name, verdict, x, y, n, information, common, recording.origin)


def fuse(drives: Sequence[DriveSoil], size: float) -> tuple[Cell, ...]:
    """Cells of `size` (m) that the drives cross, row by row. Raises ValueError for a size that is not positive."""
    if not size > 0:
        raise ValueError(f"cell size: expected a positive number of metres, found {size}")
    members: dict[tuple[int, int], list[tuple[int, float, float]]] = {}
    for k, drive in enumerate(drives):
        for x, y, n, information in zip(drive.x, drive.y, drive.n, drive.information, strict=True):
            members.setdefault((int(np.floor(y / size)), int(np.floor(x / size))), []).append((k, n, information))
    cells = []
    for (row, column), found in sorted(members.items()):
        if len(found) < FEWEST:
            continue
        n, weight = (np.array([entry[i] for entry in found]) for i in (1, 2))
        mean = float(weight @ n / weight.sum())
        noise = 1.0 / weight.sum()
        scatter = float(weight**2 @ (n - mean) ** 2 / weight.sum() ** 2) * len(found) / (len(found) - 1)
        crossed = {entry[0] for entry in found}
        common = max(drives[k].common for k in crossed)
        std = float(np.sqrt(max(noise, scatter) + (common * mean) ** 2))
        cells.append(Cell(column, row, mean, std, len(found), len(crossed)))
    return tuple(cells)
