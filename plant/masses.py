"""Masses of the vehicle and what they feel: gravity, the accelerations of points that turn with the chassis, their inertia in the
equations of motion, and the payload's part.
"""

from __future__ import annotations

import math

import numpy as np

from softsoil.plant.kernel import inner

GRAVITY = 9.81
"""m/s^2"""


@inner
def cross(a, b, out):
    """out = a x b"""
    out[0] = a[1] * b[2] - a[2] * b[1]
    out[1] = a[2] * b[0] - a[0] * b[2]
    out[2] = a[0] * b[1] - a[1] * b[0]


@inner
def solve_positive(matrix, rhs):
    """Solve in place for a symmetric positive matrix by elimination; the answer is left in rhs."""
    n = rhs.shape[0]
    for k in range(n):
        for i in range(k + 1, n):
            f = matrix[i, k] / matrix[k, k]
            if f != 0.0:
                for j in range(k, n):
                    matrix[i, j] -= f * matrix[k, j]
                rhs[i] -= f * rhs[k]
    for k in range(n - 1, -1, -1):
        for j in range(k + 1, n):
            rhs[k] -= matrix[k, j] * rhs[j]
        rhs[k] /= matrix[k, k]


@inner
def gravity_at(slope, x, out):
    """Gravity in world axes over ground that is banked (with a wave along x) and graded."""
    bank = slope[0] + slope[2] * math.sin(2.0 * math.pi * x / slope[3])
    out[0] = -GRAVITY * math.sin(slope[1])
    out[1] = -GRAVITY * math.sin(bank)
    out[2] = -math.sqrt(max(GRAVITY * GRAVITY - out[0] * out[0] - out[1] * out[1], 0.0))


@inner
def add_point_mass(matrix, rhs, mass, r, velocity_rate, path, column):
    """Add a point mass; velocity_rate: its acceleration without that of the speeds; path: dr/dq or none."""
    for i in range(3):
        matrix[i, i] += mass
        rhs[i] -= mass * velocity_rate[i]
    # omega' x r = -[r x] omega'; its transpose takes forces to moments.
    skew = np.array([[0.0, -r[2], r[1]], [r[2], 0.0, -r[0]], [-r[1], r[0], 0.0]])
    for i in range(3):
        for j in range(3):
            matrix[i, 3 + j] -= mass * skew[i, j]
            matrix[3 + i, j] += mass * skew[i, j]
            rhs[3 + i] -= mass * skew[i, j] * velocity_rate[j]
            for k in range(3):
                matrix[3 + i, 3 + j] -= mass * skew[i, k] * skew[k, j]
    if column >= 0:
        for i in range(3):
            matrix[i, column] += mass * path[i]
            matrix[column, i] += mass * path[i]
            matrix[column, column] += mass * path[i] * path[i]
            rhs[column] -= mass * path[i] * velocity_rate[i]
            for j in range(3):
                matrix[3 + i, column] += mass * skew[i, j] * path[j]
                matrix[column, 3 + i] += mass * skew[i, j] * path[j]


@inner
def convective(omega, velocity, r, relative, out):
    """omega x V + omega x (omega x r) + 2 omega x r', the acceleration that needs no rate of the speeds."""
    inner = np.empty(3)
    cross(omega, r, inner)
    for i in range(3):
        inner[i] += velocity[i] + 2.0 * relative[i]
    cross(omega, inner, out)


@inner
def sprung_body(machine, world, velocity, omega, gravity_body, matrix, rhs, bias, zero):
    """Chassis and payload: inertia, gyroscopic moment and weight."""
    momentum, moment = np.zeros(3), np.empty(3)
    for i in range(3):
        for j in range(3):
            momentum[i] += machine.sprung_inertia[i, j] * omega[j]
    cross(omega, momentum, moment)
    for i in range(3):
        rhs[3 + i] -= moment[i]
        for j in range(3):
            matrix[3 + i, 3 + j] += machine.sprung_inertia[i, j]
    convective(omega, velocity, zero, zero, bias)
    for i in range(3):
        bias[i] -= gravity_body[i]
    add_point_mass(matrix, rhs, machine.sprung_mass, zero, bias, zero, -1)
    if world.payload[0] > 0.0:
        convective(omega, velocity, world.payload[1:], zero, bias)
        for i in range(3):
            bias[i] -= gravity_body[i]
        add_point_mass(matrix, rhs, world.payload[0], world.payload[1:], bias, zero, -1)


@inner
def without_payload(world, chassis, rates, extra):
    """Take what carries the payload off the force in extra[:3]: an accelerometer stays with the vehicle's own masses."""
    apart, swing = np.empty(3), np.empty(3)
    convective(chassis.omega, chassis.velocity, world.payload[1:], np.zeros(3), apart)
    cross(rates[3:6], world.payload[1:], swing)
    for j in range(3):
        force = world.payload[0] * (apart[j] + swing[j] + rates[j] - chassis.gravity[j])
        for i in range(3):
            extra[i] -= chassis.turn[i, j] * force
