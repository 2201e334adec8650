"""A load carried: mass, its place along the vehicle, and the inertia that follows."""

from softsoil.symbolic.effect import GRAVITY, Correction, Effect, Layout, Signal, Vehicle
from softsoil.symbolic.model import Quantities


def effect(vehicle: Vehicle) -> Effect:
    """A body of mass m at x behind the front axle; (u, v) still belong to the bare vehicle's centre of gravity.

    With s = m (x - l_f)/(M + m): (M + m)(dv/dt + u omega_z - s d(omega_z)/dt) = F, I' d(omega_z)/dt = N + s F,
    I' = I + M m/(M + m) (x - l_f)^2; the axle loads follow by the lever rule.
    """
    base, most = vehicle.wheelbase, max(3000.0, 2 * vehicle.mass)
    reach = min(-2.0, -0.7 * base), max(6.0, 2.2 * base)
    return Effect(
        name="payload",
        doc="a load carried: mass, its place along the vehicle, and the inertia that follows",
        kind="load",
        reference="rigid bodies joined; parallel axis theorem",
        parameters=Layout.of(
            Signal("payload_mass", "kg", "mass of the load", 0.0, 0.0, most, 0.29 * vehicle.mass),
            Signal("payload_x", "m", "its place behind the front axle", 0.55 * base, *reach, 0.37 * base),
        ),
        typical={"payload_mass": 0.11 * vehicle.mass, "payload_x": 0.8 * base},
        corrections={
            "vehicle": Correction(
                _body, reads=("mass", "l_f"), adds=("mass", "yaw_inertia"), scales=("burden",), sets=("shift",)
            ),
            "loads": Correction(_loads, reads=("l_f", "l_r"), adds=("load_f", "load_r")),
            "rates": Correction(
                _rates, reads=("moment_z", "shift", "force_y", "yaw_inertia"), adds=("d_v",), sets=("d_omega_z",)
            ),
        },
        signatures=("cornering slope",),
        separates="straight driving and tight turns: a rut vanishes in tight turns, a load does not",
        rests_on=("v", "omega_z"),
        answers_to={"load_carried": ("payload_mass",)},
    )


def _body(q: Quantities) -> Quantities:
    total = q["mass"] + q["payload_mass"]
    arm = q["payload_x"] - q["l_f"]
    inertia = q["yaw_inertia"] + q["mass"] * q["payload_mass"] / total * arm**2
    burden = q["burden"] * total / q["mass"]
    return {"mass": total, "burden": burden, "yaw_inertia": inertia, "shift": q["payload_mass"] / total * arm}


def _loads(q: Quantities) -> Quantities:
    moved = q["payload_mass"] * GRAVITY * (q["payload_x"] - q["l_f"]) / (q["l_f"] + q["l_r"])
    return {"load_f": q["load_f"] - moved, "load_r": q["load_r"] + moved}


def _rates(q: Quantities) -> Quantities:
    turn = (q["moment_z"] + q["shift"] * q["force_y"]) / q["yaw_inertia"]
    return {"d_omega_z": turn, "d_v": q["d_v"] + q["shift"] * turn}
