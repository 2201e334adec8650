"""The kinematic bicycle: a vehicle that is too slow for its forces to be evaluated still goes where its wheels roll."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from softsoil.symbolic.model import Model

Array = NDArray[np.float64]


class Rolling:
    """A step of a terrain model's motion without forces; the generated C library has the same (`stand` in softsoil_filter.c).

    The rates of x, y and psi are those of eq. (bicycle); v and omega_z go to l_r and 1 times u tan(steer) / (l_f + l_r), those
    of wheels that do not slip, in the time `fade` (s); u follows the commanded acceleration. Where the wheels stand the place is
    held and the velocities go to zero in the same time.
    """

    def __init__(self, model: Model, fade: float) -> None:
        self._x, self._y, self._psi, self._u, self._v, self._turn = (
            model.x.index(name) for name in ("x", "y", "psi", "u", "v", "omega_z")
        )
        self._steer, self._a_x = model.external.index("steer"), model.external.index("a_x")
        self._size, self._fade = len(model.x), fade
        vehicle = model.geometry
        self._l_f, self._l_r, self._lock = vehicle.l_f, vehicle.l_r, vehicle.max_steer

    def step(self, x: Array, inputs: Array, dt: float, turning: bool) -> tuple[Array, Array]:
        """(n_x,) states after dt (s) from x (n_x,), and (n_x, n_x) their derivatives by x; inputs (n_u,); turning: the wheels."""
        keep = math.exp(-dt / self._fade)
        share, x = np.eye(self._size), x.copy()
        share[self._v, self._v] = share[self._turn, self._turn] = keep
        if turning:
            cos, sin = math.cos(x[self._psi]), math.sin(x[self._psi])
            steer = min(max(float(inputs[self._steer]), -self._lock), self._lock)
            curvature = math.tan(steer) / (self._l_f + self._l_r)
            place, velocities = [self._x, self._y], [self._u, self._v, self._turn, self._psi]
            u, v_axle = x[self._u], x[self._v] + self._l_f * x[self._turn]
            ahead, left = u * cos - v_axle * sin, u * sin + v_axle * cos
            share[np.ix_(place, velocities)] = dt * np.array(
                [[cos, -sin, -sin * self._l_f, -left], [sin, cos, cos * self._l_f, ahead]]
            )
            share[self._psi, self._turn] = dt
            share[self._v, self._u] = (1.0 - keep) * self._l_r * curvature
            share[self._turn, self._u] = (1.0 - keep) * curvature
            x[place] += dt * np.array([ahead, left])
            x[self._psi] += dt * x[self._turn]
            x[self._v] = keep * x[self._v] + share[self._v, self._u] * u
            x[self._turn] = keep * x[self._turn] + share[self._turn, self._u] * u
            x[self._u] += dt * inputs[self._a_x]
        else:
            share[self._u, self._u] = keep
            x[[self._u, self._v, self._turn]] *= keep
        return x, share
