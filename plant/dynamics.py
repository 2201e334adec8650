"""The vehicle on the soil: one step of 11 degrees of freedom and four wheel spins.

Kane's equations in chassis axes, with the generalised speeds V (3), omega (3) of the chassis and the travel rates (4);
the steering arm is the eleventh. The carriers are point masses at the wheel centres r(q, theta), their inertia about a
diameter belongs to the chassis; wheels add the gyroscopic moment of their spin. Soil forces act at the wheel centre
with their moment: its part along the axle turns the wheel, the rest goes through the carrier into the links (so roll
and pitch centres, jacking and bump steer follow from the hardpoints). Half-shaft torques react on the chassis, brakes
on the carrier. Semi-implicit Euler.
"""

from __future__ import annotations

import math

import numpy as np

from softsoil.plant.contact import REACH, wheel_contact
from softsoil.plant.driveline import axle_drive_torque, shift_gear, spin_rates
from softsoil.plant.ground import Motion, Rules
from softsoil.plant.kernel import inner
from softsoil.plant.masses import (
    add_point_mass,
    convective,
    cross,
    gravity_at,
    solve_positive,
    sprung_body,
    without_payload,
)
from softsoil.plant.reference.idler import idler_moment
from softsoil.plant.reference.joints import shaft_reaction
from softsoil.plant.state import (
    GEAR,
    PITMAN,
    PITMAN_RATE,
    POSITION,
    RATE,
    SPIN,
    SPIN_ANGLE,
    STEPS,
    TIME,
    TRAVEL,
    TRAVEL_RATE,
    VELOCITY,
    Body,
    Place,
    advance_pose,
    rotation,
)
from softsoil.plant.steering import advance_pitman, rods_lift, steering_target
from softsoil.plant.suspension import (
    AXLE_X,
    AXLE_Z,
    COUNT,
    LINK,
    STEER_TURN,
    STRUT,
    TURN,
    bar_forces,
    carrier,
    stop_force,
    strut_force,
)

INFO = 17
"""Columns per wheel of what a step reports, in world axes: soil force (3), its moment (3), wheel centre (3), its velocity
(3), axle (3); greatest sinkage (m); drive torque (N m)."""
EXTRA = 7
"""And of the vehicle without its payload: force but gravity (3); gravity (3); engine torque at the axle (N m)."""


@inner
def add_force(rhs, force, r):
    """Add a force at r, both in chassis axes."""
    moment = np.empty(3)
    cross(r, force, moment)
    for i in range(3):
        rhs[i] += force[i]
        rhs[3 + i] += moment[i]


@inner
def _external(state, machine, world, turn, gravity, rhs, extra):
    """Forces that are neither soil nor suspension: side force, wind, drag, yaw moment (payload's weight is with its
    mass)."""
    force, r = np.empty(3), np.empty(3)
    force[:] = 0.0
    force[1] = world.force_body[0]
    for i in range(3):
        r[i] = world.force_body[1 + i]
    add_force(rhs, force, r)
    for i in range(3):
        extra[i] += turn[i, 1] * force[1]
    for i in range(3):
        force[i] = turn[0, i] * world.force_world[0] + turn[1, i] * world.force_world[1]
        r[i] = world.force_world[2 + i]
    add_force(rhs, force, r)
    extra[0] += world.force_world[0]
    extra[1] += world.force_world[1]
    speed = state[VELOCITY]
    force[:] = 0.0
    force[0] = -world.drag[0] * math.tanh(speed / 0.1) - world.drag[1] * speed * abs(speed)
    r[:] = 0.0
    add_force(rhs, force, r)
    for i in range(3):
        extra[i] += turn[i, 0] * force[0]
        rhs[3 + i] += turn[2, i] * world.moment_z


