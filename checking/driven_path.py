"""Where a vehicle drove, also between and beyond its positions: the integrated velocities, moved by what was measured."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.signal import savgol_filter

from softsoil.recording.clock import unwrapped
from softsoil.recording.drive import Array, Recording
from softsoil.recording.evidence import filled
from softsoil.recording.geometry import Geometry

SMOOTHED = 2.0
"""s: the position is that of the integrated velocities, moved by what is measured over so long."""
PAUSE, STEPS = 0.5, 3.0
"""s, and steps of time, between two rows beyond which nothing is integrated: the logger was off."""


def driven_path(recording: Recording, geometry: Geometry) -> tuple[Array, float]:
    """(N, 2) the middle of the front axle (m), and the standard deviation of its noise, white: that of wander is not seen.

    geometry: of the vehicle; without v the middle of its rear axle is taken not to slide. Each part between pauses by itself; NaN
    in one without a position.
    """
    t, psi = recording.t, unwrapped_heading(recording)
    u, omega = (filled(recording[name]) for name in ("u", "omega_z"))
    aside = (filled(recording["v"]) if recording.measured("v") else geometry.l_r * omega) + geometry.l_f * omega
    speed = np.column_stack([u * np.cos(psi) - aside * np.sin(psi), u * np.sin(psi) + aside * np.cos(psi)])
    path, noise = np.full_like(speed, np.nan), 0.0
    size = 2 * round(0.5 * SMOOTHED / recording.dt) + 1
    for part in _parts(recording):
        moved = np.zeros_like(speed[part])
        moved[1:] = np.cumsum(0.5 * (speed[part][1:] + speed[part][:-1]) * np.diff(t[part])[:, None], axis=0)
        for i, name in enumerate(("x", "y")):
            measured = recording[name][part]
            seen = np.isfinite(measured)
            if not seen.any():
                continue
            off = filled(measured - moved[:, i])
            path[part, i] = moved[:, i] + (savgol_filter(off, size, 1) if 3 <= size <= len(off) else off)
            share = max(float(seen.mean()) * size, 1.0)
            noise = max(noise, float(np.std((measured - path[part, i])[seen])) / np.sqrt(share))
    return path, noise


def way_to_position(recording: Recording) -> NDArray[np.float64]:
    """(N,) metres driven, forwards or back, between each row and the nearest one of its part at which the position was measured;
    infinite in a part without one."""
    speed = np.abs(filled(recording["u"]))
    way = np.full(len(speed), np.inf)
    there = np.isfinite(recording["x"]) & np.isfinite(recording["y"])
    for part in _parts(recording):
        at = np.flatnonzero(there[part])
        if not len(at):
            continue
        along = np.concatenate([[0.0], np.cumsum(0.5 * (speed[part][1:] + speed[part][:-1]) * np.diff(recording.t[part]))])
        after = np.minimum(np.searchsorted(at, np.arange(len(along))), len(at) - 1)
        before = np.maximum(after - 1, 0)
        way[part] = np.min([np.abs(along - along[at[some]]) for some in (before, after)], axis=0)
    return way


def unwrapped_heading(recording: Recording) -> Array:
    """(N,) the heading, unwrapped where it was measured and then filled in between (rad)."""
    return filled(unwrapped("psi", recording["psi"]))


def _parts(recording: Recording) -> list[slice]:
    """The rows between pauses of the logger."""
    t = recording.t
    borders = [0, *(np.flatnonzero(np.diff(t) > max(PAUSE, STEPS * recording.dt)) + 1).tolist(), len(t)]
    return [slice(a, b) for a, b in zip(borders[:-1], borders[1:], strict=True)]
