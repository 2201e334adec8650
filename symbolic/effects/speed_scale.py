"""A speed sensor with a wrong scale."""

from softsoil.symbolic.effect import Correction, Effect, Layout, Signal, Vehicle


def effect(vehicle: Vehicle) -> Effect:
    """y_u = k u."""
    return Effect(
        name="speed_scale",
        doc="speed sensor with a wrong scale",
        kind="sensor",
        reference="sensor model",
        parameters=Layout.of(Signal("speed_scale", "", "measured over true speed", 1.0, 0.5, 1.5, spread=0.1)),
        typical={"speed_scale": 1.03},
        corrections={"outputs": Correction(lambda q: {"y_u": q["y_u"] * q["speed_scale"]}, scales=("y_u",))},
        separates="any turning: kinematics alone (heading against yaw rate, position against speed) tells it",
        rests_on=("x", "y", "u"),
        answers_to={"speed_error": ("speed_scale",)},
    )
