"""The plant against one window of an independent simulator's drive: same start, steering and throttle."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.judges.true_soil import true_soil
from softsoil.plant.effects import Effects
from softsoil.plant.machine import PlantVehicle, load_plant_vehicle
from softsoil.plant.replay import replay
from softsoil.plant.soil_field import SoilField
from softsoil.recording.drive import Recording
from softsoil.symbolic.soil import CLAY, SANDY_LOAM, Soil

Array = NDArray[np.float64]

WINDOW = 15.0
SETTLE = 2.0
"""The logs' first two seconds hold the start-up transient (s)."""
PRESCRIBED = 1e6
"""Natural frequency of a servo that is there within a step (rad/s)."""
HALF_TRACK = 0.616
MASS = 1378.33
EFFECTS = {
    "effect_backlash": (SANDY_LOAM, Effects(steer_backlash=0.0528)),
    "effect_bank": (SANDY_LOAM, Effects(bank=0.0873)),
    "effect_locked_axles": (SANDY_LOAM, Effects(locked_front=True, locked_rear=True)),
    "effect_payload": (CLAY, Effects(payload=300.0, payload_at=(-2.4, 0.0, 0.9))),
    "effect_steer_lag": (SANDY_LOAM, Effects(steer_lag=0.2)),
    "effect_steer_offset": (CLAY, Effects(steer_offset=0.0353)),
    "effect_wind": (SANDY_LOAM, Effects(wind=(0.0, 900.0))),
    "effect_yaw_moment": (CLAY, Effects(yaw_moment=700.0)),
}
"""What the data's README says of the effect drives."""


def conditions(name: str) -> tuple[Soil | SoilField, Effects]:
    """Soil and effects of a drive, from its name."""
    if name in EFFECTS:
        return EFFECTS[name]
    if name == "change_clay_n0.50_to_0.75":
        return SoilField.change_at(CLAY.with_(n=0.5), CLAY.with_(n=0.75), 90.0), Effects()
    return true_soil(name), Effects()


def compare(ours: Recording, log: Recording) -> dict[str, float]:
    """Figures of one window."""
    found: dict[str, float] = {}
    for name in ("omega_z", "v", "u"):
        found[name] = _rms(ours[name] - log[name]) / _rms(log[name])
    for axle in "fr":
        a, b = (axle_force(r, axle) for r in (ours, log))
        found[f"corr_{axle}"] = float(np.corrcoef(a, b)[0, 1])
        found[f"gain_{axle}"] = float(a @ b / (b @ b))
    found["ratio"] = _rear_over_front(ours) / _rear_over_front(log)
    found["c"], found["c_log"] = yaw_moment_arm(ours), yaw_moment_arm(log)
    return found


def yaw_moment_arm(drive: Recording) -> float:
    """c (m) of M_z = -c sum(F_y), least squares: longitudinal forces times half the track."""
    moment = sum(HALF_TRACK * (drive.truth[f"true_fx_{a}r"] - drive.truth[f"true_fx_{a}l"]) for a in "fr")
    side = axle_force(drive, "f") + axle_force(drive, "r")
    return float(-np.linalg.lstsq(np.stack([side, np.ones_like(side)], axis=1), moment, rcond=None)[0][0])


def axle_force(drive: Recording, axle: str) -> Array:
    """(N,) true lateral force of an axle, "f" or "r" (N)."""
    return drive.truth[f"true_fy_{axle}l"] + drive.truth[f"true_fy_{axle}r"]


def _rear_over_front(drive: Recording) -> float:
    return _rms(axle_force(drive, "r")) / _rms(axle_force(drive, "f"))


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def windows(log: Recording) -> list[float]:
    """Starts of the windows: after the transient, then every 15 s that fit, the last one flush with the end."""
    starts = list(np.arange(SETTLE, log.t[-1] - WINDOW, WINDOW))
    last = float(np.floor(log.t[-1] - WINDOW))
    return [*starts, last] if last - starts[-1] > 0.5 * WINDOW else starts


def with_the_others_steering() -> PlantVehicle:
    """The plant's vehicle with the other's steering: its angle is prescribed, its idler arm breaks Newton's third law."""
    vehicle = load_plant_vehicle()
    machine = vehicle.machine._replace(idler_error=1.0, servo=np.array([PRESCRIBED, *vehicle.machine.servo[1:]]))
    return replace(vehicle, machine=machine)


def window(log: Recording, begin: float, **options: Any) -> tuple[Recording, Recording]:
    """The plant and the log over one window, on the soil and with the effects of its name; options: of `replay`."""
    soil, effects = conditions(log.name)
    return replay(log, soil, begin, begin + WINDOW, effects=effects, **options)
