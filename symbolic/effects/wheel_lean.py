"""Wheels that lean and steer with the body's roll, the front ones with the steering too: their axis leans back (caster)."""

from dataclasses import replace

from softsoil.symbolic.body_roll import body_roll, roll_angle
from softsoil.symbolic.effect import Corner, Correction, Effect, Layout, Signal, Vehicle, each_wheel
from softsoil.symbolic.model import Quantities, Scalar

ROLLED = ("mass", "h_cg", "roll_gain", "burden", "body_moment", "delta", "delta_rate", "radius")


def effect(vehicle: Vehicle) -> Effect:
    """Front wheels that lean by gamma = lean_roll phi + lean_steer delta, positive where the left end of the axle is up; rear
    wheels that lean by lean_rear phi and steer by steer_rear phi, with the body's roll phi (`softsoil.symbolic.body_roll`).

    The spin of a leaning wheel has a part omega sin(gamma) about the vertical: its rim sweeps sideways through the contact as a
    yawing wheel's does, at the rate omega gamma; and a contact stands radius gamma beside its wheel's centre, which moves it
    while the lean changes, v_y += radius dgamma/dt (of the rear wheels by the roll_sweep of the load transfer). The numbers are
    the suspension's geometry: a rigid axle leans with the ground, a wheel held upright to the body with it.
    """

    return Effect(
        name="wheel_lean",
        doc="wheels lean with the body's roll, the front ones with the steering, and their rims sweep sideways",
        kind="body",
        reference="rigid-body kinematics of a spinning wheel; caster, camber and roll steer of the suspension",
        parameters=Layout.of(
            Signal("lean_steer", "", "lean of the front wheels per steering angle", 0.0, -0.5, 0.5, spread=0.2),
            Signal("lean_roll", "", "lean of the front wheels per roll of the body", 0.0, -2.0, 2.0, spread=1.0),
            Signal("lean_rear", "", "lean of the rear wheels per roll of the body", 0.0, -2.0, 2.0, spread=1.0),
            Signal("steer_rear", "", "steering of the rear wheels per roll of the body", 0.0, -2.0, 2.0, spread=0.1),
        ),
        typical={"lean_steer": -0.12, "lean_roll": 1.0, "lean_rear": 1.0, "steer_rear": 0.0},
        corrections={
            "loads": Correction(_aside, reads=ROLLED, adds=("aside_f",)),
            "contacts": Correction(
                each_wheel(_leaning),
                reads=(*ROLLED, "wheel.contact.v_x", "wheel.contact.omega"),
                adds=("wheel.contact.v_y", "wheel.contact.sweep"),
            ),
        },
        memories=(body_roll(),),
        signatures=("cornering slope",),
        separates="full lock and small steering angles at several speeds",
        rests_on=("v", "omega_z"),
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
        aside, lean = -contact.v_x * q["steer_rear"] * roll, q["lean_rear"] * roll
    else:
        lean, rate = _front(q)
        aside = q["radius"] * rate
    return corner.with_(contact=replace(contact, v_y=contact.v_y + aside, sweep=contact.sweep + contact.omega * lean))