@inner
def step_vehicle(state, command, machine, world, ground, dt, info, extra):
    """Advance the vehicle and the soil by dt; report the forces at the step's start in info (4, INFO) and extra
    (EXTRA,).

    command: steering (rad, what the road wheels are asked for), throttle and brake in [0, 1].
    """
    turn = np.empty((3, 3))
    rotation(state, turn)
    velocity, omega = state[VELOCITY : VELOCITY + 3].copy(), state[RATE : RATE + 3].copy()
    gravity, gravity_body = np.empty(3), np.empty(3)
    gravity_at(world.slope, state[POSITION], gravity)
    for i in range(3):
        gravity_body[i] = turn[0, i] * gravity[0] + turn[1, i] * gravity[1] + turn[2, i] * gravity[2]
    extra[:] = 0.0
    extra[3], extra[4], extra[5] = gravity[0], gravity[1], gravity[2]

    matrix, rhs = np.zeros((10, 10)), np.zeros(10)
    bias, zero = np.empty(3), np.zeros(3)
    sprung_body(machine, world, velocity, omega, gravity_body, matrix, rhs, bias, zero)
    _external(state, machine, world, turn, gravity, rhs, extra)

    theta, theta_rate = state[PITMAN], state[PITMAN_RATE]
    value, by_q, by_angle = np.empty((4, COUNT)), np.empty((4, COUNT)), np.empty((4, COUNT))
    torque, axle, arm = np.empty(4), np.empty((4, 3)), np.zeros(4)
    body = Body(turn, velocity, omega, gravity_body)
    for w in range(4):
        carrier(machine.paths[w], state[TRAVEL + w], theta, value[w], by_q[w], by_angle[w])
        place = Place(value[w], by_q[w], by_angle[w], theta_rate)
        arm[w] = _wheel(w, state, command, machine, world, body, place, ground, dt, matrix, rhs, torque, axle[w], info[w])
        shake, angle = world.imbalance[w] * state[SPIN + w] * state[SPIN + w], state[SPIN_ANGLE + w]
        for i in range(3):
            extra[i] += info[w, i] + shake * (turn[i, 0] * math.cos(angle) - turn[i, 2] * math.sin(angle))
    for a in range(2):
        left, right = 2 * a, 2 * a + 1
        force = bar_forces(
            machine, a, world.bar_factor[a], value[left, LINK], value[right, LINK],
            by_q[left, LINK] * state[TRAVEL_RATE + left], by_q[right, LINK] * state[TRAVEL_RATE + right],
        )  # fmt: skip
        rhs[6 + left] += force * by_q[left, LINK]
        rhs[6 + right] -= force * by_q[right, LINK]

    shaft = 0.25 * (state[SPIN] + state[SPIN + 1] + state[SPIN + 2] + state[SPIN + 3]) * machine.final_drive
    gear = shift_gear(machine, int(state[GEAR]), shaft)
    state[GEAR] = gear
    drive = axle_drive_torque(machine, gear, command[1], shaft)
    extra[6] = drive
    rhs[3] -= machine.torque_reaction * drive / machine.final_drive
    rates = np.empty(4)
    spin_rates(machine, world.locked, drive, torque, state[SPIN : SPIN + 4], dt, rates)
    for w in range(4):
        shaft_torque = machine.spin_inertia * rates[w] - torque[w]
        info[w, 16] = shaft_torque
        shaft_reaction(machine, shaft_torque, axle[w], rhs[3:6])

    target = steering_target(state, command[0], world.steering, dt)
    advance_pitman(state, machine, target, arm.sum(), dt)
    if machine.idler_error != 0.0:
        rods_lift(machine, state, theta, theta_rate, value, by_angle, dt, arm)
        idler_moment(machine, theta, -gravity_body[2], arm[0], arm[1], rhs[3:6])

    solve_positive(matrix, rhs)
    if world.payload[0] > 0.0:
        without_payload(world, body, rhs, extra)
    for i in range(3):
        state[VELOCITY + i] += dt * rhs[i]
        state[RATE + i] += dt * rhs[3 + i]
    for w in range(4):
        state[TRAVEL_RATE + w] += dt * rhs[6 + w]
        state[TRAVEL + w] += dt * state[TRAVEL_RATE + w]
        state[SPIN + w] += dt * rates[w]
        state[SPIN_ANGLE + w] += dt * state[SPIN + w]
    advance_pose(state, turn, dt)
    state[TIME] += dt
    state[STEPS] += 1.0


