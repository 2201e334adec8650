"""Whether a drive is one of the vehicle that was identified: one Gauss-Newton step of n and its numbers from its windows.

Only where the vehicle's file states the joint error of its numbers. A load, lower tyres or a bent link move them together; n
takes that up, and neither the windows' residual nor a filter's innovations need to show it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from softsoil.estimator.moving_horizon import MovingHorizon
from softsoil.estimator.tuning import Tuning
from softsoil.windows.free_starts import JointPrior, joint_prior
from softsoil.windows.free_windows import FreeWindows, Linear
from softsoil.windows.parameters import Free
from softsoil.windows.strain import marginal, strain
from softsoil.windows.window_fit import reduce_windows

Array = NDArray[np.float64]


def vehicle_strain(windows: FreeWindows, horizon: MovingHorizon) -> float | None:
    """Strain of the vehicle's numbers (`softsoil.windows.strain`) by the windows of one drive; None without a joint error.

    windows: of the drive; horizon: run to its end.
    """
    prior = known_numbers(windows)
    if prior is None:
        return None
    last = len(windows.rows) - 1
    which = np.arange(horizon.since, last + 1)
    x0, p = np.array(horizon.summary.states)[which], horizon.parameters(horizon.n)
    scale = np.linalg.norm(np.linalg.pinv(prior.root), axis=1)  # standard deviation of each number
    numbers = [Free(name, (name,), std / 2, -np.inf, np.inf) for name, std in zip(prior.names, scale, strict=True)]
    linear = windows.linearise(p, x0, [*horizon.free, *numbers], which)
    sound = np.isfinite(linear.by_free).all(axis=(1, 2))
    lighter = np.tile(_of_good_sensors(windows.sigma, np.array(horizon.rules.model_error)), windows.steps + 1)
    parts = (linear.residual * lighter, linear.by_state * lighter[:, None], linear.by_free * lighter[:, None])
    reduced = reduce_windows(Linear(*(part[sound] for part in parts)))
    weight = horizon.weight(last)[which][sound]
    hessian, gradient = np.einsum("w,wkl->kl", weight, reduced.hessian), np.einsum("w,wk->k", weight, reduced.gradient)
    kept = np.arange(len(horizon.free), len(hessian))
    whole = hessian.copy()
    whole[np.ix_(kept, kept)] += prior.root.T @ prior.root
    step = -np.linalg.lstsq(whole, gradient, rcond=None)[0]
    return strain(prior.root @ step[kept], marginal(hessian, kept), prior.root)


def _of_good_sensors(sigma: Array, model_error: Array) -> Array:
    """(6,) weights of residuals in sigma (6,), by which no sensor is better than the filter believes one to be: what the
    equations miss is not white, and would strain numbers that are right."""
    noise = np.maximum(sigma**2 - model_error**2, np.square(Tuning().sensor_floor))
    return np.where(np.isfinite(sigma), sigma / np.sqrt(model_error**2 + noise), 1.0)


def known_numbers(windows: FreeWindows) -> JointPrior | None:
    """What is known together of the numbers that are parameters of the windows' model; None where the vehicle states nothing."""
    model = windows.compiled.model
    error = getattr(model.geometry, "joint_error", None)
    error = error and error.only({*model.p.names})
    return error and joint_prior(error, model, {name: float(model.p[name].nominal) for name in error.names})
