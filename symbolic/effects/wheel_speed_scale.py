"""Wheel speeds of a wrong scale: another rolling radius or number of teeth than declared."""

from softsoil.symbolic.effect import Correction, Effect, Layout, Signal, Vehicle
from softsoil.symbolic.model import Quantities

CORNERS = ("fl", "fr", "rl", "rr")


def effect(vehicle: Vehicle) -> Effect:
    """omega measured = k omega of every wheel."""
    return Effect(
        name="wheel_speed_scale",
        doc="wheel-speed sensors with a wrong scale",
        kind="sensor",
        reference="sensor model",
        parameters=Layout.of(Signal("wheel_speed_scale", "", "measured over true wheel speeds", 1.0, 0.7, 1.4, spread=0.05)),
        typical={"wheel_speed_scale": 1.05},
        corrections={"inputs": Correction(_inputs, adds=tuple(f"spin_{corner}" for corner in CORNERS))},
        signatures=("slip",),
        separates="rolling freely in neutral: there all wheels turn as the vehicle moves",
        rests_on=("u", "omega_fl", "omega_fr", "omega_rl", "omega_rr"),
    )


def _inputs(q: Quantities) -> Quantities:
    """As a difference of the measured speeds, so that it adds to what a delay of theirs does."""
    away = 1.0 / q["wheel_speed_scale"] - 1.0
    return {f"spin_{corner}": q[f"spin_{corner}"] + away * q[f"omega_{corner}"] for corner in CORNERS}
