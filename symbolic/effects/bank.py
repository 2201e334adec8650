"""Ground that slopes along world y."""

import casadi as ca

from softsoil.symbolic.effect import GRAVITY, Correction, Effect, Layout, Signal, Vehicle
from softsoil.symbolic.slope import along_world


def effect(vehicle: Vehicle) -> Effect:
    """Ground that falls towards world -y for a positive angle: gravity -g sin(bank) along world y, in the yaw frame."""
    return Effect(
        name="bank",
        doc="ground that slopes along world y",
        kind="slope",
        reference="gravity on an inclined plane",
        parameters=Layout.of(Signal("bank", "rad", "slope, rising towards world +y", 0.0, -0.4, 0.4, spread=0.15)),
        typical={"bank": 0.03},
        corrections={
            "inputs": Correction(lambda q: along_world(q, 0.0, -GRAVITY * ca.sin(q["bank"])), adds=("gravity_x", "gravity_y"))
        },
        signatures=("constant side force",),
        separates="driving on all headings, at several speeds, with an accelerometer (specific force does not contain gravity)",
        rests_on=("psi", "v", "omega_z"),
        answers_to={"slope_aside": ("bank",)},
    )
