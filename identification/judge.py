"""The log left out: its n, and predictions of its last part, with the numbers before and after an identification."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from softsoil.estimator.horizons import HORIZONS
from softsoil.identification.bench import Bench, first_n
from softsoil.identification.errors import errors_of
from softsoil.identification.result import Judged
from softsoil.recording.drive import STATE_CHANNELS
from softsoil.refinement.unknown_ground import free_n
from softsoil.refinement.vehicle_numbers import declared_vehicle
from softsoil.symbolic.catalogue import bicycle
from softsoil.windows.absent_wheels import with_log_wheels
from softsoil.windows.free_starts import FASTEST, HORIZON, steps_of, until
from softsoil.windows.free_windows import FreeWindows, WindowModel, window_rows
from softsoil.windows.shooting import SEEN, Drive
from softsoil.windows.window_fit import fit_windows

Array = NDArray[np.float64]

FIT_SHARE = 2 / 3
"""The first part of the log gives n, the rest is predicted."""
FEWEST_PATHS = 2
"""Windows of a horizon that are judged at least."""


def judge(bench: Bench, after: Mapping[str, float], model_error: float) -> Judged:
    """The bench's one drive predicted with the vehicle as its owner's file declares it, with the numbers as expected before the
    logs, and with the identified ones, `after`; n fitted anew to its first part with each.

    model_error: of n, as a share, beside its sampling error.
    """
    drive, windows = bench.drives[0], bench.windows[0]
    declared = _declared(bench)
    row = drive.first + int(FIT_SHARE * (len(drive.t) - drive.first))
    results = []
    for one, values in ((declared, {}), (bench, {}), (bench, after)):
        compiled = one.windows[0].compiled
        first = FreeWindows(compiled, until(drive, row), HORIZON, windows.sigma, FASTEST, seen=SEEN)
        part = replace(one, windows=(first,))
        guess = first_n(part, values)
        fit = fit_windows(part.windows, free_n(len(part.windows)), np.array(guess), one.parameters(values, guess))
        std = float(np.hypot(errors_of(fit).std["n_0"], model_error * fit.value[0]))
        results.append((path_errors(compiled, drive, fit.p[0], row), (float(fit.value[0]), std), float(np.sqrt(fit.cost))))
    (table_0, n_0, rms_0), (guessed, _, _), (table_1, n_1, rms_1) = results
    return Judged(bench.names[0], n_0, n_1, table_0, guessed, table_1, rms_0, rms_1)


def _declared(bench: Bench) -> Bench:
    """The bench with the model of the vehicle as its owner's file declares it."""
    vehicle = declared_vehicle(bench.known)
    model = with_log_wheels(bicycle(vehicle, bench.soils[0]), bench.recordings)
    windows = bench.windows[0]
    compiled = WindowModel(model, bench.drives[0].dt, steps_of(bench.drives[0].dt))
    mine = FreeWindows(compiled, bench.drives[0], HORIZON, windows.sigma, FASTEST, seen=SEEN)
    return replace(bench, vehicle=vehicle, model=model, windows=(mine,), balances=(), p=model.p.nominal[None])


def path_errors(compiled: WindowModel, drive: Drive, p: Array, row: int) -> dict[str, dict[str, float]]:
    """Horizon (s) -> state -> mean squared error over windows after `row` that start at the recorded states.

    p (n_p,): parameters of the compiled model. NaN for a channel that is not measured, or too few windows.
    """
    table = {}
    for horizon in HORIZONS:
        means = np.full(len(STATE_CHANNELS), np.nan)
        steps = max(round(horizon / drive.dt), 2)
        later = replace(drive, first=row)
        if len(window_rows(compiled.model, later, steps, steps, np.inf, None, 0.0)) >= FEWEST_PATHS:
            long = FreeWindows(compiled, later, horizon, np.ones(len(STATE_CHANNELS)))
            error = long.residual(p, long.first).reshape(len(long.rows), -1, len(STATE_CHANNELS))[:, 1:]
            seen = np.isfinite(long.recorded[:, 1:]).sum(axis=(0, 1))
            means = np.where(seen > 0, (error**2).sum(axis=(0, 1)) / np.maximum(seen, 1), np.nan)
        table[f"{horizon:.1f}"] = dict(zip(STATE_CHANNELS, map(float, means), strict=True))
    return table
