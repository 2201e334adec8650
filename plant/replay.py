"""Drive the plant with the commands of a log, from the log's own state: how the plant is judged against another
simulator."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from softsoil.plant.driveline import curve, shift_gear
from softsoil.plant.effects import Effects
from softsoil.plant.machine import PlantVehicle, load_plant_vehicle
from softsoil.plant.manoeuvres import Logged, Manoeuvre, Sine, Speed
from softsoil.plant.observe import COLUMNS, WHEELS
from softsoil.plant.simulate import drive, recording_of
from softsoil.plant.soil_field import SoilField
from softsoil.plant.start import Start
from softsoil.plant.state import (
    GEAR,
    PITMAN,
    POSITION,
    QUATERNION,
    RATE,
    SPIN,
    STEER_LAGGED,
    STEER_PLAY,
    VELOCITY,
    rotation,
)
from softsoil.plant.world import Plant
from softsoil.recording.drive import Recording
from softsoil.symbolic.soil import Soil

Array = NDArray[np.float64]

LEAD = 2.0
"""How long before the judged stretch the plant is led along the log, so that the rear wheels meet ruts (s)."""


def gears_of(log: Recording, vehicle: PlantVehicle) -> NDArray[np.int64]:
    """(N,) gear (from 0) at each row: the automatic's shift points run over the logged wheel speeds."""
    machine = vehicle.machine
    shaft = log.stack(*(f"omega_{wheel}" for wheel in WHEELS)).mean(axis=1) * machine.final_drive
    gears = np.zeros(len(log), dtype=np.int64)
    gear = int(np.argmax(shaft[0] / machine.gears <= machine.shift[1]))
    for k, speed in enumerate(shaft):
        gears[k] = gear = int(shift_gear(machine, gear, float(speed)))
    return gears


def replay(
    log: Recording,
    soil: Soil | SoilField,
    begin: float,
    end: float,
    *,
    effects: Effects | None = None,
    vehicle: PlantVehicle | None = None,
    lead: float = LEAD,
    hold_speed: bool = False,
    hold_gear: bool = False,
    cast: bool = False,
) -> tuple[Recording, Recording]:
    """The plant and the log over begin < t <= end (s), both from the log's state at `begin`.

    For `lead` s before, the plant is led along the log's own track, so that the ruts lie where the log has them (where
    the log begins later: along its first heading). Then it runs free on the log's steering, throttle and brake. With
    `hold_gear` its gears are shifted when the log's were, with `hold_speed` its speed u and wheel speeds are the log's
    at every row, so that a gear shifted at another moment does not count. With `cast` its wheels meet the soil as the
    reference simulator's do (see Plant).
    Returns (plant, log) with equal rows. ValueError where the log does not reach from begin to end, or its step is no multiple of
    the plant's.
    """
    vehicle = vehicle or load_plant_vehicle()
    t, gears = log.t, gears_of(log, vehicle)
    first, last = int(np.searchsorted(t, begin)), int(np.searchsorted(t, end, side="right"))
    if last - first < 2:
        raise ValueError(f"{log.name}: expected rows between {begin} and {end} s, found t up to {t[-1]:.3f} s")
    early = int(np.searchsorted(t, t[first] - lead))
    brake = log["brake"] if "brake" in log else np.zeros(len(log))
    commands = np.stack([log["steer"], log["throttle"], brake], axis=1)
    driver = Logged(t, commands)
    plant = _run_up(log, soil, early, int(gears[early]), effects, vehicle, cast)
    steps = round(log.dt / plant.dt)
    if steps < 1 or abs(steps * plant.dt - log.dt) > 1e-6:
        raise ValueError(f"{log.name}: expected rows every multiple of {plant.dt} s, found every {log.dt} s")
    within = np.arange(steps, dtype=np.float64) * plant.dt
    for row in range(early, first):
        plant.advance(driver(t[row] + within, plant.sample()))
        lead_to(plant, log, row + 1)
    plant.state[GEAR] = gears[first]
    if hold_gear:
        never = plant.vehicle.machine._replace(shift=np.array([-np.inf, np.inf]))
        plant.vehicle = replace(plant.vehicle, machine=never)
    table = np.zeros((last - 1 - first, len(COLUMNS)))
    for k in range(len(table)):
        if hold_gear:
            plant.state[GEAR] = gears[first + k]
        plant.advance(driver(t[first + k] + within, plant.sample()))
        if hold_speed:
            _hold_speed(plant, log, first + k + 1)
        table[k] = plant.sample().row
    table[:, 0] = t[first + 1 : last]
    theirs = replace(
        log,
        channels={name: values[first + 1 : last] for name, values in log.channels.items()},
        truth={name: values[first + 1 : last] for name, values in log.truth.items()},
    )
    return recording_of(table, log.name), theirs


