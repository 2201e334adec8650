"""Effects of two tracks and of the rut: lateral load transfer, and rear wheels that follow the front ones."""

from __future__ import annotations

from dataclasses import replace

import casadi as ca

from softsoil.symbolic.bicycle import Corner
from softsoil.symbolic.body_roll import body_roll, roll_angle
from softsoil.symbolic.drive_torque import drive_torque
from softsoil.symbolic.effect import Effect, each_wheel
from softsoil.symbolic.model import Memory, Quantities, Scalar
from softsoil.symbolic.signals import Layout, Signal
from softsoil.symbolic.smooth import smooth_norm, smooth_positive
from softsoil.symbolic.track import Cell, interpolate, push, read_cells, track_layout, write_cells

DAMPER_TIME = 0.15
"""s: what a damped suspension's dampers carry of the load transfer while the body still rolls, per what its springs carry in the
end; less than `softsoil.symbolic.body_roll.ROLL_TIME`, of which the body's inertia is a part."""
RUT_CELLS = 17
RUT_REACH = 1.125
"""Length of the rut that is remembered, over the wheelbase."""
RUT_VALUES = (
    Signal("d", "m", "distance behind the front axle"),
    Signal("el", "m", "lateral position of the front left wheel's rut in the yaw frame"),
    Signal("er", "m", "lateral position of the front right wheel's rut in the yaw frame"),
    Signal("jl", "m", "shear path left by the front left wheel"),
    Signal("jr", "m", "shear path left by the front right wheel"),
    Signal("hl", "m", "depth of the front left wheel's rut"),
    Signal("hr", "m", "depth of the front right wheel's rut"),
    Signal("w", "m", "width of the ruts' edges"),
)


def load_transfer() -> Effect:
    """Body roll: each wheel its own load, Delta F_z = share (M a h + moment)/T, and rear contacts that move with the body.

    a is the lateral specific force as the rolled body has followed it (first order, `body_roll`), and what the dampers
    carry on the way: of each axle DAMPER_TIME da/dt times its share of the dampers over that of the springs. Two tracks then
    carry the yaw moment of the wheel that bears more and rolls with more resistance; needs wheel speeds. The rear contacts stand
    roll_sweep phi left of where they are with an upright body, and while it rolls they move sideways, v_y += roll_sweep dphi/dt:
    h_cg for wheels that stay upright to the body and a centre of gravity that swings over them. A moment on the body loads one
    side more and rolls it when driving straight, too: shaft_share of the wheels' driving torque, which a propeller shaft hands
    on to the chassis (1/final drive, negative where it rolls to the left), and roll_moment, which is always there (a centre of
    gravity off the middle).
    """
    parameters = Layout.of(
        Signal("transfer_height", "m", "effective height of the load transfer", 0.0, 0.0, 2.0, spread=1),
        Signal(
            "roll_sweep", "m", "sideways sweep of the rear contacts per roll of the body", 0.0, -2.0, 2.0, spread=0.5
        ),
        Signal("roll_moment", "N m", "roll to the right when driving straight", 0.0, -2000.0, 2000.0, spread=300),
        Signal("shaft_share", "", "roll to the right per driving torque of the wheels", 0.0, -1.0, 1.0, spread=0.2),
    )
    return Effect(
        name="load_transfer",
        doc="body roll: load transfer on two tracks with the yaw moment of unequal resistance, and the rear wheels' lean",
        reference="moment balance about the roll axis; two-track kinematics",
        parameters=parameters,
        typical={"transfer_height": 0.63, "roll_sweep": 0.5, "roll_moment": 0.0, "shaft_share": 0.0},
        corrections={"loads": _body, "tracks": _two_tracks, "contacts": each_wheel(_swept)},
        memories=(body_roll(), drive_torque("load_transfer")),
        confusable=("locked_differential", "yaw_moment"),
        separates="turns of both signs at several lateral accelerations and speeds",
        drawn=("roll_moment", "shaft_share"),
    )


