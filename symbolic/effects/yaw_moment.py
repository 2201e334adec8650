"""A constant moment about the vertical."""

from softsoil.symbolic.effect import GRAVITY, Correction, Effect, Layout, Signal, Vehicle


def effect(vehicle: Vehicle) -> Effect:
    """A constant moment about the vertical: a dragging brake, a towed load, the pull of a vehicle."""
    turn = GRAVITY * vehicle.mass * vehicle.wheelbase
    return Effect(
        name="yaw_moment",
        doc="a constant yaw moment, as of a dragging brake or a tow",
        kind="load",
        reference="moment balance",
        parameters=Layout.of(Signal("yaw_moment", "N m", "moment, left > 0", 0.0, -0.136 * turn, 0.136 * turn, 0.0408 * turn)),
        typical={"yaw_moment": 0.00816 * turn},
        corrections={"balance": Correction(lambda q: {"moment_z": q["moment_z"] + q["yaw_moment"]}, adds=("moment_z",))},
        signatures=("constant side force", "turning moment"),
        separates="several speeds: an offset's moment follows the tyre force, this one stands still",
        repeats=True,
        rests_on=("omega_z",),
        answers_to={"pull": ("yaw_moment",)},
    )
