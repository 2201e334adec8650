"""Body roll: lateral load transfer on two tracks, and rear wheels that move with the body."""

from dataclasses import replace

import casadi as ca

from softsoil.symbolic.bicycle import body_force
from softsoil.symbolic.body_roll import body_roll, roll_angle
from softsoil.symbolic.effect import GRAVITY, Corner, Correction, Effect, Layout, Signal, Vehicle, each_wheel
from softsoil.symbolic.history import lag_share
from softsoil.symbolic.model import Memory, Quantities, Scalar
from softsoil.symbolic.smooth import fade_in, smooth_positive

TORQUE_TIME = 0.2
"""s: first-order lag of the torque; a suspended body rolls no faster, and measured wheel speeds are noisy."""
LEAST_HEIGHT = 0.05
"""transfer_height over the front track from which on there are two tracks; below, they come in smoothly."""
ROLLED = ("mass", "h_cg", "roll_gain", "burden")
"""What the body's roll depends on beside the moment on it."""
TRACKS = (
    "mass", "delta", "load_f", "load_r", "rest_load_r", "body_moment", "aside_f", "aside_r", "track", "track_rear", "scrub",
    "ackermann", "toe", "toe_rear", "toe_rear_load", "swing_rear", "roll_stiffness_front", "roll_damping_front", "roll_gain",
    "roll_time", "burden", "radius_rear", "spin_fl", "spin_fr", "spin_rl", "spin_rr",
)  # fmt: skip


def effect(vehicle: Vehicle) -> Effect:
    """Body roll: each wheel its own load, Delta F_z = share (M a h + moment)/T, and rear contacts that move with the body.

    a is the lateral specific force as the rolled body has followed it (`body_roll`), and what the dampers carry on the way: of
    each axle roll_time da/dt times its share of the dampers over that of the springs. Two tracks then carry the yaw moment of
    the wheel that bears more and rolls with more resistance; needs wheel speeds. The rear contacts stand roll_sweep phi left
    of where they are with an upright body, and while it rolls they move sideways, v_y += roll_sweep dphi/dt: h_cg less the
    height of the roll centre. A trailing arm turns with its travel and its wheel with it, which a speed sensor on the arm
    does not see: rims roll on by the swing_rear of the vehicle times the travel. A moment on the body loads one side more and
    rolls it when driving straight, too: shaft_share of the wheels' driving torque, which a propeller shaft hands on to the
    chassis (1/final drive, negative where it rolls to the left), and roll_moment, which is always there (a centre of gravity off
    the middle).
    """
    tip = GRAVITY * vehicle.mass * vehicle.track
    parameters = Layout.of(
        Signal("transfer_height", "m", "effective height of the load transfer", 0.0, 0.0, 2.0, spread=1),
        Signal("roll_sweep", "m", "sideways sweep of the rear contacts per roll of the body", 0.0, -2.0, 2.0, spread=0.5),
        Signal("roll_moment", "N m", "roll to the right when driving straight", 0.0, -0.124 * tip, 0.124 * tip, 0.0186 * tip),
        Signal("shaft_share", "", "roll to the right per driving torque of the wheels", 0.0, -1.0, 1.0, spread=0.2),
    )
    return Effect(
        name="load_transfer",
        doc="body roll: load transfer on two tracks with the yaw moment of unequal resistance, and the rear wheels' lean",
        kind="body",
        reference="moment balance about the roll axis; two-track kinematics",
        parameters=parameters,
        typical={"transfer_height": 0.63, "roll_sweep": 0.5, "roll_moment": 0.0, "shaft_share": 0.0},
        corrections={
            "loads": Correction(_body, reads=("body_moment", *ROLLED), adds=("body_moment", "aside_r")),
            "tracks": Correction(_two_tracks, reads=TRACKS, sets=("wheels",)),
            "contacts": Correction(each_wheel(_swept), reads=("body_moment", *ROLLED), adds=("wheel.contact.v_y",)),
        },
        memories=(body_roll(), _drive_torque()),
        signatures=("turning moment",),
        separates="turns of both signs at several lateral accelerations and speeds",
        rests_on=("v", "omega_z", "omega_fl", "omega_fr", "omega_rl", "omega_rr"),
        drawn=("roll_moment", "shaft_share"),
        for_control={"transfer_height": 1.17 * vehicle.h_cg, "roll_sweep": 0.87 * vehicle.h_cg},  # as the reference vehicle's
    )