def _body(q: Quantities) -> Quantities:
    """The moment on the body, and how far its roll has moved the rear contacts."""
    moment = q["roll_moment"] + q["shaft_share"] * q["drive_torque"]
    roll, _ = roll_angle({**q, "body_moment": moment})
    return {"body_moment": moment, "aside_r": q["aside_r"] + q["roll_sweep"] * roll}


def _swept(q: Quantities, corner: Corner) -> Corner:
    if corner.axle != "r" or corner.contact is None:
        return corner
    _, rate = roll_angle(q)
    return corner.with_(contact=replace(corner.contact, v_y=corner.contact.v_y + q["roll_sweep"] * rate))


def _two_tracks(q: Quantities) -> Quantities:
    """Left and right wheels in the place of each axle's pair; delta_left - delta_right = ackermann delta^2 + toe in front, at the
    rear the toe that goes with the load."""
    toe_rear = q["toe_rear"] + q["toe_rear_load"] * (q["load_r"] - q["rest_load_r"])
    spread = (q["ackermann"] * q["delta"] ** 2 + q["toe"]) / 2
    out, back = q["scrub"] * (ca.cos(q["delta"]) - 1.0), q["scrub"] * ca.sin(q["delta"])
    springs = q["mass"] * q["transfer_height"] * q["roll_a"] + q["body_moment"]
    dampers = q["mass"] * q["transfer_height"] * DAMPER_TIME * q["roll_a_rate"]
    held, damped = q["roll_share_f"], q["damper_share_f"]
    # Of each axle: track, moment on its wheels' loads, how far out of line and back a wheel stands, its angle.
    axles = {
        "f": (q["track"], held * springs + damped * dampers, out, back, q["delta"], spread),
        "r": (q["track_rear"], (1.0 - held) * springs + (1.0 - damped) * dampers, 0.0, 0.0, 0.0, toe_rear / 2),
    }
    corners = []
    for axle, (track, moment, outward, backward, delta, apart) in axles.items():
        load, moved = q[f"load_{axle}"] / 2, moment / track
        for side, letter in ((1, "l"), (-1, "r")):
            y = side * (track / 2 + outward) + q[f"aside_{axle}"]
            # A wheel that has lifted carries nothing.
            carried = smooth_positive(load - side * moved, 50.0)
            spin = q[f"spin_{axle}{letter}"]
            corners.append(Corner(axle, side, 1, y, carried, delta, spin, x=-side * backward, apart=side * apart))
    return {"wheels": tuple(corners)}


def multipass(wheelbase: float) -> Effect:
    """Rear wheels in the front wheels' ruts: there shear path and depth start at kappa times what the front wheel left.

    wheelbase (m) sets how much of the rut is remembered. The rut is kept as samples behind the front axle (place, shear
    path, depth and edges of what each front wheel pressed), moved with the vehicle's motion; the share of the rear wheel's
    width that runs in it stands on its floor. From the soil contact model: shear path and plastic sinkage stay in the soil.
    """
    spacing = RUT_REACH * wheelbase / (RUT_CELLS - 2)
    cells = track_layout("rut", RUT_CELLS, RUT_VALUES)
    provides = Layout.of(
        Signal("rut_offset_l", "m", "lateral position of the front left wheel's rut at the rear axle"),
        Signal("rut_offset_r", "m", "lateral position of the front right wheel's rut at the rear axle"),
        Signal("rut_path_l", "m", "shear path that the front left wheel left where the rear one stands"),
        Signal("rut_path_r", "m", "shear path that the front right wheel left where the rear one stands"),
        Signal("rut_depth_l", "m", "depth of the front left wheel's rut where the rear one stands"),
        Signal("rut_depth_r", "m", "depth of the front right wheel's rut where the rear one stands"),
        Signal("rut_edge", "m", "width of the ruts' edges"),
    )
    values = dict(zip(provides.names, (value.name for value in RUT_VALUES[1:]), strict=True))

    def read(q: Quantities) -> Quantities:
        track = read_cells(q["memory"], "rut", RUT_CELLS, RUT_VALUES)
        return {out: interpolate(track, "d", wheelbase, name) for out, name in values.items()}

    def advance(q: Quantities) -> Quantities:
        aged = [_moved(q, cell) for cell in read_cells(q["memory"], "rut", RUT_CELLS, RUT_VALUES)]
        return write_cells(push(aged, _left_behind(q), "d", spacing), "rut")

    def start(q: Quantities) -> Quantities:
        new = _left_behind(q)
        return write_cells([{**new, "d": spacing * k} for k in range(RUT_CELLS)], "rut")

    return Effect(
        name="multipass",
        doc="rear wheels run in the front wheels' ruts, in soil that is sheared already",
        reference="soil contact model: shear path is a property of the soil and is never reset",
        parameters=Layout.of(
            Signal("kappa", "", "share of the front wheels' ruts, path and depth, that is met", 0.0, 0.0, 1.5, spread=1)
        ),
        typical={"kappa": 0.7},
        corrections={"contacts": each_wheel(_in_rut)},
        memories=(Memory("multipass", cells, provides, read, advance, start),),
        confusable=("payload",),
        separates="straight driving and tight turns in one drive",
    )


