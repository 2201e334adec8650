"""A constant moment about the vertical."""

from softsoil.symbolic.effect import Correction, Effect, Layout, Signal, Vehicle


def effect(vehicle: Vehicle) -> Effect:
    """A constant moment about the vertical: a dragging brake, a towed load, the pull of a vehicle."""
    return Effect(
        name="yaw_moment",
        doc="a constant yaw moment, as of a dragging brake or a tow",
        kind="load",
        reference="moment balance",
        parameters=Layout.of(Signal("yaw_moment", "N m", "moment, left positive", 0.0, -5000.0, 5000.0, spread=1500)),
        typical={"yaw_moment": 300.0},
        corrections={"balance": Correction(lambda q: {"moment_z": q["moment_z"] + q["yaw_moment"]}, adds=("moment_z",))},
        signatures=("constant side force", "turning moment"),
        separates="several speeds: an offset's moment follows the tyre force, this one stands still",
        repeats=True,
        rests_on=("omega_z",),
        answers_to={"pull": ("yaw_moment",)},
    )
