"""Sensors that report late.

All channels late by one T are what a vehicle measures whose inputs are late by T: the model runs in the sensors' time, on
remembered inputs, and its state is that of T ago. That is exact, as an expansion of the outputs in T is not; what the pose is
later than the velocities is small, and enters the outputs to first order: y - T dy/dt.
"""

from softsoil.symbolic.effect import Correction, Effect, Layout, Signal, Vehicle
from softsoil.symbolic.history import late_by
from softsoil.symbolic.model import Quantities

CELLS = 13
SPACING = 0.035
"""s between remembered inputs, linear in between: 13 cells reach 0.4 s back."""
LATEST = 0.4
CORNERS = ("fl", "fr", "rl", "rr")
SPINS = tuple(f"spin_{corner}" for corner in CORNERS)
POSE = ("x", "y", "psi")
INPUTS = (
    Signal("steer", "rad", "steering angle"),
    Signal("steer_rate", "rad/s", "steering rate"),
    Signal("a_x_imu", "m/s^2", "longitudinal specific force"),
    *(Signal(f"omega_{corner}", "rad/s", f"wheel speed {corner}") for corner in CORNERS),
)


def effect(vehicle: Vehicle) -> Effect:
    """Channels that come late: velocities (u, v, omega_z) by rate_delay, pose (x, y, psi) by pose_delay."""
    return Effect(
        name="sensor_delay",
        doc="sensors that report late",
        kind="sensor",
        reference="transport delay",
        parameters=Layout.of(
            Signal("pose_delay", "s", "delay of position and heading", 0.0, 0.0, LATEST, spread=0.2),
            Signal("rate_delay", "s", "delay of velocities and yaw rate", 0.0, 0.0, LATEST, spread=0.2),
        ),
        typical={"pose_delay": 0.1, "rate_delay": 0.1},
        corrections={
            "inputs": Correction(_inputs, adds=("delta", "delta_rate", "du", "specific_x", *SPINS)),
            "outputs": Correction(_outputs, reads=tuple(f"d_{name}" for name in POSE), adds=tuple(f"y_{name}" for name in POSE)),
        },
        memories=(late_by("rate_delay", "late", INPUTS, _present, _still, CELLS, SPACING),),
        signatures=("late or displaced sensor", "late steering"),
        separates="changes of speed: a late steering leaves the speed alone; any turning, for a pose later than the yaw rate",
        rests_on=("x", "y", "psi", "u", "omega_z", "steer"),
        answers_to={"late_sensors": ("pose_delay", "rate_delay")},
    )


def _present(q: Quantities) -> Quantities:
    """The inputs as sensors on the vehicle give them: the accelerometer is not late, the v omega_z added to it is."""
    return {s.name: q["a_x"] - q["v"] * q["omega_z"] if s.name == "a_x_imu" else q[s.name] for s in INPUTS}


def _still(q: Quantities) -> Quantities:
    return _present(q) | {"steer_rate": 0.0}


def _inputs(q: Quantities) -> Quantities:
    return {
        "delta": q["delta"] + q["late_steer"],
        "delta_rate": q["delta_rate"] + q["late_steer_rate"],
        "du": q["du"] + q["late_a_x_imu"],
        "specific_x": q["specific_x"] + q["late_a_x_imu"],
        **{f"spin_{corner}": q[f"spin_{corner}"] + q[f"late_omega_{corner}"] for corner in CORNERS},
    }


def _outputs(q: Quantities) -> Quantities:
    later = q["pose_delay"] - q["rate_delay"]
    return {f"y_{name}": q[f"y_{name}"] - later * q[f"d_{name}"] for name in POSE}
