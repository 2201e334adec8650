"""Where a solve starts: the last plan moved on in time, or straight on."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from softsoil.control.ocp import Ocp

Array = NDArray[np.float64]
SLOWEST = 1.0
"""m/s: least speed of a plan that drives straight on."""


def straight_on(ocp: Ocp, z0: Array) -> Array:
    """(N + 1, n_z) a plan that goes on from z0 (n_z,) along its heading at its speed, wheels straight."""
    x, y, psi, u = (float(z0[ocp.z.index(name)]) for name in ("x", "y", "psi", "u"))
    speed = max(u, SLOWEST)
    way = speed * ocp.settings.dt * np.arange(ocp.settings.steps + 1)
    z: Array = np.tile(ocp.z.pack(u=speed, psi=psi), (len(way), 1))
    z[:, ocp.z.index("x")], z[:, ocp.z.index("y")] = x + way * np.cos(psi), y + way * np.sin(psi)
    return z


def move_on(array: Array, share: float) -> None:
    """Move the rows of `array` towards the front by a share of a row (linear between rows), the last one kept; in place."""
    whole, rest = int(share), share - int(share)
    if whole:
        array[:-whole] = array[whole:]
        array[-whole:] = array[-1]
    if rest:
        array[:-1] += rest * (array[1:] - array[:-1])
