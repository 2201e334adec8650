"""Ground that slopes along world x."""

import casadi as ca

from softsoil.symbolic.effect import GRAVITY, Correction, Effect, Layout, Signal, Vehicle
from softsoil.symbolic.slope import along_world


def effect(vehicle: Vehicle) -> Effect:
    """Ground that rises along world x for a positive angle: gravity -g sin(grade) along world x, in the yaw frame."""
    return Effect(
        name="grade",
        doc="ground that slopes along world x",
        kind="slope",
        reference="gravity on an inclined plane",
        parameters=Layout.of(Signal("grade", "rad", "slope, rising towards world +x", 0.0, -0.4, 0.4, spread=0.15)),
        typical={"grade": 0.03},
        corrections={
            "inputs": Correction(lambda q: along_world(q, -GRAVITY * ca.sin(q["grade"]), 0.0), adds=("gravity_x", "gravity_y"))
        },
        signatures=("resistance",),
        separates="driving on all headings, at several speeds, with an accelerometer (specific force does not contain gravity)",
        rests_on=("psi", "u", "a_x_imu"),
        answers_to={"slope_ahead": ("grade",)},
    )
