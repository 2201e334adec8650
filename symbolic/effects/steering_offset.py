"""Road wheels that stand off the command by a constant angle."""

from softsoil.symbolic.effect import Correction, Effect, Layout, Signal, Vehicle
from softsoil.symbolic.steering import RESTS_ON


def effect(vehicle: Vehicle) -> Effect:
    """delta_a = delta + d0."""
    return Effect(
        name="steering_offset",
        doc="road wheels stand off the command by a constant angle",
        kind="steering",
        reference="wheel alignment",
        parameters=Layout.of(Signal("steering_offset", "rad", "constant steering angle", 0.0, -0.2, 0.2, spread=0.05)),
        typical={"steering_offset": 0.02},
        corrections={"inputs": Correction(lambda q: {"delta": q["delta"] + q["steering_offset"]}, adds=("delta",))},
        signatures=("constant side force",),
        separates="driving on several headings at several speeds",
        repeats=True,
        rests_on=RESTS_ON,
        answers_to={"steer_offset": ("steering_offset",)},
    )
