"""A force fixed in the world, as of wind."""

import math

import casadi as ca

from softsoil.symbolic.effect import GRAVITY, Correction, Effect, Layout, Signal, Values, Vehicle
from softsoil.symbolic.model import Quantities


def effect(vehicle: Vehicle) -> Effect:
    """A force fixed in the world (wind): its lateral part and its moment about the centre of gravity."""
    weight, base = GRAVITY * vehicle.mass, vehicle.wheelbase
    return Effect(
        name="side_force",
        doc="a force fixed in the world, as of wind",
        kind="load",
        reference="force and moment balance",
        parameters=Layout.of(
            Signal("side_force_x", "N", "force along world x", 0.0, -0.37 * weight, 0.37 * weight, 0.111 * weight),
            Signal("side_force_y", "N", "force along world y", 0.0, -0.37 * weight, 0.37 * weight, 0.111 * weight),
            Signal("side_arm", "m", "where it acts, ahead of the centre of gravity", 0.0, -0.74 * base, 0.74 * base, 0.37 * base),
        ),
        typical={"side_force_x": 0.0074 * weight, "side_force_y": 0.0222 * weight, "side_arm": 0.0},
        corrections={"balance": Correction(_compute, adds=("force_y", "moment_z"))},
        signatures=("constant side force",),
        separates="driving on all headings, at several speeds",
        rests_on=("psi", "v", "omega_z"),
        answers_to={"wind": ("side_force",)},
        derived=Signal("side_force", "N", "size of the force"),
        derive=_size,
    )


def _compute(q: Quantities) -> Quantities:
    lateral = -ca.sin(q["psi"]) * q["side_force_x"] + ca.cos(q["psi"]) * q["side_force_y"]
    return {"force_y": q["force_y"] + lateral, "moment_z": q["moment_z"] + lateral * q["side_arm"]}


def _size(values: Values) -> tuple[float, float]:
    (x, std_x), (y, std_y) = values["side_force_x"], values["side_force_y"]
    size = math.hypot(x, y)
    return size, math.hypot(x * std_x, y * std_y) / max(size, 1e-9)
