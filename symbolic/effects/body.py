"""Effects on the body: gravity on a slope, wind, payload, moments and drag."""

from __future__ import annotations

import casadi as ca

from softsoil.symbolic.effect import Effect
from softsoil.symbolic.model import Quantities
from softsoil.symbolic.signals import Layout, Signal
from softsoil.symbolic.vehicle import GRAVITY

HEADINGS = "driving on all headings, at several speeds"


def bank() -> Effect:
    """Ground that falls towards world -y for a positive angle: gravity -g sin(bank) along world y, in the yaw frame."""
    return Effect(
        name="bank",
        doc="ground that slopes along world y",
        reference="gravity on an inclined plane",
        parameters=Layout.of(Signal("bank", "rad", "slope, rising towards world +y", 0.0, -0.4, 0.4, spread=0.15)),
        typical={"bank": 0.03},
        corrections={"inputs": lambda q: _slope(q, 0.0, -GRAVITY * ca.sin(q["bank"]))},
        confusable=("side_force", "steering_offset"),
        separates=HEADINGS + ", with an accelerometer (specific force does not contain gravity)",
    )


def grade() -> Effect:
    """Ground that rises along world x for a positive angle: gravity -g sin(grade) along world x, in the yaw frame."""
    return Effect(
        name="grade",
        doc="ground that slopes along world x",
        reference="gravity on an inclined plane",
        parameters=Layout.of(Signal("grade", "rad", "slope, rising towards world +x", 0.0, -0.4, 0.4, spread=0.15)),
        typical={"grade": 0.03},
        corrections={"inputs": lambda q: _slope(q, -GRAVITY * ca.sin(q["grade"]), 0.0)},
        confusable=("side_force", "motion_resistance"),
        separates=HEADINGS + ", with an accelerometer (specific force does not contain gravity)",
    )


def _slope(q: Quantities, world_x, world_y) -> Quantities:
    cos, sin = ca.cos(q["psi"]), ca.sin(q["psi"])
    return {
        "gravity_x": q["gravity_x"] + world_x * cos + world_y * sin,
        "gravity_y": q["gravity_y"] - world_x * sin + world_y * cos,
    }


def side_force() -> Effect:
    """A force fixed in the world (wind): its lateral part and its moment about the centre of gravity."""

    def compute(q: Quantities) -> Quantities:
        lateral = -ca.sin(q["psi"]) * q["side_force_x"] + ca.cos(q["psi"]) * q["side_force_y"]
        return {"force_y": q["force_y"] + lateral, "moment_z": q["moment_z"] + lateral * q["side_arm"]}

    return Effect(
        name="side_force",
        doc="a force fixed in the world, as of wind",
        reference="force and moment balance",
        parameters=Layout.of(
            Signal("side_force_x", "N", "force along world x", 0.0, -5000.0, 5000.0, spread=1500),
            Signal("side_force_y", "N", "force along world y", 0.0, -5000.0, 5000.0, spread=1500),
            Signal("side_arm", "m", "where it acts, ahead of the centre of gravity", 0.0, -2.0, 2.0, spread=1),
        ),
        typical={"side_force_x": 100.0, "side_force_y": 300.0, "side_arm": 0.0},
        corrections={"balance": compute},
        confusable=("bank", "steering_offset", "yaw_moment"),
        separates=HEADINGS,
    )


def yaw_moment() -> Effect:
    """A constant moment about the vertical: a dragging brake, a towed load."""
    return Effect(
        name="yaw_moment",
        doc="a constant yaw moment, as of a dragging brake or a tow",
        reference="moment balance",
        parameters=Layout.of(Signal("yaw_moment", "N m", "moment, left positive", 0.0, -5000.0, 5000.0, spread=1500)),
        typical={"yaw_moment": 300.0},
        corrections={"balance": lambda q: {"moment_z": q["moment_z"] + q["yaw_moment"]}},
        confusable=("steering_offset", "side_force"),
        separates="several speeds: an offset's moment follows the tyre force, this one stands still",
    )


