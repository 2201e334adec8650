"""Sensors mounted elsewhere than declared."""

import casadi as ca

from softsoil.symbolic.effect import Correction, Effect, Layout, Signal, Vehicle
from softsoil.symbolic.model import Quantities


def effect(vehicle: Vehicle) -> Effect:
    """Velocity measured at a point ahead of the centre of gravity (y_v = v + l omega_z), position at one ahead of the axle."""
    return Effect(
        name="lever_arm",
        doc="sensor mounted elsewhere than declared",
        kind="sensor",
        reference="rigid-body kinematics",
        parameters=Layout.of(
            Signal("velocity_lever", "m", "velocity sensor ahead of the centre of gravity", 0.0, -3.0, 3.0, spread=1),
            Signal("position_lever", "m", "position sensor ahead of the front axle", 0.0, -5.0, 5.0, spread=1),
        ),
        typical={"velocity_lever": 0.2, "position_lever": 0.2},
        corrections={"outputs": Correction(_compute, adds=("y_v", "y_x", "y_y"))},
        signatures=("late or displaced sensor",),
        separates="any turning: kinematics alone (heading against yaw rate, position against speed) tells it",
        rests_on=("x", "y", "psi", "v", "omega_z"),
        answers_to={"mount_offset": ("velocity_lever", "position_lever")},
    )


def _compute(q: Quantities) -> Quantities:
    ahead = q["position_lever"]
    return {
        "y_v": q["y_v"] + q["velocity_lever"] * q["omega_z"],
        "y_x": q["y_x"] + ahead * ca.cos(q["psi"]),
        "y_y": q["y_y"] + ahead * ca.sin(q["psi"]),
    }
