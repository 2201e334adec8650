"""Runs of the horizon over one drive from several initial guesses: a mode that fits the windows clearly worse does not stand.

The sum over windows can have another minimum far from the right n, in which a bad guess stays however long the drive is. All
windows are laid at the final n of each run, their initial states at their best there, and their costs compared pair by pair (as
in Vuong's test): the scatter of the differences says how sure their mean is; overlapping neighbours are no two observations.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from softsoil.estimator.moving_horizon import HorizonRules, MovingHorizon, exponents
from softsoil.windows.free_windows import FreeWindows
from softsoil.windows.window_fit import reduce_windows, window_costs

Array = NDArray[np.float64]

WORSE, WORSE_SIGMAS = 0.05, 4.0
"""Share of the best run's cost by which another must cost more to be left out, and standard errors of that difference.

Chosen on seeds 9 and 10 of `benchmarks.verdicts_fresh`: ends of one mode differ by less than 1 %, two modes of a crawling vehicle
that are both wrong by 1.5 and 3 %, a second mode of a nominal drive by 39 %."""
LESS, MORE_SIGMAS = 0.02, 6.0
"""The same where many windows say so: on minutes of road of which each shows little of the soil a mode at the upper bound costs
3 % more by 8 standard errors and more, and on soil modes of which each is wrong differ by fewer than 4."""
PASSES = 2
"""Steps of the initial states at the final n, from where the run left them."""


@dataclass(frozen=True)
class Run:
    """guess: initial guess of n; horizon: run from it to the end of the drive; cost (W,): mean robust squared residual of each
    window at the final n; worse: share by which the windows of the present soil cost more than with the run that fits best."""

    guess: float
    horizon: MovingHorizon
    cost: Array
    worse: float = 0.0


def run_horizon(windows: FreeWindows, n0: float, tied: bool, rules: HorizonRules) -> MovingHorizon:
    """A moving horizon run to the end of the drive from the initial guess n0, and settled; tied: one n for both axles."""
    windows.reset()
    horizon = MovingHorizon(windows, exponents(tied), n0, rules)
    for k in range(len(windows.rows)):
        horizon.update(k)
    horizon.settle()
    return horizon


def run_guess(windows: FreeWindows, n0: float, tied: bool, rules: HorizonRules) -> Run:
    """A run from the initial guess n0 with the cost of its windows; tied: one n for both axles."""
    horizon = run_horizon(windows, n0, tied, rules)
    p, x0 = horizon.parameters(horizon.n), np.array(horizon.summary.states)
    for _ in range(PASSES):
        x0 = x0 + np.nan_to_num(reduce_windows(windows.linearise(p, x0, ())).states(np.zeros(0)))
        windows.follow(p, x0)
    return Run(n0, horizon, window_costs(windows.residual(p, x0)))


def worse(cost: Array, best: Array, share: float) -> tuple[float, float]:
    """By how much windows cost (W,) more than `best` (W,): as a share of that, and in standard errors.

    share: of a window that its neighbour does not cover.
    """
    more = cost - best
    error = float(more.std()) / np.sqrt(max(share * len(more), 1.0))
    return float(more.mean() / max(best.mean(), 1e-12)), float(more.mean() / max(error, 1e-12))


def standing(runs: Sequence[Run]) -> tuple[list[Run], list[Run]]:
    """The runs that stand, and those that fit the present soil clearly worse than the one that fits it best.

    Of those that stand, the first stays first where it stands; else the one that fits best comes first.
    """
    since = max(run.horizon.since for run in runs)
    best = min(runs, key=lambda run: float(run.cost[since:].mean()))
    parts: tuple[list[Run], list[Run]] = [], []
    for run in runs:
        share, sigmas = worse(run.cost[since:], best.cost[since:], run.horizon.share)
        clearly = (share > WORSE and sigmas > WORSE_SIGMAS) or (share > LESS and sigmas > MORE_SIGMAS)
        parts[clearly].append(replace(run, worse=share))
    stand, left_out = parts
    return (stand if stand[0].guess == runs[0].guess else sorted(stand, key=lambda run: run.worse)), left_out
