"""How far the body has rolled: on its springs, by what pulls it sideways, and with the ground that its wheels press down."""

import casadi as ca

from softsoil.symbolic.model import Memory, Quantities, Scalar
from softsoil.symbolic.signals import Layout, Signal

LOWEST = 0.05
"""m: the least h_cg by which a moment is turned into a lateral acceleration; a vehicle may declare 0."""
GYRATION = 0.25
"""of the front track: radius of gyration of what rolls; 0.1 to 0.33 by the true roll of eleven simulated vehicles."""
LAYOUT = Layout.of(
    Signal("roll_a", "m/s^2", "lateral specific force that the body has followed"),
    Signal("roll_a_rate", "m/s^3", "its rate"),
    Signal("roll_tilt", "rad", "slope under the vehicle, of its wheels' sinkages"),
    Signal("roll_tilt_rate", "rad/s", "its rate"),
)


def body_roll() -> Memory:
    """Memory that all effects of the body's roll share: I phi'' + c phi' + k phi = M h a, with roll_gain = M h/k, roll_time = c/k
    and I = M (GYRATION track)^2.

    Provides roll_a (m/s^2), the lateral specific force that the body has followed, roll_tilt (rad), the slope that its wheels'
    sinkages give the vehicle, positive to the right, and the rates of both, `_rate`.
    """
    kept = Layout(tuple(Signal(f"kept_{signal.name}", signal.unit, signal.doc) for signal in LAYOUT))

    def advance(q: Quantities) -> Quantities:
        dt, gyration = q["dt"], GYRATION * q["track"]
        inert = q["roll_gain"] * q["burden"] * gyration * gyration / ca.fmax(q["h_cg"], LOWEST)
        # Explicit for a short step of a body that swings, where an implicit one would damp; exact to dt^3 for one that does not.
        damped = q["roll_time"] * dt
        quick = dt * dt + 3.0 * damped
        slow = inert + damped + dt * dt * quick / (quick + 3.0 * damped + 4.0 * inert)
        cells: Quantities = {}
        for name, target in (("a", q["force_y"] / q["mass"]), ("tilt", _tilt(q))):
            before, rate = q["memory"][f"kept_roll_{name}"], q["memory"][f"kept_roll_{name}_rate"]
            rate = (inert * rate + dt * (target - before)) / slow
            cells |= {f"kept_roll_{name}": before + dt * rate, f"kept_roll_{name}_rate": rate}
        return cells

    def start(q: Quantities) -> Quantities:
        return dict.fromkeys(kept.names, 0.0) | {"kept_roll_a": q["u"] * q["omega_z"], "kept_roll_tilt": _tilt(q)}

    def read(q: Quantities) -> Quantities:
        return {name: q["memory"][f"kept_{name}"] for name in LAYOUT.names}

    return Memory("body_roll", kept, LAYOUT, read=read, advance=advance, start=start)


def roll_angle(q: Quantities) -> tuple[Scalar, Scalar]:
    """(rad, rad/s) roll to the right of the body: roll_gain (a + a_m) in proportion to the mass that rolls,
    and the slope; a_m = body_moment/(M h_cg) rolls it as far as the moment on it does."""
    gain = q["roll_gain"] * q["burden"]
    by_moment = q["body_moment"] / (q["mass"] * ca.fmax(q["h_cg"], LOWEST))
    return gain * (q["roll_a"] + by_moment) + q["roll_tilt"], gain * q["roll_a_rate"] + q["roll_tilt_rate"]


def _tilt(q: Quantities) -> Scalar:
    """Mean over the axles of how much deeper the right wheel stands, over the track (rad); 0 for axles taken as one wheel."""
    deeper = 0.0
    for corner in q["wheels"]:
        track = q["track"] if corner.axle == "f" else q["track_rear"]
        deeper = deeper - 0.5 * corner.side * corner.force.sinkage / track
    return deeper
