"""Where a vehicle drove, also between and beyond its positions: the integrated velocities, moved by what was measured."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.signal import savgol_filter

from softsoil.recording.drive import Array, Recording
from softsoil.recording.evidence import filled
from softsoil.recording.geometry import Geometry

SMOOTHED = 2.0
"""s: the position is that of the integrated velocities, moved by what is measured over so long."""


def driven_path(recording: Recording, geometry: Geometry) -> tuple[Array, float]:
    """(N, 2) the middle of the front axle (m), and the standard deviation of its noise, white: that of wander is not seen.

    geometry: of the vehicle; without v the middle of its rear axle is taken not to slide.
    """
    t, psi = recording.t, np.unwrap(filled(recording["psi"]))
    u, omega = (filled(recording[name]) for name in ("u", "omega_z"))
    aside = (filled(recording["v"]) if recording.measured("v") else geometry.l_r * omega) + geometry.l_f * omega
    speed = np.column_stack([u * np.cos(psi) - aside * np.sin(psi), u * np.sin(psi) + aside * np.cos(psi)])
    moved = np.zeros_like(speed)
    moved[1:] = np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(t)[:, None], axis=0)
    size = 2 * round(0.5 * SMOOTHED / recording.dt) + 1
    path, noise = np.empty_like(moved), 0.0
    for i, name in enumerate(("x", "y")):
        seen = np.isfinite(recording[name])
        off = filled(recording[name] - moved[:, i])
        path[:, i] = moved[:, i] + (savgol_filter(off, size, 1) if 3 <= size <= len(off) else off)
        share = max(float(seen.mean()) * size, 1.0)
        noise = max(noise, float(np.std((recording[name] - path[:, i])[seen])) / np.sqrt(share))
    return path, noise


def way_to_position(recording: Recording) -> NDArray[np.float64]:
    """(N,) metres driven, forwards or back, between each row and the nearest one at which the position was measured."""
    speed = np.abs(filled(recording["u"]))
    along = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(recording.t))])
    at = np.flatnonzero(np.isfinite(recording["x"]) & np.isfinite(recording["y"]))
    if not len(at):
        return np.full(len(along), np.inf)
    after = np.minimum(np.searchsorted(at, np.arange(len(along))), len(at) - 1)
    before = np.maximum(after - 1, 0)
    return np.min([np.abs(along - along[at[some]]) for some in (before, after)], axis=0)
