"""From the steering command to the pitman arm: gain and offset, delay, lag, backlash, then a servo that the soil
loads."""

from __future__ import annotations

import math

import numpy as np

from softsoil.plant.driveline import curve
from softsoil.plant.effects import MAX_DELAY_STEPS
from softsoil.plant.kernel import inner
from softsoil.plant.state import PITMAN, PITMAN_RATE, RING, STEER_LAGGED, STEER_PLAY, STEPS, TRAVEL
from softsoil.plant.suspension import COUNT, ROD, STEER_TURN, carrier


@inner
def steering_target(state, command, steering, dt):
    """The road-wheel angle (rad) that reaches the steering after all its effects; moves lag and play on by dt."""
    lag, delay, offset, gain, play = steering[0], steering[1], steering[2], steering[3], steering[4]
    step = int(state[STEPS])
    state[RING + step % MAX_DELAY_STEPS] = command
    past = min(int(delay / dt + 0.5), step, MAX_DELAY_STEPS - 1)
    target = gain * state[RING + (step - past) % MAX_DELAY_STEPS] + offset
    if lag > 0.0:
        state[STEER_LAGGED] += (target - state[STEER_LAGGED]) * (1.0 - math.exp(-dt / lag))
    else:
        state[STEER_LAGGED] = target
    state[STEER_PLAY] = min(max(state[STEER_PLAY], state[STEER_LAGGED] - play), state[STEER_LAGGED] + play)
    return state[STEER_PLAY]


@inner
def advance_pitman(state, machine, target, torque, dt):
    """The arm's servo, implicit in its own stiffness and damping: stable at any step; torque: of the soil (N m)."""
    wanted = curve(machine.steer_table, target)
    omega, zeta, inertia = machine.servo[0], machine.servo[1], machine.servo[2]
    rate = state[PITMAN_RATE] + dt * (omega * omega * (wanted - state[PITMAN]) + torque / inertia)
    rate /= 1.0 + 2.0 * zeta * omega * dt + omega * omega * dt * dt
    state[PITMAN_RATE] = rate
    state[PITMAN] += dt * rate


@inner
def rods_lift(machine, state, theta, theta_rate, value, by_angle, dt, arm):
    """Upward forces (N) of the front tie rods on the steering link, in the place of the moments about the pitman arm
    (N m) that the soil puts on their wheels; theta, theta_rate: before this step, whose rate is in
    `state`."""
    for w in range(2):
        arm[w] -= _steered_momentum(machine, w, state, theta, theta_rate, value[w], by_angle[w], dt)
        arm[w] *= value[w, ROD]


@inner
def _steered_momentum(machine, w, state, theta, theta_rate, value, by_angle, dt):
    """Moment (N m) about the pitman arm that takes a steered wheel from the last step's motion to this one's.

    The carrier's mass is left out: its centre stands on the axis that it steers about.
    """
    before, by_q, by_angle_before = np.empty(COUNT), np.empty(COUNT), np.empty(COUNT)
    carrier(machine.paths[w], state[TRAVEL + w], theta - dt * theta_rate, before, by_q, by_angle_before)
    rate, found = state[PITMAN_RATE], 0.0
    for i in range(3):
        moved = by_angle[i] * rate - by_angle_before[i] * theta_rate
        turned = value[STEER_TURN + i] * rate - before[STEER_TURN + i] * theta_rate
        found += machine.wheel_mass * moved * by_angle[i] + machine.steer_inertia * turned * value[STEER_TURN + i]
    return found / dt
