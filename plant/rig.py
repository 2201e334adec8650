"""Single-wheel rig: a wheel under constant load, driven at constant speed and spin, with a prescribed yaw (paper,
Table 3).

The reference rig's own facts, all kept: the wheel centre sits 0.3 m to the left of the axis that it yaws about; the
load is a mass that rides on the wheel, so the force on the soil bounces; speed and spin ramp up between 0.25 and 0.75
s from a drop of 0.1 m; step 1 ms, grid 0.025 m; the yaw angle is -A sin(2 pi f t).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from softsoil.plant.contact import REACH, tiles_within_reach, wheel_contact
from softsoil.plant.grid import RutGrid
from softsoil.plant.ground import Motion, Rules, ground_of
from softsoil.plant.kernel import kernel
from softsoil.plant.soil_field import SoilField
from softsoil.symbolic.soil import Soil

CHANNELS = ("wheel_yaw", "omega", "fx", "fy", "fz", "my", "wheel_z")
"""Columns of a run, in the travel frame; as in the shared single-wheel runs."""


@dataclass(frozen=True)
class Rig:
    """The rig itself.

    radius, width: of the wheel (m); arm: wheel centre to the left of the yaw axis (m); extra_mass: rides with the load
    (kg); gravity: m/s^2; step: s; spacing: of the soil's grid (m); drop: height that the wheel falls from (m); delay,
    ramp: when and for how long speed and spin come up (s).
    """

    radius: float = 0.330229
    width: float = 0.2121
    arm: float = 0.3
    extra_mass: float = 18.8
    gravity: float = 9.8
    step: float = 1e-3
    spacing: float = 0.025
    drop: float = 0.1
    delay: float = 0.25
    ramp: float = 0.5

    @property
    def zero(self) -> float:
        """Height of the soil in the frame of `wheel_z` (m)."""
        return -0.4 - self.radius - self.drop


@dataclass(frozen=True)
class RigRun:
    """Settings of one run.

    soil; load (N); slip: s of the paper at zero yaw; speed: m/s; amplitude: of the yaw angle (rad); frequency: Hz.
    Raises ValueError for a load, speed or frequency that is not positive, or a slip outside (-1, 1).
    """

    soil: Soil
    load: float
    slip: float
    speed: float
    amplitude: float
    frequency: float

    def __post_init__(self) -> None:
        if not (self.load > 0 and self.speed > 0 and self.frequency > 0):
            raise ValueError(
                f"rig run: expected load, speed, frequency > 0, found {self.load}, {self.speed}, {self.frequency}"
            )
        if not -1 < self.slip < 1:
            raise ValueError(f"rig run: expected a slip in (-1, 1), found {self.slip}")

    def spin(self, radius: float) -> float:
        """Wheel speed that gives the slip at zero yaw (rad/s)."""
        return self.speed * (1 + self.slip if self.slip < 0 else 1 / (1 - self.slip)) / radius


@kernel
def _run(ground, first, last, state, rig, run, rules, every, out):
    """Steps first..last of a run; state: x, z, dz/dt. Returns the step reached (short of `last` where the grid is
    full)."""
    radius, width, arm, mass, gravity, dt, delay, ramp, room = rig
    speed_end, spin_end, amplitude, frequency = run
    centre, axis, velocity = np.zeros(3), np.zeros(3), np.zeros(3)
    rate, force, moment = np.zeros(3), np.zeros(3), np.zeros(3)
    motion = Motion(centre, axis, velocity, rate)
    for k in range(first, last):
        if ground.count[0] + room > ground.nodes.shape[0] or 2 * (ground.count[0] + room) > ground.keys.shape[0]:
            return k
        t = k * dt
        up = min(max((t - delay) / ramp, 0.0), 1.0)
        phase = 2.0 * math.pi * frequency * t
        yaw = -amplitude * math.sin(phase)
        yaw_rate = -amplitude * 2.0 * math.pi * frequency * math.cos(phase)
        c, s = math.cos(yaw), math.sin(yaw)
        speed = up * speed_end
        spin = up * spin_end
        centre[0], centre[1], centre[2] = state[0] - arm * s, arm * (c - 1.0), state[1]
        velocity[0], velocity[1], velocity[2] = speed - arm * c * yaw_rate, -arm * s * yaw_rate, state[2]
        axis[0], axis[1] = -s, c
        rate[0], rate[1], rate[2] = -s * spin, c * spin, yaw_rate
        wheel_contact(ground, 0, 0, rules, motion, radius, width, dt, force, moment)
        if k % every == 0:
            row = out[k // every]
            row[0], row[1], row[6] = yaw, spin, state[1]
            row[2], row[3], row[4] = force[0], force[1], force[2]
            row[5] = moment[1]
        state[2] += dt * (force[2] / mass - gravity)
        state[1] += dt * state[2]
        state[0] += dt * speed
    return last


def run_rig(
    run: RigRun,
    duration: float = 2.6,
    rig: Rig | None = None,
    every: int = 5,
    damping: bool = True,
    creep: float = 0.0,
    cast: bool = False,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """One run of the rig from the drop on: times (N,) and the CHANNELS (N, 7), every `every` steps.

    damping: with the soil's damping R; creep: speed below which shear fades (m/s), 0 as in the reference simulator; cast:
    find the wheel as that does (`softsoil.plant.reference.raycast`).
    """
    rig = rig or Rig()
    soil = SoilField.uniform(run.soil)
    grid = RutGrid(rig.spacing)
    room = tiles_within_reach(rig.radius, rig.width, rig.spacing)
    steps = round(duration / rig.step)
    out = np.zeros((steps // every + 1, 7))
    state = np.array([0.0, rig.radius + rig.drop, 0.0])
    mass = run.load / rig.gravity + rig.extra_mass
    machine = (rig.radius, rig.width, rig.arm, mass, rig.gravity, rig.step, rig.delay, rig.ramp, room)
    told = (run.speed, run.spin(rig.radius), run.amplitude, run.frequency)
    rules = Rules(REACH, float(damping), float(creep), int(cast), 0)
    step = 0
    while step <= steps:
        grid.reserve(2 * room)
        step = _run(ground_of(grid, soil), step, steps + 1, state, machine, told, rules, every, out)
        if step > steps:
            break
    out[:, 6] += rig.zero
    return np.arange(len(out), dtype=float) * (every * rig.step), out
