"""Effects of sensors that enter the outputs only."""

from __future__ import annotations

import casadi as ca

from softsoil.symbolic.effect import Effect
from softsoil.symbolic.model import Quantities
from softsoil.symbolic.signals import Layout, Signal

KINEMATICS = "any turning: kinematics alone (heading against yaw rate, position against speed) tells it"


def gyro_bias() -> Effect:
    """y_omega_z = omega_z + b."""
    return Effect(
        name="gyro_bias",
        doc="yaw-rate sensor with a bias",
        reference="sensor model",
        parameters=Layout.of(Signal("gyro_bias", "rad/s", "bias of the yaw rate", 0.0, -0.3, 0.3, spread=0.03)),
        typical={"gyro_bias": 0.01},
        corrections={"outputs": lambda q: {"y_omega_z": q["y_omega_z"] + q["gyro_bias"]}},
        confusable=("yaw_moment",),
        separates=KINEMATICS,
    )


def speed_scale() -> Effect:
    """y_u = k u."""
    return Effect(
        name="speed_scale",
        doc="speed sensor with a wrong scale",
        reference="sensor model",
        parameters=Layout.of(Signal("speed_scale", "", "measured over true speed", 1.0, 0.5, 1.5, spread=0.1)),
        typical={"speed_scale": 1.03},
        corrections={"outputs": lambda q: {"y_u": q["y_u"] * q["speed_scale"]}},
        confusable=(),
        separates=KINEMATICS,
    )


def lever_arm() -> Effect:
    """Velocity measured at a point ahead of the centre of gravity (y_v = v + l omega_z), position at one ahead of the axle."""

    def compute(q: Quantities) -> Quantities:
        ahead = q["position_lever"]
        return {
            "y_v": q["y_v"] + q["velocity_lever"] * q["omega_z"],
            "y_x": q["y_x"] + ahead * ca.cos(q["psi"]),
            "y_y": q["y_y"] + ahead * ca.sin(q["psi"]),
        }

    return Effect(
        name="lever_arm",
        doc="sensor mounted elsewhere than declared",
        reference="rigid-body kinematics",
        parameters=Layout.of(
            Signal("velocity_lever", "m", "velocity sensor ahead of the centre of gravity", 0.0, -3.0, 3.0, spread=1),
            Signal("position_lever", "m", "position sensor ahead of the front axle", 0.0, -5.0, 5.0, spread=1),
        ),
        typical={"velocity_lever": 0.2, "position_lever": 0.2},
        corrections={"outputs": compute},
        confusable=("sensor_delay",),
        separates=KINEMATICS,
    )
