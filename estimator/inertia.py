"""Whether a drive contradicts the declared yaw inertia: one Gauss-Newton step of n and of the inertia from an estimate's windows.

The yaw rate changes by M_z/I: an inertia larger by the share e takes e times the model's own change of the yaw rate off every
step. What that does to the rest of a window follows from the derivatives of single steps along the drive, so that no other model
is compiled. A wrong inertia is taken up by n (40 % too large: n 19 to 37 % too high); the filter's innovations do not show it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from softsoil.estimator.moving_horizon import MovingHorizon
from softsoil.estimator.summary import LEAST_CURVATURE
from softsoil.recording.drive import STATE_CHANNELS
from softsoil.windows.free_windows import STATE_STEP, FreeWindows, Linear, N
from softsoil.windows.window_fit import reduce_windows

Array = NDArray[np.float64]

YAW = STATE_CHANNELS.index("omega_z")


def inertia_error(windows: FreeWindows, horizon: MovingHorizon) -> tuple[float, float]:
    """By how much the windows would have the yaw inertia other than declared, as a share of it, and the standard deviation.

    windows: of the drive; horizon: run to its end. Minus 0.2: the vehicle turns as if its inertia were 20 % smaller.
    """
    last = len(windows.rows) - 1
    which = np.arange(horizon.since, last + 1)
    x0, p = np.array(horizon.summary.states)[which], horizon.parameters(horizon.n)
    linear = windows.linearise(p, x0, horizon.free, which)
    by_inertia = _by_inertia(windows, p, which)[..., None]
    by_free = np.concatenate([linear.by_free, by_inertia], axis=2)
    sound = np.isfinite(by_free).all(axis=(1, 2))
    reduced = reduce_windows(Linear(linear.residual[sound], linear.by_state[sound], by_free[sound]))
    hessian, gradient = reduced.hessian, reduced.gradient
    weight = horizon.weight(last)[which][sound]
    total = np.einsum("w,wkl->kl", weight, hessian) + LEAST_CURVATURE * np.eye(hessian.shape[-1])
    inverse = np.linalg.inv(total)
    step = -inverse @ np.einsum("w,wk->k", weight, gradient)
    scores = gradient + np.einsum("wkl,l->wk", hessian, step)
    robust = inverse @ np.einsum("w,wk,wl->kl", weight, scores, scores) @ inverse
    return float(step[-1]), float(np.sqrt(max(robust[-1, -1], inverse[-1, -1])))


def _by_inertia(windows: FreeWindows, p: Array, which: NDArray[np.int_]) -> Array:
    """(W, m) derivative of the residuals of the windows `which` to the share by which the inertia is larger."""
    first, count = windows.rows[which] - windows.rows[which[0]], len(which)
    by_state, change = _steps(windows, p, int(windows.rows[which[0]]), int(windows.rows[which[-1]]) + windows.steps)
    moved, state = np.zeros((count, windows.steps + 1, N)), np.zeros((count, N))
    for k in range(windows.steps):
        state = np.einsum("wij,wj->wi", by_state[first + k], state)
        state[:, YAW] -= change[first + k, YAW]
        moved[:, k + 1] = state
    moved = moved / windows.sigma
    moved[~np.isfinite(windows.recorded[which])] = 0.0
    return moved.reshape(count, -1)


def _steps(windows: FreeWindows, p: Array, start: int, stop: int) -> tuple[Array, Array]:
    """(R, 6, 6) derivatives of one step to the state it starts at, and (R, 6) its change, at the rows from start to stop."""
    rows = np.arange(start, stop)
    states, memory = windows.along(rows), windows.memories(p[None], rows)[0]
    many = np.tile(states, (1 + N, 1, 1))
    many[1:, :, :N] += STATE_STEP[:, None, None] * np.eye(N)[:, None, :]
    inputs = np.tile(windows.drive.inputs[rows[:, None] + np.arange(2)], (1 + N, 1, 1))
    jobs = len(inputs)
    after = windows.compiled.loop.windows(
        many.reshape(jobs, -1), np.tile(memory, (1 + N, 1)), inputs, np.broadcast_to(p, (jobs, len(p)))
    ).reshape(1 + N, len(rows), 2, 2 * N)[:, :, 1, N:]
    return np.moveaxis((after[1:] - after[0]) / STATE_STEP[:, None, None], 0, -1), after[0] - states[:, :N]
