"""Whether a clock that is off explains why a drive is inconsistent: the steering's or the inertial sensor's, by some 0.01 s.

What `checking/offsets.py` compares without a model is sure to 0.02 s; with the force law, less than that shows. So the windows
are run with the channels shifted, and the shift of least cost is judged as the drive itself.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

import numpy as np
import pandas as pd

from softsoil.checking.usable import usable
from softsoil.declaration.handed import check_model
from softsoil.declaration.late_steering import late_steering
from softsoil.estimator.driveline_choice import log_driveline, with_choice
from softsoil.estimator.evidence import gather
from softsoil.estimator.horizons import START_UP
from softsoil.estimator.modes import run_guess
from softsoil.estimator.moving_horizon import HorizonRules, drive_windows
from softsoil.estimator.terrain import TerrainEstimate
from softsoil.estimator.verdict import Verdict, decide
from softsoil.estimator.verdict_rules import VerdictRules
from softsoil.recording.drive import WHEEL_CHANNELS, Recording
from softsoil.symbolic.model import Model

CLOCKS: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {"steer": ("steer",), "steer and the wheels": ("steer", *WHEEL_CHANNELS), "omega_z": ("omega_z", "a_x_imu", "a_y_imu")}
)
"""Words for what a clock times -> its channels."""
TRIED, FINER, FARTHEST = 0.03, 0.015, 0.12
"""s: shifts that are tried to either side of none, then to either side of the vertex of the parabola through their costs; the
largest that is asked for."""
LEAST = 0.015
"""s: a smaller shift explains too much else, as a mass that is a fifth too large."""
PART = 12.0
"""s: of the middle of a drive, on which shifts are tried; what they explain is judged on all of it."""
CHEAPER = 0.995
"""Share of the cost without a shift that one of those tried has at most, for the clock to be looked at further."""


@dataclass(frozen=True)
class LateClock:
    """what: words of CLOCKS; late: by how much its clock is late (s, negative: early); n, std: at the end of the drive with the
    clock set right, and the standard deviation."""

    what: str
    late: float
    n: float
    std: float

    @property
    def sentence(self) -> str:
        """What it is, and what to do."""
        return (
            f"{self.what} recorded {abs(self.late):.2f} s {'late' if self.late > 0 else 'early'} would explain it: with late = "
            f"{self.late:.2f} there in the map of softsoil import n is {self.n:.2f} ± {self.std:.2f}, identified"
        )


def late_clocks(
    log: Recording | pd.DataFrame | str | Path, model: Model, found: TerrainEstimate, *, start: float = START_UP
) -> tuple[LateClock, ...]:
    """The clocks that, set right, turn an inconsistent estimate of a log into an identified one: the one that costs least first.

    log, model, start: as of `estimate`; found: its result. None for any other verdict, or a file that its own logs contradict.
    Evidence, not proof: what else may be wrong is in the verdict's reason. It takes about as long as the estimate. Raises as
    `estimate`.

    Example:
        >>> import numpy, softsoil
        >>> model = softsoil.bicycle(softsoil.load_vehicle("reference"), softsoil.load_soil("clay"))
        >>> drive = softsoil.read_drive(softsoil.example_logs()[0]).between(0.0, 10.0)
        >>> drive = drive.with_channels(steer=numpy.roll(drive["steer"], 4))
        >>> found = softsoil.estimate(drive, model)
        >>> found.verdict.word, softsoil.late_clocks(drive, model, found)[0].what
        ('inconsistent', 'steer')
    """
    check_model("late_clocks", model)
    if found.verdict is None:
        return ()
    recording = usable(log, model.geometry, late_steering(model.geometry))
    return clocks_of(recording, model, found.verdict, bool(model.effects), start)


def clocks_of(recording: Recording, model: Model, verdict: Verdict, tied: bool, start: float) -> tuple[LateClock, ...]:
    """The same for a verdict that was given already.

    recording: a `usable` drive; model; verdict: on it; tied: whether one n stands for both axles; start: seconds left out at the
    beginning.
    """
    if verdict.word != "inconsistent" or verdict.evidence is None or model.doubted:
        return ()
    n0 = float(verdict.evidence.n[0])
    choice = log_driveline(recording, model, n0, start)
    model = model if choice is None else with_choice(model, choice)
    horizon, rules = HorizonRules(), VerdictRules().of(model)
    middle = 0.5 * (recording.t[0] + start + recording.t[-1])
    part = recording.between(max(middle - 0.5 * PART, recording.t[0] + start), middle + 0.5 * PART)

    def cost(names: tuple[str, ...], rows: int) -> float:
        windows = drive_windows(shifted(part, names, rows), model, 0.0, horizon)
        return float(np.nan_to_num(run_guess(windows, n0, tied, horizon).cost.mean(), nan=np.inf))

    try:
        drive_windows(part, model, 0.0, horizon)
    except ValueError:  # the middle of the drive holds no two windows
        return ()
    clocks: list[tuple[float, LateClock]] = []
    for what, names in own_clocks(recording).items():
        costs, rows = {0: cost(names, 0)}, 0
        for reach in (TRIED, FINER):
            step = max(round(reach / recording.dt), 1)
            for side in (rows - step, rows + step, rows):
                if side not in costs:
                    costs[side] = cost(names, side)
            if min(costs.values()) > CHEAPER * costs[0]:
                break
            rows = _vertex(costs, rows, step)
        late = rows * recording.dt
        if min(costs.values()) > CHEAPER * costs[0] or not LEAST <= abs(late) <= FARTHEST:
            continue
        evidence = gather(drive_windows(shifted(recording, names, rows), model, start, horizon), (n0,), tied, horizon)
        if decide(evidence, evidence.n, (), rules).usable:
            clocks.append((min(costs.values()), LateClock(what, late, float(evidence.n[0]), float(evidence.std[0]))))
    return tuple(clock for _, clock in sorted(clocks, key=lambda one: one[0]))


def own_clocks(recording: Recording) -> dict[str, tuple[str, ...]]:
    """Those of CLOCKS that time something in the recording which those before do not: wheels without speeds have none."""
    clocks: dict[str, tuple[str, ...]] = {}
    for what, names in CLOCKS.items():
        own = tuple(name for name in names if name in recording and recording.measured(name))
        if names[0] in own and own not in clocks.values():
            clocks[what] = own
    return clocks


def _vertex(costs: Mapping[int, float], rows: int, step: int) -> int:
    """Rows of least cost by the parabola through those at `rows` and `step` to either side; of the least of the three where it
    opens downwards or its vertex lies farther than four times the step."""
    low, here, high = (costs[rows + side] for side in (-step, 0, step))
    bend = low - 2.0 * here + high
    away = 0.5 * (low - high) / bend if bend > 0.0 else np.inf
    return rows + (round(step * away) if abs(away) <= 4.0 else (-step if low < high else step))


def shifted(recording: Recording, names: tuple[str, ...], rows: int) -> Recording:
    """The recording with the channels `names` as they were so many rows later: of a clock that is late by as much, set right."""
    index = np.clip(np.arange(len(recording)) + rows, 0, len(recording) - 1)
    return recording.with_channels(**{name: recording[name][index] for name in names if name in recording})
