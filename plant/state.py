"""The plant's state vector: where each quantity stands in it, its start values, and what its kernels derive from it together."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from softsoil.plant.effects import MAX_DELAY_STEPS
from softsoil.plant.kernel import inner, kernel

POSITION = 0  # 3: sprung centre of gravity, world (m)
QUATERNION = 3  # 4: chassis to world, scalar first
VELOCITY = 7  # 3: of the sprung centre of gravity, chassis axes (m/s)
RATE = 10  # 3: angular velocity, chassis axes (rad/s)
TRAVEL = 13  # 4: suspension travel, up positive (m)
TRAVEL_RATE = 17  # 4 (m/s)
PITMAN = 21  # angle of the pitman arm (rad), left positive
PITMAN_RATE = 22
SPIN = 23  # 4: wheel speeds, forward positive (rad/s)
SPIN_ANGLE = 27  # 4 (rad)
GEAR = 31  # counted from 0
STEER_LAGGED = 32  # road-wheel angle after lag (rad)
STEER_PLAY = 33  # and after backlash (rad)
TIME = 34  # s
STEPS = 35  # counted since the start
RING = 36  # MAX_DELAY_STEPS: past steering commands (rad)
SIZE = RING + MAX_DELAY_STEPS

Array = NDArray[np.float64]


class Body(NamedTuple):
    """The chassis: turn (3, 3) to world axes; velocity (m/s), omega (rad/s) and gravity (m/s^2) in its own, each (3,)."""

    turn: Any
    velocity: Any
    omega: Any
    gravity: Any


class Place(NamedTuple):
    """A carrier on its path: value (COUNT,) and its derivatives by travel and the arm's angle; theta_rate: the arm's (rad/s)."""

    value: Any
    by_q: Any
    by_angle: Any
    theta_rate: float


@kernel
def rotation(state, out):
    """Write the (3, 3) matrix that turns chassis axes into world axes."""
    w, x, y, z = state[QUATERNION], state[QUATERNION + 1], state[QUATERNION + 2], state[QUATERNION + 3]
    out[0, 0], out[0, 1], out[0, 2] = 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)
    out[1, 0], out[1, 1], out[1, 2] = 2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)
    out[2, 0], out[2, 1], out[2, 2] = 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)


@inner
def advance_pose(state, turn, dt):
    """Position and attitude over dt with the present velocities (turn: the present rotation)."""
    for i in range(3):
        for j in range(3):
            state[POSITION + i] += dt * turn[i, j] * state[VELOCITY + j]
    a, b, c = 0.5 * dt * state[RATE], 0.5 * dt * state[RATE + 1], 0.5 * dt * state[RATE + 2]
    w, x, y, z = state[QUATERNION], state[QUATERNION + 1], state[QUATERNION + 2], state[QUATERNION + 3]
    nw, nx = w - x * a - y * b - z * c, x + w * a + y * c - z * b
    ny, nz = y + w * b + z * a - x * c, z + w * c + x * b - y * a
    norm = np.sqrt(nw * nw + nx * nx + ny * ny + nz * nz)
    state[QUATERNION], state[QUATERNION + 1] = nw / norm, nx / norm
    state[QUATERNION + 2], state[QUATERNION + 3] = ny / norm, nz / norm


def quaternion(yaw: float, pitch: float, roll: float) -> Array:
    """(4,) attitude, scalar first: roll about x, then pitch about y, then yaw about z (ISO 8855, rad)."""
    cy, sy, cp, sp, cr, sr = (f(0.5 * a) for a in (yaw, pitch, roll) for f in (np.cos, np.sin))
    return np.array(
        [
            cr * cp * cy + sr * sp * sy,
            sr * cp * cy - cr * sp * sy,
            cr * sp * cy + sr * cp * sy,
            cr * cp * sy - sr * sp * cy,
        ]
    )


def blank_state() -> Array:
    """(SIZE,) at the origin, level and at rest."""
    state = np.zeros(SIZE)
    state[QUATERNION] = 1.0
    return state
