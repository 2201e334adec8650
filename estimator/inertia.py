"""Whether a drive contradicts the declared yaw inertia: one Gauss-Newton step of n and of the inertia from an estimate's windows.

The yaw rate changes by M_z/I: an inertia larger by the share e takes e times the model's own change of the yaw rate off every
step. What that does to the rest of a window follows from the derivatives of single steps along the drive, so that no other model
is compiled. A wrong inertia is taken up by n (40 % too large: n 19 to 37 % too high); the filter's innovations do not show it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from softsoil.estimator.moving_horizon import MovingHorizon
from softsoil.estimator.step_changes import by_addition, single_steps
from softsoil.estimator.summary import LEAST_CURVATURE
from softsoil.recording.drive import STATE_CHANNELS
from softsoil.windows.free_windows import FreeWindows, Linear
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
    steps = single_steps(windows, p, which)
    added = np.zeros_like(steps.change)
    added[:, YAW] = -steps.change[:, YAW]
    by_inertia = by_addition(windows, steps, added)[..., None]
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
