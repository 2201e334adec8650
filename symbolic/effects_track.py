"""Effects of two tracks and of the rut: lateral load transfer, and rear wheels that follow the front ones."""

from __future__ import annotations

from dataclasses import replace

from symbolic.bicycle import Corner
from symbolic.body_roll import body_roll
from symbolic.drive_torque import drive_torque
from symbolic.effects import Effect, each_wheel
from symbolic.model import Memory, Quantities
from symbolic.signals import Layout, Signal
from symbolic.smooth import smooth_norm, smooth_positive
from symbolic.track import interpolate, push, read_cells, track_layout, write_cells

ROLL_TIME = 0.15
"""s: how late (first order) what the roll does to the wheels follows the lateral acceleration: between their loads, which the
dampers carry at once, and the body's angle (`symbolic.effects_lean.LEAN_TIME`)."""
RUT_CELLS = 40
RUT_REACH = 1.3
"""Length of the rut that is remembered, over the wheelbase."""
RUT_VALUES = (
    Signal("d", "m", "distance behind the front axle"),
    Signal("e", "m", "lateral position in the yaw frame"),
    Signal("jl", "m", "shear path left by the front left wheel"),
    Signal("jr", "m", "shear path left by the front right wheel"),
)


def load_transfer() -> Effect:
    """Body roll: each wheel its own load, Delta F_z = share (M a h + roll_moment)/T, and rear wheels that lean with the body.

    a is the lateral specific force as the rolled body has followed it (first order, ROLL_TIME). Two tracks then carry the
    yaw moment of the wheel that bears more and rolls with more resistance; needs wheel speeds. While the body rolls, a
    wheel that leans with it sweeps its contact sideways: v_y += roll_sweep da/dt at the rear (roll rate times radius),
    in proportion to the mass that rolls. A moment on the body loads one side more and rolls it when driving straight, too:
    shaft_share of the wheels' driving torque, which a propeller shaft hands on to the chassis (1/final drive, negative where
    it rolls to the left), and roll_moment, which is always there (a centre of gravity off the middle).
    """
    parameters = Layout.of(
        Signal("transfer_height", "m", "effective height of the load transfer", 0.0, 0.0, 2.0, spread=1),
        Signal(
            "roll_sweep",
            "s^2",
            "sideways sweep of the rear contact per rate of lateral acceleration",
            0.0,
            -0.03,
            0.03,
            spread=0.01,
        ),
        Signal("roll_moment", "N m", "roll to the right when driving straight", 0.0, -2000.0, 2000.0, spread=300),
        Signal("shaft_share", "", "roll to the right per driving torque of the wheels", 0.0, -1.0, 1.0, spread=0.2),
    )
    return Effect(
        name="load_transfer",
        doc="body roll: load transfer on two tracks with the yaw moment of unequal resistance, and the rear wheels' lean",
        reference="moment balance about the roll axis; two-track kinematics",
        parameters=parameters,
        typical={"transfer_height": 0.63, "roll_sweep": 0.004, "roll_moment": 0.0, "shaft_share": 0.0},
        corrections={"loads": _moment_on_body, "tracks": _two_tracks, "contacts": each_wheel(_leaning)},
        memories=(body_roll("load_transfer", "a_y_roll", "a_y_body", ROLL_TIME), drive_torque("load_transfer")),
        confusable=("locked_differential", "yaw_moment"),
        separates="turns of both signs at several lateral accelerations and speeds",
        drawn=("roll_moment", "shaft_share"),
    )


def _moment_on_body(q: Quantities) -> Quantities:
    return {"body_moment": q["roll_moment"] + q["shaft_share"] * q["drive_torque"]}


def _leaning(q: Quantities, corner: Corner) -> Corner:
    if corner.axle != "r" or corner.contact is None:
        return corner
    sweep = q["roll_sweep"] * q["burden"] * q["a_y_body_rate"]
    return corner.with_(contact=replace(corner.contact, v_y=corner.contact.v_y + sweep))


