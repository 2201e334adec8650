"""Drives made by the model itself: what a filter must get right before it meets another world."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from softsoil.codegen.predictor import Predictor
from softsoil.codegen.sampling import STEP
from softsoil.recording.drive import STATE_CHANNELS, WHEEL_CHANNELS, Recording
from softsoil.recording.geometry import radius_of
from softsoil.symbolic.model import Model

Array = NDArray[np.float64]


def paper_steering(t: Array, amplitude: float = 0.45, period: float = 3.0) -> Array:
    """The paper's manoeuvre: a sine to `amplitude` (rad) over `period` (s), at times t (N,) (s)."""
    return amplitude * np.sin(2 * np.pi * t / period)


def synthetic_drive(
    model: Model,
    radius: float,
    p: ArrayLike | None = None,
    seconds: float = 33.0,
    speed: float = 6.0,
    swing: float = 1.0,
    slip: float = 0.05,
    slip_rate: float = 0.0,
    steer: Array | None = None,
    dt: float = STEP,
    substeps: int = 1,
) -> Recording:
    """A clean drive of `model` with parameters p (n_p,), default nominal: its own states, and the inputs that made them.

    radius: of the front wheels (m); seconds: how long; speed, swing: mean forward speed and its sinusoidal variation (m/s);
    slip: of the driven wheels at constant speed (1), slip_rate: more of it per m/s^2 of acceleration; steer (N,): steering angle
    (rad), default the paper's sine; dt: rows (s); substeps: Euler steps of the model from one to the next.
    Raises ValueError for a speed that would reverse.
    """
    if not speed > abs(swing) + 0.5:
        raise ValueError(f"speed: expected at least {abs(swing) + 0.5:g} m/s to stay forward, found {speed:g}")
    t = np.asarray(dt * np.arange(round(seconds / dt) + 1), dtype=float)
    steer = paper_steering(t) if steer is None else steer
    rate = 2 * np.pi / 11.0  # a period that no multiple of the steering's repeats
    a_x = swing * rate * np.cos(rate * t)
    u = speed + np.concatenate([[0.0], np.cumsum(a_x[:-1] * dt)])
    spin = u / (radius * (1 - slip - slip_rate * a_x))
    spins = {name: spin * model.geometry.radius / radius_of(model.geometry, name) for name in WHEEL_CHANNELS}
    inputs = {"steer": steer, "steer_rate": np.gradient(steer, dt), "a_x": a_x, **spins}
    stacked = np.column_stack([inputs[name] for name in model.external.names])
    p = model.p.nominal if p is None else np.asarray(p, dtype=float)
    states = Predictor(model, dt, substeps=substeps).rollout(model.x.pack(u=u[0]), stacked[:-1], p)
    x = {name: states[:, model.x.index(name)] for name in STATE_CHANNELS}
    imu = {"a_x_imu": a_x - x["v"] * x["omega_z"]}
    return Recording("synthetic", {"t": t, **x, **imu, "steer": steer, **spins})
