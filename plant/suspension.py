"""Wheel carriers on their links: pose from polynomials, springs, dampers and roll bars as forces along the travel."""

from __future__ import annotations

from softsoil.plant.driveline import curve
from softsoil.plant.kernel import inner, kernel
from softsoil.plant.kinematics import QUANTITIES

CENTRE, AXLE_X, AXLE_Z, TURN, STEER_TURN, STRUT, LINK, ROD = 0, 3, 4, 5, 8, 11, 12, 13
"""First column of each group in the polynomials of softsoil.plant.kinematics."""
COUNT = len(QUANTITIES)
"""Columns in all."""

STOP = 0.085
"""Travel at which a stiff stop begins (m)."""
STOP_STIFFNESS = 2e5
"""Of the stop (N/m)."""


@kernel
def carrier(path, q, theta, value, per_travel, per_angle):
    """Write the 14 quantities of one wheel and their rates per travel and per pitman angle; path: (14, 6, 6)."""
    n = path.shape[1]
    for m in range(path.shape[0]):
        v = 0.0
        dq = 0.0
        dt = 0.0
        for i in range(n - 1, -1, -1):
            inner = 0.0
            slope = 0.0
            for j in range(n - 1 - i, -1, -1):
                slope = slope * theta + inner
                inner = inner * theta + path[m, i, j]
            dq = dq * q + v
            v = v * q + inner
            dt = dt * q + slope
        value[m] = v
        per_travel[m] = dq
        per_angle[m] = dt


@kernel
def strut_force(machine, wheel, length, rate, damper_factor):
    """Force of spring and damper (N), compression positive."""
    if wheel < 2:
        force = curve(machine.spring_front, length - machine.free_length[wheel])
        return force - damper_factor * curve(machine.damper_front, rate)
    force = curve(machine.spring_rear, length - machine.free_length[wheel])
    return force - damper_factor * curve(machine.damper_rear, rate)


@inner
def stop_force(q):
    """Force of the travel stops along the travel (N)."""
    if q > STOP:
        return -STOP_STIFFNESS * (q - STOP)
    if q < -STOP:
        return -STOP_STIFFNESS * (q + STOP)
    return 0.0


@inner
def bar_forces(machine, axle, factor, left, right, left_rate, right_rate):
    """Force (N, up) of a roll bar on its left drop link, the opposite on the right, from the links' heights and
    rates."""
    stiffness, damping, lever = machine.bar[axle, 0], machine.bar[axle, 1], machine.bar[axle, 2]
    twist, rate = (left - right) / lever, (left_rate - right_rate) / lever
    return -factor * (stiffness * twist + damping * rate) / lever
