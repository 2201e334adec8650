"""How a drive begins: pose and speeds of the vehicle, its body resting on the soil."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import fsolve

from softsoil.plant.machine import Machine, PlantVehicle
from softsoil.plant.masses import GRAVITY
from softsoil.plant.soil_field import SoilField, soil_at
from softsoil.plant.state import (
    GEAR,
    POSITION,
    QUATERNION,
    RATE,
    SPIN,
    TRAVEL,
    VELOCITY,
    blank_state,
    quaternion,
    rotation,
)
from softsoil.plant.suspension import COUNT, STRUT, carrier, strut_force

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Start:
    """Where and how fast a drive begins.

    x, y: of the point on the front axle (m); psi (rad); u, v: of the centre of gravity in the yaw frame (m/s);
    omega_z (rad/s); spin: wheel speeds (rad/s; default: rolling freely); roll, pitch (rad), height of the vehicle's centre of
    gravity (m) and wheel heights (m): default at rest on the soil there; gear: counted from 0 (default: what the speed calls
    for).
    """

    x: float = 0.0
    y: float = 0.0
    psi: float = 0.0
    u: float = 0.0
    v: float = 0.0
    omega_z: float = 0.0
    spin: tuple[float, float, float, float] | None = None
    roll: float | None = None
    pitch: float | None = None
    z_cg: float | None = None
    wheel_z: tuple[float, float, float, float] | None = None
    gear: int | None = None


def _paths(machine: Machine, wheel: int, q: float) -> tuple[Array, Array]:
    value, by_q, by_angle = np.empty(COUNT), np.empty(COUNT), np.empty(COUNT)
    carrier(machine.paths[wheel], q, 0.0, value, by_q, by_angle)
    return value, by_q


def rest_pose(machine: Machine, sinkage: Array) -> tuple[float, float, Array]:
    """Height of the sprung centre of gravity (m), pitch (rad) and travels (2,) of front and rear at rest on level
    ground.

    sinkage: (2,) of front and rear wheels (m). Balance of each travel and of the body's heave and pitch.
    """
    weight = machine.sprung_mass * GRAVITY

    def balance(z: Array) -> Array:
        lift, values = np.empty(2), []
        for axle in range(2):
            value, by_q = _paths(machine, 2 * axle, float(z[2 + axle]))
            # What spring carries at the wheel, in units of wheel force.
            lift[axle] = -strut_force(machine, 2 * axle, value[STRUT], 0.0, 1.0) * by_q[STRUT] / by_q[2]
            values.append(value)
        heights = [z[0] - z[1] * v[0] + v[2] - machine.radius[2 * k] + sinkage[k] for k, v in enumerate(values)]
        moment = -2.0 * (lift[0] * values[0][0] + lift[1] * values[1][0])
        return np.array([(2.0 * lift.sum() - weight) / 1e4, moment / 1e4, *heights])

    found, _, success, message = fsolve(balance, np.array([0.75, 0.0, 0.01, 0.01]), full_output=True)
    if success != 1:
        raise ValueError(f"vehicle: expected springs that carry the chassis within their travel, found: {message}")
    return float(found[0]), float(found[1]), found[2:]


def rest_sinkage(machine: Machine, load: float, soil: Array, wheel: int = 0) -> float:
    """Sinkage (m) at which a standing wheel carries a load: b integral (k_c/b + k_phi) h(X)^n dX over its whole
    chord; wheel: its number."""
    radius, width = float(machine.radius[wheel]), float(machine.width[wheel])
    stiffness = soil[1] / width + soil[0]

    def carried(h: float) -> float:
        chord = np.sqrt(radius**2 - (radius - h) ** 2)
        x = np.linspace(-chord, chord, 201)
        depth = np.maximum(np.sqrt(radius**2 - x**2) - (radius - h), 0.0)
        return float(width * np.trapezoid(stiffness * depth ** soil[2], x))

    low, high = 0.0, radius
    for _ in range(50):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if carried(middle) < load else (low, middle)
    return 0.5 * (low + high)


def start_state(start: Start, vehicle: PlantVehicle, soil: SoilField) -> Array:
    """(SIZE,) state of the plant at the start."""
    machine = vehicle.machine
    state = blank_state()
    ground = np.empty(8)
    soil_at(soil.values, 0, soil.meta, start.x, start.y, ground)
    loads = machine.total_mass * GRAVITY / (2.0 * (vehicle.l_f + vehicle.l_r)) * np.array([vehicle.l_r, vehicle.l_f])
    sinkage = np.array([rest_sinkage(machine, float(load), ground, 2 * axle) for axle, load in enumerate(loads)])
    height, pitch, travel = rest_pose(machine, sinkage)
    state[TRAVEL : TRAVEL + 4] = np.repeat(travel, 2)
    pitch = pitch if start.pitch is None else start.pitch
    roll = 0.0 if start.roll is None else start.roll
    state[QUATERNION : QUATERNION + 4] = quaternion(start.psi, pitch, roll)
    turn = np.empty((3, 3))
    rotation(state, turn)
    front = turn @ machine.front_point
    state[POSITION : POSITION + 3] = [start.x - front[0], start.y - front[1], height]
    if start.z_cg is not None:
        centre = sum(machine.unsprung_mass[w] * _paths(machine, w, state[TRAVEL + w])[0][:3] for w in range(4))
        state[POSITION + 2] = start.z_cg - (turn @ (centre / machine.total_mass))[2]
    if start.wheel_z is not None:
        for w in range(4):
            _seat(state, machine, turn, w, start.wheel_z[w])
    c, s = np.cos(start.psi), np.sin(start.psi)
    offset = vehicle.l_f - machine.front_point[0]  # sprung centre of gravity, ahead of the whole vehicle's
    v = start.v + offset * start.omega_z
    state[VELOCITY : VELOCITY + 3] = turn.T @ np.array([c * start.u - s * v, s * start.u + c * v, 0.0])
    state[RATE : RATE + 3] = turn.T @ np.array([0.0, 0.0, start.omega_z])
    state[SPIN : SPIN + 4] = start.spin if start.spin is not None else start.u / machine.radius
    state[GEAR] = _gear(machine, state[SPIN : SPIN + 4].mean()) if start.gear is None else start.gear
    return state


def _seat(state: Array, machine: Machine, turn: Array, wheel: int, height: float) -> None:
    """Set a travel so that the wheel centre stands at a height."""
    for _ in range(8):
        value, by_q = _paths(machine, wheel, state[TRAVEL + wheel])
        error = height - state[POSITION + 2] - turn[2] @ value[:3]
        state[TRAVEL + wheel] += error / (turn[2] @ by_q[:3])


def _gear(machine: Machine, spin: float) -> int:
    """Lowest gear that keeps the motor below its upshift point."""
    motor = spin * machine.final_drive / machine.gears
    fits = np.flatnonzero(motor <= machine.shift[1])
    return int(fits[0]) if len(fits) else len(machine.gears) - 1
