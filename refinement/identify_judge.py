"""The log left out: its n, and predictions of its last part, with the numbers before and after an identification."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from softsoil.estimator.free_windows import FreeWindows
from softsoil.estimator.horizons import HORIZONS
from softsoil.estimator.shooting import Drive
from softsoil.estimator.window_fit import fit_windows
from softsoil.recording.drive import STATE_CHANNELS
from softsoil.refinement.identify_bench import FASTEST, HORIZON, Bench, first_n, free_n
from softsoil.refinement.identify_errors import errors_of
from softsoil.refinement.identify_result import Judged

Array = NDArray[np.float64]

FIT_SHARE = 2 / 3
"""The first part of the log gives n, the rest is predicted."""
FEWEST_PATHS = 2
"""Windows of a horizon that are judged at least."""


def judge(bench: Bench, before: Mapping[str, float], after: Mapping[str, float]) -> Judged:
    """The bench's one drive judged with two sets of numbers, n fitted anew to its first part with each."""
    drive, windows = bench.drives[0], bench.windows[0]
    row = drive.first + int(FIT_SHARE * (len(drive.t) - drive.first))
    first = FreeWindows(windows.compiled, _until(drive, row), HORIZON, windows.sigma, FASTEST)
    part = replace(bench, windows=(first,))
    table, n, rms = [], [], []
    for values in (before, after):
        guess = first_n(part, values)
        p = bench.parameters(values, guess)
        fit = fit_windows(part.windows, free_n(part), np.array(guess), p)
        n.append((float(fit.value[0]), errors_of(fit).std["n_0"]))
        rms.append(float(np.sqrt(fit.cost)))
        table.append(_errors(windows, drive, fit.p[0], row))
    return Judged(bench.names[0], n[0], n[1], table[0], table[1], rms[0], rms[1])


def _until(drive: Drive, row: int) -> Drive:
    return replace(
        drive, t=drive.t[:row], measured=drive.measured[:row], smooth=drive.smooth[:row], inputs=drive.inputs[:row]
    )


def _errors(windows: FreeWindows, drive: Drive, p: Array, row: int) -> dict[str, dict[str, float]]:
    """Horizon -> state -> mean squared error over windows after `row` that start at the recorded states."""
    table = {}
    for horizon in HORIZONS:
        means = np.full(len(STATE_CHANNELS), np.nan)
        if (len(drive.t) - row - 1) * drive.dt >= FEWEST_PATHS * horizon:
            long = FreeWindows(windows.compiled, replace(drive, first=row), horizon, np.ones(len(STATE_CHANNELS)))
            error = long.residual(p, long.first).reshape(len(long.rows), -1, len(STATE_CHANNELS))[:, 1:]
            seen = np.isfinite(long.recorded[:, 1:])
            means = (error**2).sum(axis=(0, 1)) / np.maximum(seen.sum(axis=(0, 1)), 1)
        table[f"{horizon:.1f}"] = dict(zip(STATE_CHANNELS, map(float, means), strict=True))
    return table
