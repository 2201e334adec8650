"""How far the body has rolled: on its springs, by what pulls it sideways, and with the ground that its wheels press down."""

from __future__ import annotations

import casadi as ca

from symbolic.history import lag_share
from symbolic.model import Memory, Quantities, Scalar
from symbolic.signals import Layout, Signal

ROLL_TIME = 0.165
"""s: how long a damped body takes to roll (first order)."""
LOWEST = 0.05
"""m: the least h_cg by which a moment is turned into a lateral acceleration; a vehicle may declare 0."""


def body_roll(effect: str, prefix: str) -> Memory:
    """Memory of an effect, first order, ROLL_TIME late: provides <prefix>_a (m/s^2), the lateral specific force that the body has
    followed, <prefix>_tilt (rad), the slope that its wheels' sinkages give the vehicle, positive to the right, and the rates of
    both, `_rate`.
    """
    layout = Layout.of(
        Signal(f"{prefix}_a", "m/s^2", "lateral specific force that the body has followed"),
        Signal(f"{prefix}_a_rate", "m/s^3", "its rate"),
        Signal(f"{prefix}_tilt", "rad", "slope under the vehicle, of its wheels' sinkages"),
        Signal(f"{prefix}_tilt_rate", "rad/s", "its rate"),
    )
    kept = Layout(tuple(Signal(f"kept_{signal.name}", signal.unit, signal.doc) for signal in layout))

    def advance(q: Quantities) -> Quantities:
        share = lag_share(q["dt"], ROLL_TIME)
        cells: Quantities = {}
        for name, target in (("a", q["force_y"] / q["mass"]), ("tilt", _tilt(q))):
            before = q["memory"][f"kept_{prefix}_{name}"]
            moved = share * (target - before)
            cells |= {f"kept_{prefix}_{name}": before + moved, f"kept_{prefix}_{name}_rate": moved / q["dt"]}
        return cells

    def start(q: Quantities) -> Quantities:
        rest = {f"kept_{prefix}_a_rate": 0.0, f"kept_{prefix}_tilt_rate": 0.0}
        return {f"kept_{prefix}_a": q["u"] * q["omega_z"], f"kept_{prefix}_tilt": _tilt(q), **rest}

    def read(q: Quantities) -> Quantities:
        return {name: q["memory"][f"kept_{name}"] for name in layout.names}

    return Memory(effect, kept, layout, read=read, advance=advance, start=start)


def roll_angle(q: Quantities, prefix: str) -> tuple[Scalar, Scalar]:
    """(rad, rad/s) roll to the right of the body of an effect's memory: roll_gain (a + a_m) in proportion to the mass that rolls,
    and the slope; a_m = body_moment/(M h_cg) rolls it as far as the moment on it does."""
    gain = q["roll_gain"] * q["burden"]
    by_moment = q["body_moment"] / (q["mass"] * ca.fmax(q["h_cg"], LOWEST))
    return (
        gain * (q[f"{prefix}_a"] + by_moment) + q[f"{prefix}_tilt"],
        gain * q[f"{prefix}_a_rate"] + q[f"{prefix}_tilt_rate"],
    )


def _tilt(q: Quantities) -> Scalar:
    """Mean over the axles of how much deeper the right wheel stands, over the track (rad); 0 for axles taken as one wheel."""
    deeper = 0.0
    for corner in q["wheels"]:
        track = q["track"] if corner.axle == "f" else q["track_rear"]
        deeper = deeper - 0.5 * corner.side * corner.force.sinkage / track
    return deeper
