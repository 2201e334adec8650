"""From the steering command to the pitman arm: gain and offset, delay, lag, backlash, then a servo that the soil
loads."""

from __future__ import annotations

import math

from plant.driveline import curve
from plant.effects import MAX_DELAY_STEPS
from plant.kernel import inner
from plant.state import PITMAN, PITMAN_RATE, RING, STEER_LAGGED, STEER_PLAY, STEPS


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
