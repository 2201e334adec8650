"""Soil that changes where the vehicle drives."""

from dataclasses import replace

import casadi as ca

from softsoil.symbolic.effect import Corner, Correction, Effect, Layout, Signal, Vehicle, each_wheel
from softsoil.symbolic.model import Quantities

CHANGE_WIDTH = 0.3
"""m over which a soil changes into another."""
FAR = 1e6
"""m: beyond where anything drives."""


def effect(vehicle: Vehicle) -> Effect:
    """Another n beyond a line on the ground: n + n_change where a wheel has passed (change_x, change_y) along change_heading."""
    return Effect(
        name="soil_change",
        doc="the soil changes where the vehicle drives",
        kind="soil",
        reference="piecewise homogeneous terrain",
        parameters=Layout.of(
            Signal("n_change", "", "change of the sinkage exponent", 0.0, -0.8, 0.8, spread=0.3),
            Signal("change_x", "m", "world x of the change", FAR, -FAR, FAR),
            Signal("change_y", "m", "world y of the change", 0.0, -FAR, FAR),
            Signal("change_heading", "rad", "direction across the line of change", 0.0, -100.0, 100.0),
        ),
        typical={"n_change": 0.1, "change_x": 0.0, "change_y": 0.0, "change_heading": 0.0},
        corrections={"contacts": Correction(each_wheel(_compute), reads=("l_f", "l_r"), sets=("wheel.soil.n",))},
        signatures=("cornering slope",),
        separates="driving over the same place twice",
        place=("change_x", "change_y", "change_heading"),
        rests_on=("x", "y", "psi", "v", "omega_z"),
        answers_to={"ground_change": ("n_change",)},
    )


def _compute(q: Quantities, corner: Corner) -> Corner:
    behind = 0.0 if corner.axle == "f" else q["l_f"] + q["l_r"]
    x, y = q["x"] - behind * ca.cos(q["psi"]), q["y"] - behind * ca.sin(q["psi"])
    past = (x - q["change_x"]) * ca.cos(q["change_heading"]) + (y - q["change_y"]) * ca.sin(q["change_heading"])
    share = 0.5 * (1.0 + past / ca.sqrt(past * past + CHANGE_WIDTH**2))
    n = corner.soil.n + q["n_change"] * share  # type: ignore[union-attr]
    return corner.with_(soil=replace(corner.soil, n=ca.fmax(0.2, ca.fmin(1.6, n))))  # type: ignore[type-var]
