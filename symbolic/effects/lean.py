"""Wheels that lean and steer with the body's roll, the front ones with the steering too: their axis leans back (caster)."""

from __future__ import annotations

from dataclasses import replace

from softsoil.symbolic.bicycle import Corner
from softsoil.symbolic.body_roll import body_roll, roll_angle
from softsoil.symbolic.effect import Effect, each_wheel
from softsoil.symbolic.model import Quantities, Scalar
from softsoil.symbolic.signals import Layout, Signal


def wheel_lean() -> Effect:
    """Front wheels that lean by gamma = lean_roll phi + lean_steer delta, positive where the left end of the axle is up; rear
    wheels that lean by lean_rear phi and steer by steer_rear phi, with the body's roll phi (`softsoil.symbolic.body_roll`).

    The spin of a leaning wheel has a part omega sin(gamma) about the vertical: its rim sweeps sideways through the contact as a
    yawing wheel's does, at the rate omega gamma; and a contact stands radius gamma beside its wheel's centre, which moves it
    while the lean changes, v_y += radius dgamma/dt (of the rear wheels by the roll_sweep of `load_transfer`). The numbers are
    the suspension's geometry: a rigid axle leans with the ground, a wheel held upright to the body with it.
    """

    def share(name: str, doc: str, spread: float) -> Signal:
        return Signal(name, "", doc, 0.0, -2.0, 2.0, spread=spread)

    return Effect(
        name="wheel_lean",
        doc="wheels lean with the body's roll, the front ones with the steering, and their rims sweep sideways",
        reference="rigid-body kinematics of a spinning wheel; caster, camber and roll steer of the suspension",
        parameters=Layout.of(
            Signal("lean_steer", "", "lean of the front wheels per steering angle", 0.0, -0.5, 0.5, spread=0.2),
            share("lean_roll", "lean of the front wheels per roll of the body", 1.0),
            share("lean_rear", "lean of the rear wheels per roll of the body", 1.0),
            share("steer_rear", "steering of the rear wheels per roll of the body", 0.1),
        ),
        typical={"lean_steer": -0.12, "lean_roll": 1.0, "lean_rear": 1.0, "steer_rear": 0.0},
        corrections={"loads": _aside, "contacts": each_wheel(_leaning)},
        memories=(body_roll(),),
        confusable=("steering_gain", "payload"),
        separates="full lock and small steering angles at several speeds",
        drawn=("lean_steer", "lean_roll", "lean_rear", "steer_rear"),
    )


def _front(q: Quantities) -> tuple[Scalar, Scalar]:
    """Lean of the front wheels (rad) and its rate (rad/s)."""
    roll, rate = roll_angle(q)
    lean = q["lean_roll"] * roll + q["lean_steer"] * q["delta"]
    return lean, q["lean_roll"] * rate + q["lean_steer"] * q["delta_rate"]


def _aside(q: Quantities) -> Quantities:
    return {"aside_f": q["aside_f"] + q["radius"] * _front(q)[0]}


def _leaning(q: Quantities, corner: Corner) -> Corner:
    contact = corner.contact
    if contact is None:
        return corner
    if corner.axle == "r":
        roll, _ = roll_angle(q)
        steered = contact.v_y - contact.v_x * q["steer_rear"] * roll
        return corner.with_(contact=replace(contact, v_y=steered, sweep=contact.omega * q["lean_rear"] * roll))
    lean, rate = _front(q)
    return corner.with_(contact=replace(contact, v_y=contact.v_y + q["radius"] * rate, sweep=contact.omega * lean))