def lead_to(plant: Plant, log: Recording, row: int) -> None:
    """Set the plant's motion in the plane to a row of the log; heave, roll, pitch, travels and soil stay as they
    are."""
    seen, state = plant.sample(), plant.state
    turn = float(log["psi"][row]) - seen["psi"]
    c, s = np.cos(turn), np.sin(turn)
    here = state[POSITION : POSITION + 2] - (seen["x"], seen["y"])
    state[POSITION] = float(log["x"][row]) + c * here[0] - s * here[1]
    state[POSITION + 1] = float(log["y"][row]) + s * here[0] + c * here[1]
    w, x, y, z = state[QUATERNION : QUATERNION + 4]
    a, b = np.cos(0.5 * turn), np.sin(0.5 * turn)
    state[QUATERNION : QUATERNION + 4] = a * w - b * z, a * x - b * y, a * y + b * x, a * z + b * w
    matrix = np.empty((3, 3))
    rotation(state, matrix)
    state[RATE : RATE + 3] += matrix[2] * (float(log["omega_z"][row]) - seen["omega_z"])
    seen = plant.sample()
    psi = float(log["psi"][row])
    forward, left = np.array([np.cos(psi), np.sin(psi), 0.0]), np.array([-np.sin(psi), np.cos(psi), 0.0])
    missing = forward * (float(log["u"][row]) - seen["u"]) + left * (float(log["v"][row]) - seen["v"])
    state[VELOCITY : VELOCITY + 3] += matrix.T @ missing
    state[SPIN : SPIN + 4] = [float(log[f"omega_{wheel}"][row]) for wheel in WHEELS]


def _hold_speed(plant: Plant, log: Recording, row: int) -> None:
    """Give the plant the log's forward speed and wheel speeds; all else stays."""
    seen, matrix = plant.sample(), np.empty((3, 3))
    rotation(plant.state, matrix)
    forward = np.array([np.cos(seen["psi"]), np.sin(seen["psi"]), 0.0])
    plant.state[VELOCITY : VELOCITY + 3] += matrix.T @ forward * (float(log["u"][row]) - seen["u"])
    plant.state[SPIN : SPIN + 4] = [float(log[f"omega_{wheel}"][row]) for wheel in WHEELS]


def _run_up(
    log: Recording,
    soil: Soil | SoilField,
    row: int,
    gear: int,
    effects: Effects | None,
    vehicle: PlantVehicle,
    cast: bool,
) -> Plant:
    """A plant that has come 1 s along a straight line to the place of a row, its wheels steered as the row says."""
    x, y, psi, u = (float(log[name][row]) for name in ("x", "y", "psi", "u"))
    start = Start(x - u * np.cos(psi), y - u * np.sin(psi), psi, u, gear=gear)
    plant = Plant(soil, vehicle=vehicle, effects=effects, start=start, cast=cast)
    drive(plant, Manoeuvre("run-up", Sine(0.0), Speed(u)), 0.996)
    steer = float(log["steer"][row])
    plant.state[PITMAN] = curve(vehicle.machine.steer_table, steer)
    plant.state[STEER_LAGGED] = plant.state[STEER_PLAY] = steer
    lead_to(plant, log, row)
    return plant
