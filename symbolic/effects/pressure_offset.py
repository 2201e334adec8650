"""Pressure that acts ahead of the wheels' centres."""

import casadi as ca

from softsoil.symbolic.bicycle import radius_of
from softsoil.symbolic.effect import GRAVITY, Corner, Correction, Effect, Layout, Signal, Vehicle
from softsoil.symbolic.history import lag_share
from softsoil.symbolic.model import Memory, Quantities, Scalar

PITCH_TIME = 0.15
"""s: how long a suspended body takes to follow a pitching moment (first order)."""


def effect(vehicle: Vehicle) -> Effect:
    """Pressure acts ahead of the wheels' centres: the axle loads balance there, share * sum W (X_p - e)/L moves to the rear.

    X_p is the centre of pressure by the force law, as the suspended body has followed it (first order, PITCH_TIME). It takes
    the place of the vehicle's constant `load_offset` e, which stands for one soil and one sinkage. The body leans back, by
    pitch_gain sum W X_p on its springs and by as much as its rear wheels stand deeper, and its centre of gravity, h_cg - radius
    above the axles, comes to stand further behind the front and less far ahead of the rear axle.
    """
    values = (
        Signal("pressure_moment", "N m", "moment of the pressures that the body has followed"),
        Signal("ground_pitch", "rad", "slope that the body has followed, of its axles' sinkages, nose up"),
    )
    cells = {signal.name: f"kept_{signal.name}" for signal in values}

    def start(q: Quantities) -> Quantities:
        return {cells["pressure_moment"]: _pressure_moment(q), cells["ground_pitch"]: _ground_pitch(q)}

    def advance(q: Quantities) -> Quantities:
        share, kept = lag_share(q["dt"], PITCH_TIME), q["memory"]
        return {cell: kept[cell] + share * (now - kept[cell]) for cell, now in start(q).items()}

    def leaning_back(q: Quantities) -> Quantities:
        pitch = q["ground_pitch"] + q["pitch_gain"] * q["pressure_moment"]
        back = q["pressure_share"] * ca.fmax(q["h_cg"] - 0.5 * (q["radius"] + q["radius_rear"]), 0.0) * pitch
        return {"l_f": q["l_f"] + back, "l_r": q["l_r"] - back}

    def loads(q: Quantities) -> Quantities:
        declared = q["mass"] * GRAVITY * q["load_offset"]
        moved = q["pressure_share"] * (q["pressure_moment"] - declared) / (q["l_f"] + q["l_r"])
        return {"load_f": q["load_f"] - moved, "load_r": q["load_r"] + moved}

    memory = Memory(
        "pressure_offset",
        Layout(tuple(Signal(cells[signal.name], signal.unit, signal.doc) for signal in values)),
        Layout(values),
        read=lambda q: {name: q["memory"][cell] for name, cell in cells.items()},
        advance=advance,
        start=start,
    )
    return Effect(
        name="pressure_offset",
        doc="pressure acts ahead of the wheels' centres and moves load to the rear axle, more in soft soil",
        kind="soil",
        reference="moment balance in pitch; moment of the contact stresses about the wheel's axis",
        parameters=Layout.of(
            Signal("pressure_share", "", "share of the force law's centre of pressure", 0.0, 0.0, 2.0, spread=1)
        ),
        typical={"pressure_share": 1.0},
        corrections={
            "vehicle": Correction(leaning_back, reads=("h_cg", "radius", "radius_rear", "pitch_gain"), adds=("l_f", "l_r")),
            "loads": Correction(loads, reads=("mass", "load_offset", "l_f", "l_r"), adds=("load_f", "load_r")),
        },
        memories=(memory,),
        signatures=("cornering slope",),
        separates="drives on soils of different sinkage, given together",
        rests_on=("v", "omega_z"),
    )


def _ground_pitch(q: Quantities) -> Scalar:
    """How much deeper the rear wheels stand, over the wheelbase (rad)."""
    sunk = {axle: [w.force.sinkage for w in q["wheels"] if w.axle == axle] for axle in "fr"}
    rear, front = (sum(sunk[axle]) / len(sunk[axle]) for axle in "rf")
    return (rear - front) / (q["l_f"] + q["l_r"])


def _pressure_moment(q: Quantities) -> Scalar:
    """Sum of W X_p over the wheels (N m): m_y without what the longitudinal shear does at the middle of its depth."""
    return -sum(corner.count * _pitch(corner, radius_of(q, corner)) for corner in q["wheels"])


def _pitch(corner: Corner, radius: Scalar) -> Scalar:
    force = corner.force
    return force.m_y + (radius - 0.5 * force.sinkage) * force.f_x  # type: ignore[union-attr]
