"""Channels that a log lacks, derived from those it has and marked so: heading, lateral velocity, position, wheel speeds.

The least is time, speed, yaw rate and steering angle. A derived channel lets a model start and run; it judges nothing.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from softsoil.recording.clock import on_even_clock, unwrapped
from softsoil.recording.drive import WHEEL_CHANNELS, Array, ChannelState, Recording
from softsoil.recording.evidence import SPIKE, Motion, interpolated, regress
from softsoil.recording.forward import near_samples
from softsoil.recording.geometry import Geometry, corners, radius_of
from softsoil.recording.laid_heading import laid_heading

SLOPE = 0.4
"""s: straight line through positions that gives a velocity."""
POSE_TIME, BLIND_TIME = 0.5, 2.0
"""s: above this time scale v follows the positions, or the rear axle where there are none; below it, the accelerometer."""
NO_ACCELEROMETER_TIME = 0.1
"""s: the same where there is no accelerometer."""
REAR_COMPLIANCE = 0.03
"""rad per m/s^2: slip angle of the rear axle per lateral acceleration, where no accelerometer says more."""
LEAST_DRIVE = 0.3
"""m/s: speed below which no velocity is divided by."""


def completed(recording: Recording, geometry: Geometry) -> Recording:
    """The drive with every channel that a model needs: absent ones derived, marked and noted; unchanged where none is absent.

    geometry: of the vehicle. Raises ValueError where speed, yaw rate or steering angle is absent.
    """
    for name in ("u", "omega_z", "steer"):
        if recording.state_of(name) == "absent":
            raise ValueError(f"{recording.name}: expected at least t, u, omega_z and steer; found no {name}")
    missing = [n for n in ("x", "y", "psi", "v", *WHEEL_CHANNELS) if recording.state_of(n) == "absent"]
    if not missing:
        return recording
    log = on_even_clock(recording)
    channels, state, notes = dict(log.channels), dict(log.state), list(log.notes)
    alone = "stands alone"

    def add(name: str, values: Array, how: str) -> None:
        left = "set aside" if name in log and np.isfinite(log[name]).any() else "not in the log"
        why = left if log.state_of(name) == "absent" else f"set aside, since it {alone}"
        channels[name], state[name] = values, "derived"
        notes.append(f"{name}: {why}; {how}")

    omega, u = _filled(log["omega_z"]), _filled(log["u"])
    if "v" in missing:
        add("v", *_lateral(log, geometry, u, omega))
    v = _filled(channels["v"])
    if "psi" in missing:
        laid = laid_heading(log["x"], log["y"], u, v + geometry.l_f * omega, omega, log.dt) if log.measured("x", "y") else None
        if laid is None or laid.scattered:
            add("psi", np.cumsum(omega) * log.dt, "the integral of the yaw rate, from zero")
            if log.measured("x", "y"):
                missing, alone = [*missing, "x", "y"], "says no direction of a heading that is not in the log"
        else:
            add("psi", laid.psi, "the integral of the yaw rate, aligned with the positions")
    psi = _heading(channels["psi"])
    if "x" in missing or "y" in missing:
        aside = v + geometry.l_f * omega
        for name, rate in (("x", u * np.cos(psi) - aside * np.sin(psi)), ("y", u * np.sin(psi) + aside * np.cos(psi))):
            add(name, np.cumsum(rate) * log.dt, "dead reckoning from speed and heading, from zero")
    absent = [name for name in WHEEL_CHANNELS if name in missing]
    if absent:
        rolling = _rolling(u, omega, _filled(log["steer"]), v, geometry)
        channels |= {name: rolling[name] for name in absent}
        state |= dict.fromkeys(absent, "derived")
        notes.append(f"{', '.join(absent)}: not in the log; they roll freely here and slip in the model")
    return replace(log, channels=channels, state=state, notes=tuple(notes))


def derived_of(recording: Recording, names: tuple[str, ...]) -> tuple[str, ...]:
    """Those of the channels `names` that are not measured, in order."""
    return tuple(name for name in names if not recording.measured(name))


def mark(recording: Recording, state: ChannelState, *names: str) -> Recording:
    """The recording with the channels called `names` marked as `state`."""
    return replace(recording, state={**recording.state, **dict.fromkeys(names, state)})


def _filled(values: Array) -> Array:
    return interpolated(np.concatenate([_first(values), values, _first(values[::-1])]), len(values) + 2)[1:-1]


def _first(values: Array) -> Array:
    return values[np.isfinite(values)][:1]


def _heading(psi: Array) -> Array:
    return _filled(unwrapped("psi", psi))


def _lateral(log: Recording, geometry: Geometry, u: Array, omega: Array) -> tuple[Array, str]:
    """v by a kinematic smoother, and how: least squares of v - m and dv/dt - (a_y - u omega_z), m by positions or rear axle."""
    dt = log.dt
    force = np.where(np.abs(log["a_y_imu"]) > SPIKE, np.nan, log["a_y_imu"]) if log.measured("a_y_imu") else None
    force = None if force is None or not np.isfinite(force).any() else _filled(force)
    posed = _posed(log)
    compliance = _compliance(log, geometry)
    known: Array = geometry.l_r * omega - compliance * u * np.abs(u) * omega
    rear = f"the rear axle's course with a slip angle of {compliance:.3f} rad per m/s^2"
    how = rear
    if posed.any():
        psi = _heading(log["psi"])
        rate_x, rate_y = (_sliding_slope(_filled(log[name]), dt) for name in ("x", "y"))
        known = np.where(posed, -rate_x * np.sin(psi) + rate_y * np.cos(psi) - geometry.l_f * omega, known)
        blind = f", for {(~posed).sum() * dt:.3g} s without them {rear}" if not posed.all() else ""
        how = f"the positions' motion across the heading{blind}"
    change = np.zeros(len(log)) if force is None else (force - u * omega)
    if force is not None:
        change = change - change.mean()  # v is bounded: what is left of the mean is the accelerometer's bias
        how += ", and the accelerometer between"
    time = np.where(posed, POSE_TIME, BLIND_TIME) if force is not None else np.full(len(log), NO_ACCELEROMETER_TIME)
    return _smoother(known, (dt / time) ** 2, change * dt), how


def _posed(log: Recording) -> NDArray[np.bool_]:
    """(N,) whether each row lies among measured positions and headings in their usual intervals; no row does in a drive too
    short for a slope of them, or with fewer than two of any."""
    names = ("x", "y", "psi")
    if not log.measured(*names) or len(log) <= 2 * _half(log.dt) or min(np.isfinite(log[name]).sum() for name in names) < 2:
        return np.zeros(len(log), dtype=bool)
    near = np.logical_and.reduce([near_samples(log.t, log.t[np.isfinite(log[name])]) for name in names])
    # At the rim of a gap the slope would be that of a line across it.
    return np.convolve(~near, np.ones(2 * _half(log.dt) + 1), "same") < 0.5


def _compliance(log: Recording, geometry: Geometry) -> float:
    """Slip angle of the rear axle per lateral acceleration, c (rad s^2/m): dv/dt = a_y - u omega_z, v = (l_r - c u^2) omega_z."""
    m = Motion.of(log)
    omega, u, a_y = m.channel("omega_z"), m.channel("u"), m.channel("a_y_imu")
    if not np.isfinite(a_y).any():
        return REAR_COMPLIANCE
    change = m.slope(m.integral(a_y - u * omega)) - geometry.l_r * m.slope(omega)
    line = regress(m.driven(change), -m.slope(u * u * omega), np.ones(m.windows))
    if line is None or not line.std[0] < 0.02:
        return REAR_COMPLIANCE
    return float(np.clip(line.value[0], 0.0, 0.1))


def _sliding_slope(values: Array, dt: float) -> Array:
    """(N,) slope of a straight line through SLOPE seconds around each sample, SLOPE at least five samples."""
    half = _half(dt)
    clock = np.arange(-half, half + 1) * dt
    weight = clock / float(clock @ clock)
    padded = np.concatenate([2 * values[0] - values[half:0:-1], values, 2 * values[-1] - values[-2 : -half - 2 : -1]])
    return np.convolve(padded, weight[::-1], mode="valid")


def _half(dt: float) -> int:
    """Samples on each side of the one whose slope is taken."""
    return max(round(SLOPE / dt / 2), 2)


def _smoother(known: Array, weight: Array, steps: Array) -> Array:
    """(N,) v that minimises sum weight (v - known)^2 + sum (v[k+1] - v[k] - steps[k])^2: one tridiagonal solve."""
    count = len(known)
    diagonal = weight + 2.0
    diagonal[[0, -1]] -= 1.0
    right = weight * known
    right[1:] += steps[:-1]
    right[:-1] -= steps[:-1]
    upper, value = [0.0] * count, [0.0] * count
    above, below = 0.0, 0.0
    for k, (d, r) in enumerate(zip(diagonal.tolist(), right.tolist(), strict=True)):
        pivot = d + above
        above = -1.0 / pivot
        below = (r + below) / pivot
        upper[k], value[k] = above, below
    for k in range(count - 2, -1, -1):
        value[k] -= upper[k] * value[k + 1]
    return np.array(value)


def _rolling(u: Array, omega: Array, steer: Array, v: Array, geometry: Geometry) -> dict[str, Array]:
    """Speeds of wheels that roll freely as the vehicle moves (rad/s)."""
    speeds = {}
    for name, (x, y, steered) in corners(geometry).items():
        angle = steer if steered else 0.0
        centre = (u - y * omega) * np.cos(angle) + (v + x * omega) * np.sin(angle)
        speeds[name] = np.maximum(centre, LEAST_DRIVE) / radius_of(geometry, name)
    return speeds
