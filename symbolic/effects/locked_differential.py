"""Axle differentials that are locked."""

import casadi as ca

from softsoil.symbolic.effect import GRAVITY, Correction, Effect, Layout, Signal, Vehicle
from softsoil.symbolic.model import Quantities


def effect(vehicle: Vehicle) -> Effect:
    """Wheels of an axle that turn together scrub in a turn: M_z = -C T^2 omega_z/(2 u) (both axles)."""
    weight, doc = GRAVITY * vehicle.mass, "longitudinal force per unit slip and axle"
    stiffness = Signal("differential_stiffness", "N", doc, 0.0, 0.0, 4.44 * weight, 2.22 * weight)
    return Effect(
        name="locked_differential",
        doc="axle differentials that are locked",
        kind="load",
        reference="linear longitudinal slip of both wheels in a turn",
        parameters=Layout.of(stiffness),
        typical={"differential_stiffness": 0.296 * weight},
        corrections={"balance": Correction(_compute, reads=("track",), adds=("moment_z",))},
        signatures=("turning moment",),
        separates="measured wheel speeds: equal on both sides in a turn when locked",
        rests_on=("omega_z", "omega_fl", "omega_fr", "omega_rl", "omega_rr"),
        excluded_by=("wheels_turn_apart",),
        carried_by=("wheels_turn_together",),
        answers_to={"locked_axles": ()},
    )


def _compute(q: Quantities) -> Quantities:
    u = ca.sqrt(q["u"] * q["u"] + 0.25)
    return {"moment_z": q["moment_z"] - q["differential_stiffness"] * q["track"] ** 2 * q["omega_z"] / (2.0 * u)}