def _moved(q: Quantities, cell: Quantities) -> Quantities:
    """A point of the soil in the yaw frame at the front axle, one step later."""
    turn = q["omega_z"] * q["dt"]
    ahead, aside = -cell["d"] - q["u"] * q["dt"], (q["v"] + q["l_f"] * q["omega_z"]) * q["dt"]
    cos, sin = 1.0 - 0.5 * turn * turn, turn
    left, right = cell["el"] - aside, cell["er"] - aside
    middle = 0.5 * (left + right)
    moved = {"d": -(ahead * cos + middle * sin), "el": -ahead * sin + left * cos, "er": -ahead * sin + right * cos}
    return {**cell, **moved}


def _left_behind(q: Quantities) -> Cell:
    """What the front wheels leave now, at the axle."""
    fronts = [(corner, corner.force) for corner in q["wheels"] if corner.axle == "f"]
    (of_left, left), (of_right, right) = fronts[0], fronts[-1]  # the same, of an axle taken as one wheel
    return {
        "d": 0.0,
        "el": of_left.y + left.exit_shift,
        "er": of_right.y + right.exit_shift,
        "jl": left.exit_path,
        "jr": right.exit_path,
        "hl": left.sinkage,
        "hr": right.sinkage,
        "w": 0.5 * (left.exit_drift + right.exit_drift),
    }


def _in_rut(q: Quantities, corner: Corner) -> Corner:
    """The rear wheel's share in the rut: 1 - |y_off|/b of two rectangles, put right for edges of width w over which the path
    falls from J to 0: |y_off| counts at least w/4, and what the edges' soil has mobilised widens the rut by w (coth(J/2)/2 -
    1/J - 1/2), J in shear moduli, here by J/sqrt(144 + 16 J^2).
    """
    if corner.axle == "f" or corner.contact is None:
        return corner
    width, edge = q["width"], q["rut_edge"]
    offset, path, depth = (_of_side(q, corner.side, name) for name in ("rut_offset", "rut_path", "rut_depth"))
    path, depth = q["kappa"] * path, q["kappa"] * depth
    spent = path / corner.soil.k  # type: ignore[union-attr]
    wider = edge * spent / ca.sqrt(144.0 + 16.0 * spent * spent)
    apart = smooth_norm(offset - corner.y, 0.25 * edge, 0.01 * width)
    overlap = smooth_positive(1.0 - (apart - wider) / width, 0.02)
    in_rut = replace(corner.contact, entry_path=path, overlap=overlap, rut_depth=depth)
    return corner.with_(contact=in_rut)


def _of_side(q: Quantities, side: int, name: str) -> Scalar:
    """The left, the right or, for an axle taken as one wheel, the mean value."""
    left, right = q[f"{name}_l"], q[f"{name}_r"]
    return {1: left, -1: right, 0: 0.5 * (left + right)}[side]
