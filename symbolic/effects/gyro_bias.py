"""A yaw-rate sensor with a bias."""

from softsoil.symbolic.effect import Correction, Effect, Layout, Signal, Vehicle


def effect(vehicle: Vehicle) -> Effect:
    """y_omega_z = omega_z + b."""
    return Effect(
        name="gyro_bias",
        doc="yaw-rate sensor with a bias",
        kind="sensor",
        reference="sensor model",
        parameters=Layout.of(Signal("gyro_bias", "rad/s", "bias of the yaw rate", 0.0, -0.3, 0.3, spread=0.03)),
        typical={"gyro_bias": 0.01},
        corrections={"outputs": Correction(lambda q: {"y_omega_z": q["y_omega_z"] + q["gyro_bias"]}, adds=("y_omega_z",))},
        signatures=("constant side force",),
        separates="any turning: kinematics alone (heading against yaw rate, position against speed) tells it",
        repeats=True,
        rests_on=("psi", "omega_z"),
        answers_to={"gyro_drift": ("gyro_bias",)},
    )
