"""The soil along the way of one drive: each window with a free initial state is a quadratic in n
(`estimator/moving_horizon.py`); its minimum and curvature belong to the place where the vehicle is in its middle.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from softsoil.checking.driven_path import driven_path, way_to_position
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
from softsoil.importing.local_frame import other_frame
from softsoil.mapping.place import DRIFT, way_of
from softsoil.recording.drive import Recording
from softsoil.symbolic.model import Model
from softsoil.symbolic.soil import SOIL_SIGNALS
from softsoil.windows.free_windows import blocked_rows

Array = NDArray[np.float64]

ON_THE_WAY = VerdictRules(parts=np.inf)
"""Of the verdict on a drive: soils that change along the way are what a map is for."""

LOST = 2.5
"""m: where speed and heading alone may miss a place by more (`DRIFT`), it is not known."""


@dataclass(frozen=True)
class DriveSoil:
    """What one drive says of the soil along its way.

    log; verdict: on the drive as a whole, None where it was not estimated; x, y (W,): middle of each window (m); n,
    information (W,): minimum and curvature of its quadratic in n; common: share of n that an error common to all windows of the
    model makes; origin: latitude and longitude (deg) of x = y = 0, where the log has them; way (R, 2): positions that it drove
    through (m), NaN between stretches; covered: share of the drive in which windows run; blocked: shares across which none may,
    by the reason (`blocked_rows`), and, "position", of which no place is known; notes: on the log; left_out: why it is not on the
    map, empty where it is.
    """

    log: str
    verdict: Verdict | None
    x: Array
    y: Array
    n: Array
    information: Array
    common: float
    origin: tuple[float, float] | None = None
    way: Array = field(default_factory=lambda: np.zeros((0, 2)))
    covered: float = 0.0
    blocked: Mapping[str, float] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    left_out: str = ""

    def moved(self, origin: tuple[float, float] | None) -> DriveSoil:
        """The drive in the frame of another origin, latitude and longitude (deg); as it is where either has none."""
        if self.origin is None or origin is None or self.origin == origin:
            return self
        x, y = other_frame("map", self.x, self.y, self.origin, origin)
        way = np.column_stack(other_frame("map", self.way[:, 0], self.way[:, 1], self.origin, origin))
        return replace(self, x=x, y=y, way=way, origin=origin)


def unusable(log: str, why: str, origin: tuple[float, float] | None = None, notes: tuple[str, ...] = ()) -> DriveSoil:
    """A log that cannot be on a map, and why; origin, notes: as of `DriveSoil`."""
    nothing = np.zeros(0)
    words = why.removeprefix(f"{log}: ")
    return DriveSoil(log, None, nothing, nothing, nothing, nothing, 0.0, origin, notes=notes, left_out=words)


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
    place, known = _place(recording, model)
    drive, since = windows.drive, int(np.searchsorted(recording.t, windows.drive.t[windows.rows[0]]))
    x, y = (np.interp(drive.t[middle], recording.t, place[:, i]) for i in (0, 1))
    there = (np.interp(drive.t[middle], recording.t, known.astype(float)) > 0.5) & np.isfinite(x) & np.isfinite(y)
    information = hessian * rules.stride / rules.length
    common = float(np.hypot(common_error(rules.common_error, windows.compiled.model), evidence.soil.more))
    verdict = judged_without_wheels(recording, decide(evidence, evidence.n, rules=ON_THE_WAY.of(model)), choice)
    no_windows = blocked_rows(windows.compiled.model, drive, rules.fastest, rules.slowest)
    blocked = {why: float(rows[drive.first :].mean()) for why, rows in no_windows.items()}
    blocked["position"] = float(np.mean(~known[since:]))
    where = recording.origin, way_of(recording, since), windows.covered, blocked
    x, y, n, information = x[there], y[there], n[there], information[there]
    return DriveSoil(recording.name, verdict, x, y, n, information, common, *where, recording.notes)


def _place(recording: Recording, model: Model) -> tuple[Array, NDArray[np.bool_]]:
    """(N, 2) where the drive was (m), and (N,) whether that is known: by a position, or by speed and heading not far from one."""
    return driven_path(recording, model.geometry)[0], DRIFT * way_to_position(recording) < LOST
