"""Road wheels that turn by another ratio than the command says."""

from softsoil.symbolic.effect import Correction, Effect, Layout, Signal, Vehicle
from softsoil.symbolic.model import Quantities
from softsoil.symbolic.steering import RESTS_ON


def effect(vehicle: Vehicle) -> Effect:
    """delta_a = k delta."""
    return Effect(
        name="steering_gain",
        doc="road wheels turn by another ratio than the command says",
        kind="steering",
        reference="steering ratio",
        parameters=Layout.of(Signal("steering_gain", "", "road-wheel angle over command", 1.0, 0.5, 1.5, spread=0.1)),
        typical={"steering_gain": 1.05},
        corrections={"inputs": Correction(_compute, adds=("delta", "delta_rate"))},
        signatures=("cornering slope",),
        separates="small and large steering angles at several speeds: n changes the slope, the gain the angle itself",
        rests_on=RESTS_ON,
        answers_to={"steer_gain": ("steering_gain",)},
    )


def _compute(q: Quantities) -> Quantities:
    more = q["steering_gain"] - 1.0
    return {"delta": q["delta"] + more * q["steer"], "delta_rate": q["delta_rate"] + more * q["steer_rate"]}
