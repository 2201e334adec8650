"""Model inputs from a recorded drive."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.signal import savgol_filter

from softsoil.recording.drive import Recording
from softsoil.recording.forward import accelerometer_known
from softsoil.symbolic.signals import Layout

Array = NDArray[np.float64]

RATE_TIME = 0.05
"""s: length of the straight line whose slope is the steering rate, one sample to each side at least and two at most: a step stays
a step, and one of a size has the same rate at 50 and at 100 Hz."""
MOST_ACCELERATION = 12.0
"""m/s^2: more than tyres can do on any soil; an accelerometer that says more has been hit, and its sample is left out."""


def measured_inputs(recording: Recording, layout: Layout) -> tuple[Array, dict[str, int]]:
    """(N, n_u) inputs of the bicycle from sensor channels, and how many values of each channel were held or interpolated.

    steer and wheel speeds as measured; steer_rate: slope of steer over RATE_TIME; a_x: du/dt = a_x_imu + v omega_z, or
    the slope of u where there is no accelerometer, or a gap in it. Missing values are interpolated in time.
    Raises ValueError for a layout with an input that a drive cannot give.
    """
    filled, count = _filled(recording)
    known = {
        **filled,
        "steer_rate": _slope(filled["steer"], recording.dt),
        "a_x": _longitudinal(filled, recording),
    }
    missing = [name for name in layout.names if name not in known]
    if missing:
        raise ValueError(f"{recording.name}: expected a model whose inputs a drive can give; it has no {missing[0]!r}")
    return np.column_stack([known[name] for name in layout.names]), count


def _filled(recording: Recording) -> tuple[dict[str, Array], dict[str, int]]:
    filled, count = {}, {}
    for name, values in recording.channels.items():
        bad = ~np.isfinite(values)
        if name in ("a_x_imu", "a_y_imu"):
            bad |= np.abs(values) > MOST_ACCELERATION
        if bad.all():
            continue
        if bad.any():
            values = np.interp(recording.t, recording.t[~bad], values[~bad])
            count[name] = int(bad.sum())
        filled[name] = values
    return filled, count


def _slope(values: Array, dt: float) -> Array:
    window = 2 * min(max(round(0.5 * RATE_TIME / dt), 1), 2) + 1
    if len(values) < window:
        return np.gradient(values, dt) if len(values) > 1 else np.zeros_like(values)
    return savgol_filter(values, window, 1, deriv=1, delta=dt)


def _longitudinal(filled: dict[str, Array], recording: Recording) -> Array:
    """du/dt (m/s^2), (N,): by the accelerometer, a_x_imu + v omega_z, and where it is missing the slope of u."""
    known = accelerometer_known(recording) & ("a_x_imu" in filled)
    measured = filled["a_x_imu"] + filled["v"] * filled["omega_z"] if known.any() else np.zeros(len(recording))
    if known.all():
        return measured
    window = min(2 * round(0.1 / recording.dt) + 1, len(filled["u"]) // 2 * 2 - 1)
    return np.where(known, measured, savgol_filter(filled["u"], max(window, 3), 1, deriv=1, delta=recording.dt))