def _two_tracks(q: Quantities) -> Quantities:
    """Left and right wheels in the place of each axle's pair; delta_left - delta_right = ackermann delta^2 + toe."""
    half_track = q["track"] / 2
    spread = (q["ackermann"] * q["delta"] ** 2 + q["toe"]) / 2
    moved = (q["mass"] * q["a_y_body"] * q["transfer_height"] + q["body_moment"]) / q["track"]
    share = {"f": q["roll_share_f"], "r": 1.0 - q["roll_share_f"]}
    corners = []
    for axle in ("f", "r"):
        load = q[f"load_{axle}"] / 2
        for side, letter in ((1, "l"), (-1, "r")):
            delta = q["delta"] + side * spread if axle == "f" else 0.0
            # A wheel that has lifted carries nothing.
            carried = smooth_positive(load - side * share[axle] * moved, 50.0)
            corners.append(Corner(axle, side, 1, side * half_track, carried, delta, q[f"spin_{axle}{letter}"]))
    return {"wheels": tuple(corners)}


def multipass(wheelbase: float) -> Effect:
    """Rear wheels in the front wheels' ruts: there the shear path starts at kappa times what the front wheel left.

    wheelbase (m) sets how much of the rut is remembered. The rut is kept as samples behind the front axle (place and
    shear path where each front wheel stood), moved with the vehicle's motion; a fraction max(0, 1 - |y_off|/b) of the
    rear wheel's width runs in it. From the soil contact model: shear path stays in the soil.
    """
    spacing = RUT_REACH * wheelbase / (RUT_CELLS - 2)
    cells = track_layout("rut", RUT_CELLS, RUT_VALUES)
    provides = Layout.of(
        Signal("rut_offset", "m", "lateral position of the rut at the rear axle"),
        Signal("rut_path_l", "m", "shear path that the front left wheel left where the rear one stands"),
        Signal("rut_path_r", "m", "shear path that the front right wheel left where the rear one stands"),
    )

    def read(q: Quantities) -> Quantities:
        track = read_cells(q["memory"], "rut", RUT_CELLS, RUT_VALUES)
        names = {"rut_offset": "e", "rut_path_l": "jl", "rut_path_r": "jr"}
        return {out: interpolate(track, "d", wheelbase, name) for out, name in names.items()}

    def advance(q: Quantities) -> Quantities:
        aged = [_moved(q, cell) for cell in read_cells(q["memory"], "rut", RUT_CELLS, RUT_VALUES)]
        left, right = _front_paths(q)
        new = {"d": 0.0, "e": 0.0, "jl": left, "jr": right}
        return write_cells(push(aged, new, "d", spacing), "rut")

    def start(q: Quantities) -> Quantities:
        left, right = _front_paths(q)
        return write_cells([{"d": spacing * k, "e": 0.0, "jl": left, "jr": right} for k in range(RUT_CELLS)], "rut")

    return Effect(
        name="multipass",
        doc="rear wheels run in the front wheels' ruts, in soil that is sheared already",
        reference="soil contact model: shear path is a property of the soil and is never reset",
        parameters=Layout.of(
            Signal(
                "kappa", "", "share of the front wheels' shear path that the rear wheels meet", 0.0, 0.0, 1.5, spread=1
            )
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
    ahead = -cell["d"] - q["u"] * q["dt"]
    left = cell["e"] - (q["v"] + q["l_f"] * q["omega_z"]) * q["dt"]
    cos, sin = 1.0 - 0.5 * turn * turn, turn
    return {**cell, "d": -(ahead * cos + left * sin), "e": -ahead * sin + left * cos}


def _front_paths(q: Quantities):
    """Shear paths (left, right) that the front wheels leave now (m)."""
    paths = {c.side: c.force.exit_path for c in q["wheels"] if c.axle == "f"}
    return (paths[1], paths[-1]) if 1 in paths else (paths[0], paths[0])


def _in_rut(q: Quantities, corner: Corner) -> Corner:
    if corner.axle != "r" or corner.contact is None:
        return corner
    path = {1: q["rut_path_l"], -1: q["rut_path_r"], 0: (q["rut_path_l"] + q["rut_path_r"]) / 2}[corner.side]
    width = q["width"]
    overlap = smooth_positive(1.0 - smooth_norm(q["rut_offset"], 0.0, 0.03 * width) / width, 0.02)
    return corner.with_(contact=replace(corner.contact, entry_path=q["kappa"] * path, overlap=overlap))
