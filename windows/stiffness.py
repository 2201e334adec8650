"""How many Euler steps a sample needs: a stiff contact turns a slow or small vehicle faster than its log is sampled."""

from __future__ import annotations

import math
from collections.abc import Sequence

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from softsoil.symbolic.model import Model
from softsoil.windows.shooting import Drive

LONGEST_PART, MOST_PARTS = 1.0, 12
"""Euler step times the fastest rate of v and omega_z, of which 2 is the limit of stability; most steps in a sample."""
EVERY = 10
"""Samples between those at which rates are looked at."""


def needed_substeps(model: Model, drives: Sequence[Drive], p: NDArray[np.float64]) -> int:
    """Euler steps in a sample that keep the lateral motion stable along the drives: with lambda the eigenvalues of
    d(dv/dt, domega_z/dt)/d(v, omega_z), dt |lambda| / LONGEST_PART.

    model: without histories; p (D, n_p): its parameters on each drive.
    """
    x, u, free = model.symbols()
    moving = [model.x.index(name) for name in ("v", "omega_z")]
    jacobian = ca.Function("lateral", [x, u, free], [ca.jacobian(model.ode()(x, u, free)[moving], x[moving])])
    most = 0.0
    for drive, row in zip(drives, p, strict=True):
        rows = np.flatnonzero(drive.driven[drive.first :])[::EVERY] + drive.first
        if not len(rows):
            continue
        found = jacobian(drive.smooth[rows].T, drive.inputs[rows].T, row).full().reshape(2, -1, 2)
        most = max(most, drive.dt * float(np.abs(np.linalg.eigvals(np.moveaxis(found, 1, 0))).max()))
    return min(max(math.ceil(most / LONGEST_PART), 1), MOST_PARTS)
