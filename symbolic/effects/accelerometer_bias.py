"""An accelerometer with a bias along the vehicle's axis."""

from softsoil.symbolic.effect import Correction, Effect, Layout, Signal, Vehicle

INPUTS = ("du", "specific_x")


def effect(vehicle: Vehicle) -> Effect:
    """a_x_imu = du/dt - v omega_z + b: the model's du/dt comes from the sensor, so that b is taken off it."""
    bias = Signal("accelerometer_bias", "m/s^2", "bias of the longitudinal accelerometer", 0.0, -2.0, 2.0, spread=0.4)
    return Effect(
        name="accelerometer_bias",
        doc="longitudinal accelerometer with a bias",
        kind="sensor",
        reference="sensor model",
        parameters=Layout.of(bias),
        typical={"accelerometer_bias": 0.2},
        corrections={"inputs": Correction(lambda q: {name: q[name] - q["accelerometer_bias"] for name in INPUTS}, adds=INPUTS)},
        signatures=("resistance",),
        separates="several headings: a grade turns its sign with the heading, a bias does not",
        rests_on=("u", "a_x_imu"),
    )
