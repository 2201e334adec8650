"""The driveline that explains a log without wheel speeds, where the vehicle does not declare it.

Which wheels are driven decides what each of them pushes, and with it n. Every driveline of DRIVELINES is fitted to windows with
free initial states, n free, and the one that leaves least is taken; those that leave as much within AMBIGUOUS standard errors
remain possible.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from softsoil.declaration.ground import sinks
from softsoil.estimator.moving_horizon import HorizonRules, drive_windows, exponents
from softsoil.recording.drive import WHEEL_CHANNELS, Recording
from softsoil.symbolic.model import Model
from softsoil.windows.absent_wheels import absent_wheels
from softsoil.windows.free_windows import FreeWindows
from softsoil.windows.window_fit import WindowFit, fit_windows

DRIVELINES = {
    "all wheels driven, centre locked": {"centre_lock": 1.0, "front_drive": 0.5},
    "all wheels driven, centre open": {"centre_lock": 0.0, "front_drive": 0.5},
    "front wheels driven": {"centre_lock": 0.0, "front_drive": 1.0},
    "rear wheels driven": {"centre_lock": 0.0, "front_drive": 0.0},
}
"""Drivelines that a log may decide between, in words."""
ITERATIONS = 8
"""Of each fit, at most."""
AMBIGUOUS = 2.0
"""Standard errors of the mean cost of a window by which a driveline is worse than another one that excludes it."""


@dataclass(frozen=True)
class Choice:
    """The driveline taken: words and numbers, keys of `DRIVELINES`; n: drivelines that remain possible -> n of the first log."""

    words: str
    numbers: dict[str, float]
    n: dict[str, float]

    @property
    def spread(self) -> float:
        """Largest difference of n between the possible drivelines and the one taken, over n."""
        return max(abs(n / self.n[self.words] - 1.0) for n in self.n.values())

    def __str__(self) -> str:
        others = [f"{words} (n = {n:.3f})" for words, n in self.n.items() if words != self.words]
        return f"{self.words}, as the log says" + (f"; as well: {', '.join(others)}" if others else "")


def undeclared(recordings: Sequence[Recording], model: Model) -> bool:
    """Whether the recordings measure no wheel speed and the vehicle does not say which wheels are driven.

    On hard ground it does not matter.
    """
    return sinks(model) and len(absent_wheels(recordings)) == len(WHEEL_CHANNELS) and not model.geometry.driveline


def choose_driveline(
    recordings: Sequence[Recording], models: Sequence[Model], n0: Sequence[float], start: float
) -> Choice:
    """The driveline that leaves least of the recordings.

    models, n0: of each recording, and the initial guess of its n, one for both axles; start: seconds left out at the beginning
    of each. Raises ValueError for a drive that the model cannot use, or too short a one.
    """
    absent = absent_wheels(recordings)  # in all models alike: a log that measures them is as good a witness
    windows = [drive_windows(r, m, start, HorizonRules(), absent) for r, m in zip(recordings, models, strict=True)]
    fits = {
        words: [_fit(w, n, numbers) for w, n in zip(windows, n0, strict=True)] for words, numbers in DRIVELINES.items()
    }
    costs = {words: np.concatenate([fit.costs for fit in found]) for words, found in fits.items()}
    best = min(costs, key=lambda words: float(costs[words].mean()))
    share = min(float(np.median(np.diff(windows[0].rows))) / windows[0].steps, 1.0)
    possible = {}
    for words, cost in costs.items():
        worse = cost - costs[best]
        if words == best or worse.mean() < AMBIGUOUS * worse.std() / np.sqrt(max(share * len(worse), 1.0)):
            possible[words] = float(fits[words][0].value[0])
    return Choice(best, DRIVELINES[best], possible)


def log_driveline(drive: Recording, model: Model, n0: float, start: float) -> Choice | None:
    """The driveline that a log without wheel speeds shows, where it is not declared; None for a log that is too short.

    n0: initial guess of n; start: seconds left out at the beginning.
    """
    if not undeclared([drive], model):
        return None
    try:
        return choose_driveline([drive], [model], [n0], start)
    except ValueError:  # without two windows nothing is identified, as the verdict says
        return None


def with_choice(model: Model, choice: Choice) -> Model:
    """The model of a vehicle that declares the driveline taken."""
    return replace(model, geometry=model.geometry.with_(driveline=choice.numbers))


def _fit(windows: FreeWindows, n0: float, numbers: dict[str, float]) -> WindowFit:
    windows.reset()
    p = windows.compiled.model.p.pack(numbers)
    return fit_windows([windows], exponents(True), np.array([n0]), p, iterations=ITERATIONS)
