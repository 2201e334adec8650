"""What a drive records of the plant: the sensor channels and the truth behind them, one row per sample."""

from __future__ import annotations

import math

import numpy as np

from softsoil.plant.kernel import kernel
from softsoil.plant.state import PITMAN, POSITION, RATE, SPIN, TIME, TRAVEL, TRAVEL_RATE, VELOCITY, rotation
from softsoil.plant.suspension import COUNT, carrier
from softsoil.recording.drive import CHANNEL_UNITS

WHEELS = ("fl", "fr", "rl", "rr")
_PER_WHEEL = ("fx", "fy", "fz", "vx", "vy", "z")
TRUTH = (
    "true_delta_fl", "true_delta_fr", "true_roll", "true_pitch", "true_z_cg",
    *(f"true_{name}_{wheel}" for wheel in WHEELS for name in _PER_WHEEL),
    "true_x_cg", "true_y_cg",
    *(f"true_sinkage_{wheel}" for wheel in WHEELS),
)  # fmt: skip
"""Truth columns: names of the shared drives, and the sinkage of each wheel (m)."""
COLUMNS = (*CHANNEL_UNITS, *TRUTH)


@kernel
def observe(state, command, machine, info, extra, row):
    """Write one row of COLUMNS from the state and what the last step reported."""
    turn = np.empty((3, 3))
    rotation(state, turn)
    psi = math.atan2(turn[1, 0], turn[0, 0])
    c, s = math.cos(psi), math.sin(psi)
    omega = state[RATE : RATE + 3]
    # Centre of gravity (without payload): position and velocity from all masses, in chassis axes about the sprung one.
    centre, relative = np.zeros(3), np.zeros(3)
    value, by_q, by_angle = np.empty(COUNT), np.empty(COUNT), np.empty(COUNT)
    for w in range(4):
        carrier(machine.paths[w], state[TRAVEL + w], state[PITMAN], value, by_q, by_angle)
        for i in range(3):
            centre[i] += machine.unsprung_mass[w] / machine.total_mass * value[i]
            relative[i] += machine.unsprung_mass[w] / machine.total_mass * by_q[i] * state[TRAVEL_RATE + w]
    front = machine.front_point
    point, velocity, speed = np.empty(3), np.zeros(3), np.empty(3)
    speed[0] = state[VELOCITY] + relative[0] + omega[1] * centre[2] - omega[2] * centre[1]
    speed[1] = state[VELOCITY + 1] + relative[1] + omega[2] * centre[0] - omega[0] * centre[2]
    speed[2] = state[VELOCITY + 2] + relative[2] + omega[0] * centre[1] - omega[1] * centre[0]
    position = np.empty(3)
    for i in range(3):
        point[i] = position[i] = state[POSITION + i]
        for j in range(3):
            point[i] += turn[i, j] * front[j]
            position[i] += turn[i, j] * centre[j]
            velocity[i] += turn[i, j] * speed[j]
    row[0] = state[TIME]
    row[1], row[2], row[3] = point[0], point[1], psi
    row[4], row[5] = c * velocity[0] + s * velocity[1], -s * velocity[0] + c * velocity[1]
    row[6] = turn[2, 0] * omega[0] + turn[2, 1] * omega[1] + turn[2, 2] * omega[2]
    row[7] = (c * extra[0] + s * extra[1]) / machine.total_mass
    row[8] = (-s * extra[0] + c * extra[1]) / machine.total_mass
    row[9], row[10], row[11] = command[0], command[1], command[2]
    for w in range(4):
        row[12 + w] = state[SPIN + w]
    for w in range(2):
        ax, ay = info[w, 12], info[w, 13]
        row[16 + w] = math.atan2(-(c * ax + s * ay), -s * ax + c * ay)
    row[18] = math.atan2(turn[2, 1], turn[2, 2])
    row[19] = -math.asin(turn[2, 0])
    row[20] = position[2]
    for w in range(4):
        k = 21 + 6 * w
        f = info[w]
        row[k], row[k + 1], row[k + 2] = c * f[0] + s * f[1], -s * f[0] + c * f[1], f[2]
        row[k + 3], row[k + 4], row[k + 5] = c * f[9] + s * f[10], -s * f[9] + c * f[10], f[8]
        row[47 + w] = f[15]
    row[45], row[46] = position[0], position[1]
