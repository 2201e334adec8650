"""An accelerometer with a bias along the vehicle's axis."""

from __future__ import annotations

from softsoil.symbolic.effect import Effect
from softsoil.symbolic.model import Quantities
from softsoil.symbolic.signals import Layout, Signal


def accelerometer_bias() -> Effect:
    """a_x_imu = du/dt - v omega_z + b: the model's du/dt comes from the sensor, so that b is taken off it."""
    bias = Signal("accelerometer_bias", "m/s^2", "bias of the longitudinal accelerometer", 0.0, -2.0, 2.0, spread=0.4)
    return Effect(
        name="accelerometer_bias",
        doc="longitudinal accelerometer with a bias",
        reference="sensor model",
        parameters=Layout.of(bias),
        typical={"accelerometer_bias": 0.2},
        corrections={"inputs": _inputs},
        confusable=("grade", "motion_resistance"),
        separates="several headings: a grade turns its sign with the heading, a bias does not",
    )


def _inputs(q: Quantities) -> Quantities:
    return {name: q[name] - q["accelerometer_bias"] for name in ("du", "specific_x")}