def locked_differential() -> Effect:
    """Wheels of an axle that turn together scrub in a turn: M_z = -C T^2 omega_z/(2 u) (both axles)."""

    def compute(q: Quantities) -> Quantities:
        u = ca.sqrt(q["u"] * q["u"] + 0.25)
        moment = q["differential_stiffness"] * q["track"] ** 2 * q["omega_z"] / (2.0 * u)
        return {"moment_z": q["moment_z"] - moment}

    return Effect(
        name="locked_differential",
        doc="axle differentials that are locked",
        reference="linear longitudinal slip of both wheels in a turn",
        parameters=Layout.of(
            Signal(
                "differential_stiffness",
                "N",
                "longitudinal force per unit slip and axle",
                0.0,
                0.0,
                60000.0,
                spread=30000,
            )
        ),
        typical={"differential_stiffness": 4000.0},
        corrections={"balance": compute},
        confusable=("load_transfer",),
        separates="measured wheel speeds: equal on both sides in a turn when locked",
    )


def motion_resistance() -> Effect:
    """du/dt -= f g: only where a_x is commanded, not where it is measured."""
    return Effect(
        name="motion_resistance",
        doc="resistance to motion that the commanded acceleration does not contain",
        reference="rolling resistance coefficient",
        parameters=Layout.of(Signal("motion_resistance", "", "resistance over weight", 0.0, -0.3, 0.3, spread=0.2)),
        typical={"motion_resistance": 0.03},
        corrections={"inputs": lambda q: {"gravity_x": q["gravity_x"] - GRAVITY * q["motion_resistance"]}},
        confusable=("grade",),
        separates="driving on opposite headings",
    )


def payload() -> Effect:
    """A body of mass m at x behind the front axle; (u, v) still belong to the bare vehicle's centre of gravity.

    With s = m (x - l_f)/(M + m): (M + m)(dv/dt + u omega_z - s d(omega_z)/dt) = F, I' d(omega_z)/dt = N + s F,
    I' = I + M m/(M + m) (x - l_f)^2; the axle loads follow by the lever rule.
    """

    def body(q: Quantities) -> Quantities:
        total = q["mass"] + q["payload_mass"]
        arm = q["payload_x"] - q["l_f"]
        inertia = q["yaw_inertia"] + q["mass"] * q["payload_mass"] / total * arm**2
        burden = q["burden"] * total / q["mass"]
        return {"mass": total, "burden": burden, "yaw_inertia": inertia, "shift": q["payload_mass"] / total * arm}

    def loads(q: Quantities) -> Quantities:
        moved = q["payload_mass"] * GRAVITY * (q["payload_x"] - q["l_f"]) / (q["l_f"] + q["l_r"])
        return {"load_f": q["load_f"] - moved, "load_r": q["load_r"] + moved}

    def rates(q: Quantities) -> Quantities:
        turn = (q["moment_z"] + q["shift"] * q["force_y"]) / q["yaw_inertia"]
        return {"d_omega_z": turn, "d_v": q["d_v"] + q["shift"] * turn}

    return Effect(
        name="payload",
        doc="a load carried: mass, its place along the vehicle, and the inertia that follows",
        reference="rigid bodies joined; parallel axis theorem",
        parameters=Layout.of(
            Signal("payload_mass", "kg", "mass of the load", 0.0, 0.0, 3000.0, spread=400),
            Signal("payload_x", "m", "its place behind the front axle", 1.5, -2.0, 6.0, spread=1),
        ),
        typical={"payload_mass": 150.0, "payload_x": 2.2},
        corrections={"vehicle": body, "loads": loads, "rates": rates},
        confusable=("multipass", "steering_gain"),
        separates="straight driving and tight turns: the rut vanishes in tight turns, the load does not",
    )
