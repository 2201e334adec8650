"""Rear wheels that run in the front wheels' ruts."""

from dataclasses import replace
from functools import partial

import casadi as ca

from softsoil.symbolic.effect import Corner, Correction, Effect, Layout, Signal, Vehicle, each_wheel
from softsoil.symbolic.model import Memory, Quantities, Scalar
from softsoil.symbolic.smooth import fade_in, smooth_min, smooth_norm, smooth_positive
from softsoil.symbolic.track import Cell, interpolate, push, read_cells, track_layout, write_cells

RUT_CELLS = 17
RUT_REACH = 1.125
"""Length of the rut that is remembered, over the wheelbase."""
LEAST_KAPPA = 0.05
"""kappa from which on a wheel has its full share in the rut; below it comes in smoothly, none where the effect is absent."""
STATED = 1e-3
"""Spread of a number that no fit moves: it is one of two kinds of ground."""
CRAWL = 0.5
"""m/s: below it the rut behind the front axle stays as it was: paths and drifts are divided by the speed, and what they leave
there would grow from sample to sample, as no window runs there either."""
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


def effect(vehicle: Vehicle) -> Effect:
    """Rear wheels in the front wheels' ruts: there shear path and depth start at kappa times what the front wheel left.

    The wheelbase sets how much of the rut is remembered. The rut is kept as samples behind the front axle (place, shear
    path, depth and edges of what each front wheel pressed), moved with the vehicle's motion; the share of the rear wheel's
    width that runs in it stands on its floor. From the soil contact model: shear path and plastic sinkage stay in the soil. Of
    natural soils Wong (Theory of Ground Vehicles, on repetitive shear loading) reports that a second shearing begins anew: there
    `sheared` is 0, and the depth alone is met.
    """
    wheelbase = vehicle.wheelbase
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
        kind="soil",
        reference="soil contact model: shear path is a property of the soil and is never reset",
        parameters=Layout.of(
            Signal("kappa", "", "share of the front wheels' ruts, path and depth, that is met", 0.0, 0.0, 1.5, spread=1),
            Signal("sheared", "", "share of that path that stays: 0 on soil that shears anew", 1.0, 0.0, 1.0, spread=STATED),
        ),
        typical={"kappa": 0.7, "sheared": 1.0},
        corrections={
            "contacts": Correction(
                each_wheel(partial(_in_rut, one_width=vehicle.rear_width == vehicle.width)),
                reads=("width", "width_rear", "wheel.y", "wheel.soil.k"),
                sets=("wheel.contact.entry_path", "wheel.contact.overlap", "wheel.contact.rut_depth"),
            )
        },
        memories=(Memory("multipass", cells, provides, read, advance, start),),
        signatures=("cornering slope",),
        separates="straight driving and tight turns in one drive",
        rests_on=("v", "omega_z"),
        for_control={"kappa": 1.0},
    )


def _moved(q: Quantities, cell: Quantities) -> Quantities:
    """A point of the soil in the yaw frame at the front axle, one step later."""
    dt = q["dt"] * (q["u"] > CRAWL)
    turn = q["omega_z"] * dt
    ahead, aside = -cell["d"] - q["u"] * dt, (q["v"] + q["l_f"] * q["omega_z"]) * dt
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


def _in_rut(q: Quantities, corner: Corner, one_width: bool) -> Corner:
    """The rear wheel's share in the rut: 1 - |y_off|/b of two rectangles, put right for edges of width w over which the path
    falls from J to 0: |y_off| counts at least w/4, and what the edges' soil has mobilised widens the rut by w (coth(J/2)/2 -
    1/J - 1/2), J in shear moduli, here by J/sqrt(144 + 16 J^2). Of a rear wheel b_r wide in a rut b_f wide, not `one_width`, it
    is ((b_f + b_r)/2 - |y_off|)/b_r, at most b_f/b_r and 1.
    """
    if corner.axle == "f" or corner.contact is None:
        return corner
    width, edge = q["width_rear"], q["rut_edge"]
    offset, path, depth = (_of_side(q, corner.side, name) for name in ("rut_offset", "rut_path", "rut_depth"))
    path, depth = q["kappa"] * q["sheared"] * path, q["kappa"] * depth
    spent = path / corner.soil.k  # type: ignore[union-attr]
    wider = edge * spent / ca.sqrt(144.0 + 16.0 * spent * spent)
    apart = smooth_norm(offset - corner.y, 0.25 * edge, 0.01 * width)
    share = 1.0 - (apart - wider) / width
    if not one_width:
        narrower = q["width"] / width
        share = smooth_min(share + 0.5 * (narrower - 1.0), ca.fmin(narrower, 1.0), 0.02)
    overlap = fade_in(q["kappa"], LEAST_KAPPA) * smooth_positive(share, 0.02)
    in_rut = replace(corner.contact, entry_path=path, overlap=overlap, rut_depth=depth)
    return corner.with_(contact=in_rut)


def _of_side(q: Quantities, side: int, name: str) -> Scalar:
    """The left, the right or, for an axle taken as one wheel, the mean value."""
    left, right = q[f"{name}_l"], q[f"{name}_r"]
    return {1: left, -1: right, 0: 0.5 * (left + right)}[side]
