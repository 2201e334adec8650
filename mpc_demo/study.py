"""The paper's study on one log: n from a wrong first guess, then states predicted with the guess and with the estimate."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from softsoil.declaration.ground import refuse_hard_ground
from softsoil.declaration.model_file import Declaration
from softsoil.estimator.estimate import estimate
from softsoil.estimator.horizons import HORIZONS, START_UP, Replay, Windows
from softsoil.estimator.terrain import TerrainEstimate
from softsoil.recording.drive import Recording

Array = NDArray[np.float64]

GUESS_OFF = 0.2
"""How far the first guess of n is off (paper, Table 7)."""
LATERAL = ("y", "psi", "v", "omega_z")
"""The states that n moves."""


@dataclass(frozen=True)
class LogStudy:
    """The study of one log.

    log: its name; soil: name of the class; n_true: None where unknown; n_initial; estimate: the estimator's account;
    initial, estimated: windows by horizon with both values of n; clean: the drive without added noise.
    """

    log: str
    soil: str
    n_true: float | None
    n_initial: float
    estimate: TerrainEstimate
    initial: Mapping[float, Windows]
    estimated: Mapping[float, Windows]
    clean: Recording

    @property
    def n_estimated(self) -> float:
        """Final value at the front axle."""
        return float(self.estimate.n_front[-1])

    @property
    def error_percent(self) -> float | None:
        """|n_estimated - n_true| in per cent of n_true; None where the truth is unknown."""
        return None if self.n_true is None else 100 * abs(self.n_estimated - self.n_true) / self.n_true

    def as_json(self) -> dict[str, Any]:
        """The entry of study.json."""
        mse = {
            f"{horizon:.1f}": {"initial": self.initial[horizon].mse, "estimated": self.estimated[horizon].mse}
            for horizon in self.initial
        }
        return {
            "log": self.log,
            "soil": self.soil,
            "n_true": self.n_true,
            "n_initial": self.n_initial,
            "n_estimated": self.n_estimated,
            "verdict": None if self.estimate.verdict is None else self.estimate.verdict.word,
            "reason": None if self.estimate.verdict is None else self.estimate.verdict.reason,
            "error_percent": self.error_percent,
            "converged_s": self.estimate.converged_s,
            "mse": mse,
        }


def study_log(
    clean: Recording,
    noisy: Recording,
    declared: Declaration,
    n_true: float | None = None,
    n0: float | None = None,
    start: float = START_UP,
    progress: Callable[[float], None] | None = None,
    method: str = "ukf",
) -> LogStudy:
    """Estimate n on `noisy`, predict from the states of `clean`.

    declared: vehicle, soil, law and effects; with effects one n stands for both axles, else n_f and n_r as in the paper;
    n_true: for the judgement, and for the first guess (0.2 above it) unless n0 says another; start: seconds left out;
    method: as of `softsoil.estimate`; n of the filter is its own, not corrected by windows, as in the paper.
    Raises ValueError where a first guess would lie outside the bounds of n, or for hard ground, which has none.
    """
    model = declared.build()
    refuse_hard_ground(model)
    first = n0 if n0 is not None else (n_true + GUESS_OFF if n_true is not None else float(declared.soil.n))
    found = estimate(noisy, model, first, method=method, start=start, progress=progress, correct=False)
    replay = Replay(clean, model, start)
    before = model.p.pack(n_f=first, n_r=first)
    after = model.p.pack(n_f=found.parameters["n_f"], n_r=found.parameters["n_r"])
    initial = {horizon: replay.windows(before, horizon) for horizon in HORIZONS}
    estimated = {horizon: replay.windows(after, horizon) for horizon in HORIZONS}
    return LogStudy(clean.name, declared.soil.name, n_true, first, found, initial, estimated, clean)


def gains(studies: Sequence[LogStudy], horizon: float) -> Array:
    """(logs, 4) mean squared error of LATERAL with the first guess over that with the estimate; NaN where no window fits."""
    rows = [(entry.initial[horizon].mse, entry.estimated[horizon].mse) for entry in studies]
    return np.array([[guess[name] / found[name] for name in LATERAL] for guess, found in rows])