def _body(q: Quantities) -> Quantities:
    """The moment on the body, and how far its roll has moved the rear contacts."""
    moment = q["body_moment"] + q["roll_moment"] + q["shaft_share"] * q["drive_torque"]
    roll, _ = roll_angle({**q, "body_moment": moment})
    return {"body_moment": moment, "aside_r": q["aside_r"] + q["roll_sweep"] * roll}


def _swept(q: Quantities, corner: Corner) -> Corner:
    if corner.axle != "r" or corner.contact is None:
        return corner
    _, rate = roll_angle(q)
    return corner.with_(contact=replace(corner.contact, v_y=corner.contact.v_y + q["roll_sweep"] * rate))


def _two_tracks(q: Quantities) -> Quantities:
    """Left and right wheels in the place of each axle's pair; delta_left - delta_right = ackermann delta^2 + toe in front, at the
    rear the toe that depends on the load."""
    two = fade_in(q["transfer_height"], LEAST_HEIGHT * q["track"])
    toe_rear = q["toe_rear"] + q["toe_rear_load"] * (q["load_r"] - q["rest_load_r"])
    spread = (q["ackermann"] * q["delta"] ** 2 + q["toe"]) / 2
    out, back = q["scrub"] * (ca.cos(q["delta"]) - 1.0), q["scrub"] * ca.sin(q["delta"])
    springs = q["mass"] * q["transfer_height"] * q["roll_a"] + q["body_moment"]
    dampers = q["mass"] * q["transfer_height"] * q["roll_time"] * q["roll_a_rate"]
    held, damped = q["roll_stiffness_front"], q["roll_damping_front"]
    swing = q["swing_rear"] * q["track_rear"] / 2 * q["roll_gain"] * q["burden"] * q["roll_a_rate"] / q["radius_rear"]
    # Of each axle: track, moment on its wheels' loads, how far out of line and back a wheel stands, its angle, its arms' turning.
    axles = {
        "f": (q["track"], held * springs + damped * dampers, out, back, q["delta"], spread, 0.0),
        "r": (q["track_rear"], (1.0 - held) * springs + (1.0 - damped) * dampers, 0.0, 0.0, 0.0, toe_rear / 2, swing),
    }
    corners = []
    for axle, (track, moment, outward, backward, delta, apart, more) in axles.items():
        load, moved = q[f"load_{axle}"] / 2, moment / track
        mean = (q[f"spin_{axle}l"] + q[f"spin_{axle}r"]) / 2
        for side, letter in ((1, "l"), (-1, "r")):
            y = two * side * (track / 2 + outward) + q[f"aside_{axle}"]
            # A wheel that has lifted carries nothing.
            carried = load + two * (smooth_positive(load - side * moved, 50.0) - load)
            spin = mean + two * (q[f"spin_{axle}{letter}"] - mean - side * more)
            x, turned, scrub = (two * side * value for value in (-backward, apart, q["scrub"]))
            corners.append(Corner(axle, side, 1, y, carried, delta, spin, x=x, apart=turned, scrub=scrub))
    return {"wheels": tuple(corners)}


def _drive_torque() -> Memory:
    """Memory that provides drive_torque (N m), the sum over the wheels, driving positive, TORQUE_TIME late."""

    def advance(q: Quantities) -> Quantities:
        before = q["memory"]["torque"]
        return {"torque": before + lag_share(q["dt"], TORQUE_TIME) * (_torque(q) - before)}

    return Memory(
        "load_transfer_torque",
        Layout.of(Signal("torque", "N m", "driving torque of the wheels, a moment late")),
        Layout.of(Signal("drive_torque", "N m", "driving torque of the wheels, a moment late")),
        read=lambda q: {"drive_torque": q["memory"]["torque"]},
        advance=advance,
        start=lambda q: {"torque": _torque(q)},
    )


def _torque(q: Quantities) -> Scalar:
    """What turns the wheels against the soil's moments, -sum m_y, put right by the mean radius times the force that is missing.

    A wheel's slip is a small difference of measured speeds; that its force accelerates the vehicle as seen,
    sum F_x = M (du - v omega_z), takes the error of the slip out of the torque.
    """
    forward = sum(corner.count * body_force(corner)[0] for corner in q["wheels"])
    missing = q["mass"] * (q["du"] - q["v"] * q["omega_z"]) - forward
    return 0.5 * (q["radius"] + q["radius_rear"]) * missing - sum(corner.count * corner.force.m_y for corner in q["wheels"])
