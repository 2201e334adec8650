"""Wheels that lean and steer with the body's roll, the front ones with the steering too: their axis leans back (caster)."""

from __future__ import annotations

from dataclasses import replace

import casadi as ca

from symbolic.bicycle import Corner
from symbolic.body_roll import body_roll
from symbolic.effects import Effect, each_wheel
from symbolic.model import Quantities
from symbolic.signals import Layout, Signal

LEAN_TIME = 0.21
"""s: how long a damped body takes to roll to the angle of its lateral acceleration (first order)."""
LOWEST = 0.05
"""m: the least h_cg by which a moment is turned into a lateral acceleration; a vehicle may declare 0."""


def wheel_lean() -> Effect:
    """Front wheels that lean by gamma = lean_roll (a + a_m) + lean_steer delta, positive where the left end of the axle is up;
    rear wheels that lean by lean_rear a_m and steer by steer_rear a_m.

    a is the lateral specific force as the rolled body has followed it (first order, LEAN_TIME), in proportion to the mass that
    rolls; a_m = moment/(M h_cg) the one that would roll it as far as the moment on the body does (`load_transfer`: a propeller
    shaft's). The spin of a leaning wheel has a part omega sin(gamma) about the vertical: its rim sweeps sideways through the
    contact as a yawing wheel's does, yaw rate += omega gamma; and while the lean changes, the contact moves sideways under the
    wheel's centre, v_y += radius dgamma/dt. The numbers are the suspension's geometry. The rear wheels roll with the moment
    only, which is there when driving straight: what their lean does in a turn, the force law in a rut lacks by about as much
    (`benchmarks/second_pass.py`).
    """
    return Effect(
        name="wheel_lean",
        doc="wheels lean with the body's roll, the front ones with the steering, and their rims sweep sideways",
        reference="rigid-body kinematics of a spinning wheel; caster and camber of the suspension",
        parameters=Layout.of(
            Signal("lean_steer", "", "lean of the front wheels per steering angle", 0.0, -0.5, 0.5, spread=0.2),
            Signal(
                "lean_roll",
                "rad s^2/m",
                "lean of the front wheels per lateral acceleration",
                0.0,
                -0.05,
                0.05,
                spread=0.02,
            ),
            Signal(
                "lean_rear",
                "rad s^2/m",
                "the rear wheels' lean, of a moment on the body",
                0.0,
                -0.05,
                0.05,
                spread=0.02,
            ),
            Signal(
                "steer_rear", "rad s^2/m", "their steering, of a moment on the body", 0.0, -0.01, 0.01, spread=0.002
            ),
        ),
        typical={"lean_steer": -0.12, "lean_roll": 0.02, "lean_rear": 0.0, "steer_rear": 0.0},
        corrections={"contacts": each_wheel(_leaning)},
        memories=(body_roll("wheel_lean", "a_y_lean", "a_y_leaning", LEAN_TIME),),
        confusable=("steering_gain", "payload"),
        separates="full lock and small steering angles at several speeds",
        drawn=("lean_steer", "lean_roll", "lean_rear", "steer_rear"),
    )


def _leaning(q: Quantities, corner: Corner) -> Corner:
    contact = corner.contact
    if contact is None:
        return corner
    by_moment = q["body_moment"] / (q["mass"] * ca.fmax(q["h_cg"], LOWEST))
    if corner.axle == "r":
        steered = contact.v_y - contact.v_x * q["steer_rear"] * by_moment
        yawing = contact.yaw_rate + contact.omega * q["lean_rear"] * by_moment
        return corner.with_(contact=replace(contact, v_y=steered, yaw_rate=yawing))
    rolling = q["lean_roll"] * q["burden"]
    lean = rolling * (q["a_y_leaning"] + by_moment) + q["lean_steer"] * q["delta"]
    rate = rolling * q["a_y_leaning_rate"] + q["lean_steer"] * q["delta_rate"]
    swept = replace(contact, v_y=contact.v_y + q["radius"] * rate, yaw_rate=contact.yaw_rate + contact.omega * lean)
    return corner.with_(contact=swept)
