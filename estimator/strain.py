"""Whether a drive is one of the vehicle that is declared: one Gauss-Newton step of n and its numbers from its windows.

Only where the vehicle's file states errors of its numbers. A load, lower tyres or a bent link move them together; n
takes that up, and neither the windows' residual nor a filter's innovations need to show it. A load is what changes from one
drive to the next and what n takes up most, while the numbers hardly move where sensors are noisy: it is looked for by itself.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from softsoil.estimator.moving_horizon import MovingHorizon
from softsoil.estimator.tuning import Tuning
from softsoil.windows.free_starts import JointPrior, joint_prior, steps_of
from softsoil.windows.free_windows import FreeWindows, Linear, window_model
from softsoil.windows.own_numbers import load_of, stated_error, steering_scale_of
from softsoil.windows.parameters import Free
from softsoil.windows.strain import last_step, marginal, strain
from softsoil.windows.window_fit import reduce_windows

Array = NDArray[np.float64]

MOST = 1.0
"""Share of its mass by which a vehicle is heavier or lighter at most, as a standard deviation."""
STEERING = 0.2
"""Share by which road wheels turn farther or less than a log says, as a standard deviation."""


@dataclass(frozen=True)
class VehicleChange:
    """How a drive would have the vehicle other than its file: strain of its numbers (`softsoil.windows.strain`); load, load_std:
    share of its mass by which it is heavier than declared, the numbers free within their joint error, and the standard deviation
    with that of a declared load; seen_std: the same by the drive alone, whatever the file says of a load; steering, steering_std:
    share by which road-wheel angles are larger than the log says, a load free beside it, and the standard deviation.
    """

    strain: float
    load: float
    load_std: float
    seen_std: float
    steering: float
    steering_std: float


def vehicle_change(windows: FreeWindows, horizon: MovingHorizon) -> VehicleChange | None:
    """What the windows of one drive say of the vehicle; None where its file states no errors of its numbers.

    windows: of the drive (`drive_windows`); horizon: run to its end.
    """
    prior = known_numbers(windows)
    if prior is None:
        return None
    vehicle = windows.compiled.model.geometry
    mass, name = vehicle.mass, load_of(vehicle).parameters[0].name
    scale = np.linalg.norm(np.linalg.pinv(prior.root), axis=1)  # standard deviation of each number
    numbers = [Free(name, (name,), std / 2, -np.inf, np.inf) for name, std in zip(prior.names, scale, strict=True)]
    load = Free(name, (name,), 0.1 * mass, -np.inf, np.inf)
    scale_name = steering_scale_of(vehicle).parameters[0].name
    steering = Free(scale_name, (scale_name,), 0.5 * STEERING, -np.inf, np.inf)
    hessian, gradient = _normal_equations(windows, horizon, [*horizon.free, *numbers, load, steering])
    kept = np.arange(len(horizon.free), len(hessian) - 2)
    with_scale = hessian.copy()
    with_scale[np.ix_(kept, kept)] += prior.root.T @ prior.root
    with_scale[-2, -2] += (MOST * mass) ** -2
    with_scale[-1, -1] += STEERING**-2
    turned, turned_std = last_step(with_scale, gradient)
    hessian, whole, gradient = hessian[:-1, :-1], with_scale[:-1, :-1], gradient[:-1]
    step = -np.linalg.lstsq(whole[:-1, :-1], gradient[:-1], rcond=None)[0]
    strained = strain(prior.root @ step[kept], marginal(hessian[:-1, :-1], kept), prior.root)
    heavier, std = last_step(whole, gradient)
    known = vehicle.uncertainty.get(name, 0.0)
    declared = float(windows.compiled.model.p[scale_name].nominal)
    return VehicleChange(
        strained, heavier / mass, float(np.hypot(std, known)) / mass, std / mass, turned / declared, turned_std / declared
    )


def _normal_equations(windows: FreeWindows, horizon: MovingHorizon, free: Sequence[Free]) -> tuple[Array, Array]:
    """Hessian (K, K) and gradient (K,) of what is `free` at the horizon's estimate, by the windows of the present soil.

    In the steps in which the numbers were identified: longer ones ask for a vehicle 2 % of its mass lighter. The vehicle stays
    what it is while the horizon forgets: of earlier windows each `forgetting` of time counts with an n of its own.
    """
    model, dt = windows.compiled.model, windows.drive.dt
    windows = windows.by(window_model(model, dt, steps_of(dt)))
    last = len(windows.rows) - 1
    which = np.arange(horizon.since, last + 1)
    x0, p = np.array(horizon.summary.states)[which], horizon.parameters(horizon.n)
    linear = windows.linearise(p, x0, free, which)
    sound = np.isfinite(linear.by_free).all(axis=(1, 2))
    lighter = np.tile(_of_good_sensors(windows.sigma, np.array(horizon.rules.model_error)), windows.steps + 1)
    parts = (linear.residual * lighter, linear.by_state * lighter[:, None], linear.by_free * lighter[:, None])
    reduced = reduce_windows(Linear(*(part[sound] for part in parts)))
    weight = horizon.weight(last)[which][sound]
    hessian, gradient = np.einsum("w,wkl->kl", weight, reduced.hessian), np.einsum("w,wk->k", weight, reduced.gradient)
    age, n = (last - which[sound]) * horizon.rules.stride, len(horizon.free)
    span = np.floor(age / horizon.rules.forgetting)
    for k in range(1, int(span.max(initial=0.0)) + 1):
        part = np.where(span == k, horizon.share - weight, 0.0)
        own, moved = np.einsum("w,wkl->kl", part, reduced.hessian), np.einsum("w,wk->k", part, reduced.gradient)
        cross = own[n:, :n] @ np.linalg.pinv(own[:n, :n])
        hessian[n:, n:] += own[n:, n:] - cross @ own[:n, n:]
        gradient[n:] += moved[n:] - cross @ moved[:n]
    return hessian, gradient


def _of_good_sensors(sigma: Array, model_error: Array) -> Array:
    """(6,) weights of residuals in sigma (6,), by which no sensor is better than the filter believes one to be: what the
    equations miss is not white, and would strain numbers that are right."""
    noise = np.maximum(sigma**2 - model_error**2, np.square(Tuning().sensor_floor))
    return np.where(np.isfinite(sigma), sigma / np.sqrt(model_error**2 + noise), 1.0)


def known_numbers(windows: FreeWindows) -> JointPrior | None:
    """What is known together of the numbers that are parameters of the windows' model; None where the vehicle states nothing."""
    model = windows.compiled.model
    stated = stated_error(model.geometry)
    error = None if stated is None else stated.only({*model.p.names})
    return None if error is None else joint_prior(error, model, {name: float(model.p[name].nominal) for name in error.names})
