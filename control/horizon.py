"""What a course asks of the controller over its horizon: the reference along the path, and the obstacles that are watched."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from softsoil.control.ocp import Ocp
from softsoil.control.path import Path

Array = NDArray[np.float64]
RUN_IN = 1.5
"""s: the vehicle's speed runs into the wanted one with this time constant."""
BEHIND, AHEAD = -6.0, 60.0
"""m: obstacles between these, along the vehicle, may be watched."""


def reference(ocp: Ocp, path: Path, along: float, speed: float, z0: Array) -> Array:
    """(N + 1, 4) x, y, psi, u of the path from `along` (m) on at `speed` (m/s), for a vehicle in the state z0 (n_z,)."""
    n, dt = ocp.settings.steps, ocp.settings.dt
    pace = speed + (z0[ocp.z.index("u")] - speed) * np.exp(-dt * np.arange(n) / RUN_IN)
    places = path.at(along + np.concatenate([[0.0], np.cumsum(dt * pace)]))
    places[:, 2] += 2 * np.pi * np.round((z0[ocp.z.index("psi")] - places[0, 2]) / (2 * np.pi))
    return np.column_stack([places, np.full(n + 1, speed)])


def watched(ocp: Ocp, obstacles: Array, t: float, z0: Array, ref: Array) -> Array:
    """(N + 1, n, 3) x, y, radius, over the horizon from t (s) on, of the obstacles that come nearest to the path or are so now.

    obstacles (K, 5): x, y, radius (m) and velocity (m/s) at time 0; z0 (n_z,): the vehicle; ref (N + 1, 4): of `reference`.
    Those that are behind, or have a radius below 0, are left out. Of a row of trees beside the path none takes the place of what
    stands on it.
    """
    n = ocp.settings.steps
    if not len(obstacles):
        return np.zeros((n + 1, 0, 3))
    x, y, psi = (z0[ocp.z.index(name)] for name in ("x", "y", "psi"))
    now = obstacles[:, :2] + t * obstacles[:, 3:]
    ahead = (now - [x, y]) @ np.array([np.cos(psi), np.sin(psi)])
    # What is no number stays: no plan is made around it.
    near = np.flatnonzero(~((ahead <= BEHIND) | (ahead >= AHEAD) | (obstacles[:, 2] < 0.0)))
    times = t + ocp.settings.dt * np.arange(n + 1)
    placed = np.zeros((n + 1, len(near), 3))
    placed[:, :, :2] = obstacles[near, :2] + times[:, None, None] * obstacles[near, 3:]
    placed[:, :, 2] = obstacles[near, 2]
    gaps = np.hypot(placed[:, :, 0] - ref[:, None, 0], placed[:, :, 1] - ref[:, None, 1]).min(axis=0)
    gaps = np.minimum(gaps, np.hypot(placed[0, :, 0] - x, placed[0, :, 1] - y)) - obstacles[near, 2]
    return placed[:, np.argsort(np.nan_to_num(gaps, nan=-np.inf), kind="stable")[: ocp.settings.obstacles]]
