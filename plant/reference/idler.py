"""The reference simulator's idler arm, whose joint breaks Newton's third law: what it carries, and the moment that is wrong."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from softsoil.plant.kernel import inner

Array = NDArray[np.float64]


def idler_of(table: dict[str, Any]) -> tuple[Array, Array]:
    """Where the idler arm's pivot is and what it carries; nothing for a steering without one."""
    steering = table["steering"]
    if "idler_pivot" not in steering and not steering.get("idler_error"):
        return np.zeros(3), np.zeros(3)
    pivot = np.array(steering["idler_pivot"], dtype=float)
    ends = 0.5 * table["front"]["tie_rod_chassis"][1] / pivot[1]
    return pivot - table["chassis"]["position"], np.array([0.5 * steering["link_mass"], -0.5 - ends, ends - 0.5])


@inner
def idler_moment(machine, theta, weight, left, right, out):
    """Add to out the moment (N m) on the chassis by which the reference's idler arm breaks Newton's third law.

    The idler holds the steering link up: half its weight and, since the link may roll about its other end, nearly all
    of what the right tie rod, which slopes, pulls it down by. That force comes back to the chassis at the link's end,
    p + d from the chassis's centre of gravity (p: the idler's pivot, d: the idler, z: its axis); the reference has u x p,
    u along the idler, where z x d should be. weight: of a kilogram (N); left, right: upward forces of the tie rods on
    the link (N). The arms turn against theta, which is positive to the left: the rods stand behind the axle.
    """
    force = machine.idler_load[0] * weight + machine.idler_load[1] * left + machine.idler_load[2] * right
    c, s = math.cos(theta), -math.sin(theta)
    p, d = machine.idler_pivot, machine.link_arm
    share = machine.idler_error * force
    out[0] -= share * (s * p[2] - d * s)
    out[1] -= share * (d * c - c * p[2])
    out[2] -= share * (c * p[1] - s * p[0])
