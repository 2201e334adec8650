"""Gravity on ground that is not level."""

import casadi as ca

from softsoil.symbolic.model import Quantities, Scalar


def along_world(q: Quantities, world_x: Scalar, world_y: Scalar) -> Quantities:
    """gravity_x, gravity_y with an acceleration (world_x, world_y) (m/s^2) of the world added, turned into the yaw frame."""
    cos, sin = ca.cos(q["psi"]), ca.sin(q["psi"])
    return {
        "gravity_x": q["gravity_x"] + world_x * cos + world_y * sin,
        "gravity_y": q["gravity_y"] - world_x * sin + world_y * cos,
    }
