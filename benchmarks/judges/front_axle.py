"""Lateral force of the front axle by a force law, against the true force of a drive."""

from __future__ import annotations

import casadi as ca
import numpy as np

from benchmarks.judges.true_soil import true_soil
from softsoil.recording.drive import Recording
from softsoil.recording.rig import MOTION, SOIL_KEYS, moving_mean
from softsoil.symbolic.soil import Soil
from softsoil.symbolic.vehicle import GRAVITY, Vehicle
from softsoil.symbolic.wheel import Contact, ForceLaw

SIDES = (("fl", 1.0), ("fr", -1.0))
SMOOTH = 5
"""Samples (60 ms) over which accelerations are averaged for the load transfer."""


def motion(log: Recording, side: str, sign: float, vehicle: Vehicle, own: bool) -> tuple[np.ndarray, np.ndarray]:
    """(7, N) contact of one front wheel, and its angle to the vehicle (rad)."""
    dt = log.dt
    if own:
        angle = log.truth[f"true_delta_{side}"]
        u, v, load = (log.truth[f"true_{key}_{side}"] for key in ("vx", "vy", "fz"))
    else:
        mean = log["steer"]
        angle = mean + sign * 0.5 * (vehicle.ackermann * mean**2 + vehicle.toe)
        u = log["u"] - sign * 0.5 * vehicle.track * log["omega_z"]
        v = log["v"] + vehicle.l_f * log["omega_z"]
        a_x, a_y = (moving_mean(log[key], SMOOTH) for key in ("a_x_imu", "a_y_imu"))
        static = vehicle.mass * (GRAVITY * (vehicle.l_r - vehicle.load_offset) - a_x * vehicle.h_cg)
        transfer = vehicle.roll_stiffness_front * vehicle.mass * a_y * vehicle.h_cg / vehicle.track
        load = 0.5 * static / vehicle.wheelbase - sign * transfer
    cos, sin = np.cos(angle), np.sin(angle)
    v_x, v_y = u * cos + v * sin, -u * sin + v * cos
    rate = np.gradient(angle, dt)
    return np.array([v_x, v_y, log[f"omega_{side}"], load, log["omega_z"] + rate, rate, np.gradient(v_y, dt)]), angle


def leaning(contact: np.ndarray, log: Recording, vehicle: Vehicle) -> np.ndarray:
    """The contact (8, N) of a front wheel that leans with steering and roll: with its sweep, last."""
    declared, dt = vehicle.effects["wheel_lean"], log.dt
    lean = declared["lean_steer"] * log["steer"] + declared["lean_roll"] * log.truth["true_roll"]
    moved = contact.copy()
    moved[MOTION.index("v_y")] += vehicle.wheel.radius * np.gradient(lean, dt)
    return np.vstack([moved, moved[MOTION.index("omega")] * lean])


def force(law: ForceLaw, vehicle: Vehicle) -> ca.Function:
    """[motion and sweep, soil] -> [f_x, f_y] in the wheel frame."""
    m, s = ca.SX.sym("m", 8), ca.SX.sym("s", 6)
    contact = Contact(**{key: m[i] for i, key in enumerate((*MOTION, "sweep"))})
    out = law(Soil("", *[s[i] for i in range(6)]), vehicle.wheel, contact)
    return ca.Function("force", [m, s], [ca.vertcat(out.f_x, out.f_y)])


def judge(log: Recording, function: ca.Function, vehicle: Vehicle, own: bool, lean: bool = False) -> tuple[float, float, float]:
    """rms error over peak, rms error over rms, gain, of the front axle's lateral force in the vehicle frame."""
    soil = np.array([[getattr(true_soil(log.name), key)] for key in SOIL_KEYS])
    predicted, measured = np.zeros(len(log)), np.zeros(len(log))
    for side, sign in SIDES:
        contact, angle = motion(log, side, sign, vehicle, own)
        contact = leaning(contact, log, vehicle) if lean else np.vstack([contact, np.zeros(len(log))])
        f_x, f_y = np.array(function(contact, soil))
        predicted += f_x * np.sin(angle) + f_y * np.cos(angle)
        measured += log.truth[f"true_fy_{side}"]
    predicted, measured = moving_mean(predicted, 3)[3:-3], moving_mean(measured, 3)[3:-3]
    rms = np.sqrt(np.mean((predicted - measured) ** 2))
    gain = float(predicted @ measured / (predicted @ predicted))
    return float(rms / np.abs(measured).max()), float(rms / np.sqrt(np.mean(measured**2))), gain