@inner
def _wheel(w, state, command, machine, world, chassis, place, ground, dt, matrix, rhs, torque, axle, info):
    """One wheel and its carrier: mass, weight, soil, spring; writes the torque about its axle; returns that on the
    arm."""
    turn, velocity, omega, gravity_body = chassis.turn, chassis.velocity, chassis.omega, chassis.gravity
    value, by_q, by_angle, theta_rate = place.value, place.by_q, place.by_angle, place.theta_rate
    q_rate, spin = state[TRAVEL_RATE + w], state[SPIN + w]
    r, path, relative = value[0:3], by_q[0:3], np.empty(3)
    for i in range(3):
        relative[i] = by_q[i] * q_rate + by_angle[i] * theta_rate
    axle[0], axle[2] = value[AXLE_X], value[AXLE_Z]
    if w >= 2:
        axle[0] -= world.rear_toe[w - 2]
    axle[1] = math.sqrt(max(1.0 - axle[0] * axle[0] - axle[2] * axle[2], 0.0))

    body = np.empty(3)  # angular velocity of the carrier
    for i in range(3):
        body[i] = omega[i] + value[TURN + i] * q_rate + value[STEER_TURN + i] * theta_rate
    bias = np.empty(3)
    convective(omega, velocity, r, relative, bias)
    for i in range(3):
        bias[i] -= gravity_body[i]
    add_point_mass(matrix, rhs, machine.unsprung_mass[w], r, bias, path, 6 + w)

    centre, speed, world_axle, rate = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    local = np.empty(3)
    cross(omega, r, local)
    for i in range(3):
        local[i] += velocity[i] + relative[i]
    for i in range(3):
        centre[i] = state[POSITION + i]
        speed[i] = world_axle[i] = rate[i] = 0.0
        for j in range(3):
            centre[i] += turn[i, j] * r[j]
            speed[i] += turn[i, j] * local[j]
            world_axle[i] += turn[i, j] * axle[j]
            rate[i] += turn[i, j] * (body[j] + spin * axle[j])
    angle = state[SPIN_ANGLE + w]
    radius = machine.radius[w] * world.radius_factor[w] + world.out_of_round[w] * math.cos(angle)
    force, moment = np.empty(3), np.empty(3)
    layer = 0 if world.multipass > 0.0 else 1 + w
    own = 1 + w if world.anew > 0.0 and layer == 0 else 0
    rules, motion = Rules(REACH, world.damped, world.creep, world.cast, own), Motion(centre, world_axle, speed, rate)
    width = machine.width[w] * world.width_factor[w]
    sinkage = wheel_contact(ground, layer, w % 2, rules, motion, radius, width, dt, force, moment)
    for i in range(3):
        info[i], info[3 + i], info[6 + i], info[9 + i] = force[i], moment[i], centre[i], speed[i]
        info[12 + i] = world_axle[i]
    info[15] = sinkage

    pull, twist = np.empty(3), np.empty(3)
    for i in range(3):
        pull[i] = turn[0, i] * force[0] + turn[1, i] * force[1] + turn[2, i] * force[2]
        twist[i] = turn[0, i] * moment[0] + turn[1, i] * moment[1] + turn[2, i] * moment[2]
    # An imbalance turns with the wheel, in the plane across its axle.
    shake = world.imbalance[w] * spin * spin
    pull[0] += shake * math.cos(angle)
    pull[2] -= shake * math.sin(angle)
    about = twist[0] * axle[0] + twist[1] * axle[1] + twist[2] * axle[2]
    hold = command[2] * machine.brake_torque + world.bearing[w]
    limit = 0.5 * machine.spin_inertia * abs(spin) / dt
    brake = -math.copysign(min(hold, limit), spin)
    torque[w] = about + brake

    gyro, spin_axis = np.empty(3), np.empty(3)
    for i in range(3):
        spin_axis[i] = machine.gyro_inertia * spin * axle[i]
    cross(body, spin_axis, gyro)
    arm = 0.0
    along = 0.0
    add_force(rhs, pull, r)
    for i in range(3):
        carried = twist[i] - (about + brake) * axle[i] - gyro[i]
        rhs[3 + i] += carried
        along += pull[i] * path[i] + carried * value[TURN + i]
        arm += pull[i] * by_angle[i] + carried * value[STEER_TURN + i]
    strut = strut_force(machine, w, value[STRUT], by_q[STRUT] * q_rate, world.damper_factor[w])
    rhs[6 + w] += along + strut * by_q[STRUT] + stop_force(state[TRAVEL + w])
    return arm
