"""Tyre force that needs a travelled length to build up."""

import casadi as ca

from softsoil.symbolic.effect import Correction, Effect, Layout, Signal, Vehicle
from softsoil.symbolic.model import Quantities

STATES = Layout.of(
    Signal("relaxed_f", "N", "lateral force of the front axle, built up"),
    Signal("relaxed_r", "N", "lateral force of the rear axle, built up"),
)


def effect(vehicle: Vehicle) -> Effect:
    """(l/u) dF/dt + F = F_ss on both axles: the force needs a travelled length to build up."""
    return Effect(
        name="relaxation",
        doc="tyre force that needs a travelled length to build up",
        kind="tyre",
        reference="first-order tyre relaxation (Pacejka)",
        parameters=Layout.of(Signal("relaxation_length", "m", "relaxation length beyond 0.15 m", 0.0, 0.0, 2.0, spread=0.7)),
        typical={"relaxation_length": 0.2},
        corrections={
            "balance": Correction(
                _balance,
                reads=("force_f", "force_r", "l_f", "l_r"),
                adds=("force_y", "moment_z"),
                sets=("steady_f", "steady_r", "force_f", "force_r"),
            ),
            "rates": Correction(_rates, reads=("steady_f", "steady_r"), sets=("d_relaxed_f", "d_relaxed_r")),
        },
        states=STATES,
        signatures=("late steering",),
        separates="the same steering at several speeds: this lag is proportional to 1/u and is there at the rear too",
        rests_on=("u", "v", "omega_z"),
    )


def _balance(q: Quantities) -> Quantities:
    # Share of the built-up force: none at length 0, so that the absent effect leaves the forces as they are.
    share = q["relaxation_length"] / (q["relaxation_length"] + 0.01)
    front = q["force_f"] + share * (q["relaxed_f"] - q["force_f"])
    rear = q["force_r"] + share * (q["relaxed_r"] - q["force_r"])
    moment = (front - q["force_f"]) * q["l_f"] - (rear - q["force_r"]) * q["l_r"]
    return {
        "steady_f": q["force_f"],
        "steady_r": q["force_r"],
        "force_f": front,
        "force_r": rear,
        "force_y": q["force_y"] + front + rear - q["force_f"] - q["force_r"],
        "moment_z": q["moment_z"] + moment,
    }


def _rates(q: Quantities) -> Quantities:
    speed = ca.sqrt(q["u"] * q["u"] + 0.01) / (q["relaxation_length"] + 0.15)
    return {f"d_relaxed_{axle}": speed * (q[f"steady_{axle}"] - q[f"relaxed_{axle}"]) for axle in ("f", "r")}
