"""The driver as an FMI 3.0 co-simulation unit: its C source and its description."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping

from softsoil.codegen.c_library.fmi import description, variables_of
from softsoil.codegen.c_library.kernels import number
from softsoil.codegen.c_library.library import fill, template
from softsoil.codegen.c_library.pack_fmu import DRIVER_IDENTIFIER
from softsoil.control.driver_types import MEASUREMENTS
from softsoil.symbolic.signals import Layout, Signal
from softsoil.symbolic.soil import SOIL_SIGNALS

POINTS, OBSTACLES, SPEED = 1024, 16, 5.0
"""Greatest number of points of a path and of obstacles in a unit, and the speed where none is set (m/s)."""
FIRST_INPUT, FIRST_OUTPUT, FIRST_PARAMETER = 1, 100, 1000
"""Value references, as in fmu_driver.c."""
_UNITS = {"psi": "rad", "u": "m/s", "v": "m/s", "a_x_imu": "m/s^2", "steer": "rad", "x": "m", "y": "m"}
OUTPUTS = Layout.of(
    Signal("steer_asked", "rad", "steering angle at the end of the tick"),
    Signal("steer_rate", "rad/s", "its rate until then"),
    Signal("speed_asked", "m/s", "speed of the plan"),
    Signal("a_x", "m/s^2", "acceleration of the plan"),
    Signal("a_asked", "m/s^2", "acceleration with what speed error and resistance add"),
    Signal("n", "", "estimate of the sinkage exponent"),
    Signal("n_std", "", "its standard deviation, NaN before the first step"),
    Signal("n_used", "", "exponent that the controller drives on"),
    Signal("slip", "", "of the wheels"),
    Signal("resistance", "m/s^2", "deceleration that plans do not know"),
    Signal("along", "m", "along the path"),
    Signal("left", "m", "left of the path"),
    Signal("status", "", "of the last plan, enum softsoil_nmpc_status"),
    Signal("lost", "", "1: no plan, this is the safe command"),
    Signal("halt", "", "1: braking to a stand before what cannot be passed, or as status says"),
    Signal("finished", "", "1: the end of the path"),
    Signal("stopped", "", "1: came to a stand"),
    Signal("solved", "", "1: this tick has a new plan"),
    Signal("filter_status", "", "the gravest of the tick, enum softsoil_status"),
    Signal("position_std", "m", "root of the sum of the variances of x and y, NaN before the first state"),
    Signal("dead_reckoned", "s", "time since x, y, u or v was last measured, NaN before the first state"),
    Signal("actuator_lag", "s", "of the measured steering angle behind its command"),
    Signal("disagreement", "", "sum of what contradicts itself: 1 x, y with u, psi; 2 psi with omega_z; 4 steering with omega_z"),
)
_FIELDS = {"steer_asked": "steer", "speed_asked": "speed"}


def driver_fmi_files(n0: float, values: Mapping[str, str], tick: float) -> dict[str, str]:
    """fmi/fmu_driver.c and fmi/driverDescription.xml, beside those of the model.

    n0: initial guess of n where none is set; values: of `controller_values`; tick: of the driver (s).
    """
    known = hashlib.sha256(repr(sorted(values.items())).encode()).hexdigest()[:8]
    token, step = f"{{softsoil-driver-{known}}}", number(tick)
    measured = Layout.of(*[Signal(name, _UNITS.get(name, "rad/s"), "measured, NaN where absent") for name in MEASUREMENTS])
    variables = variables_of(measured, FIRST_INPUT, 'causality="input" variability="discrete"', lambda s: "NaN")
    kind = 'causality="output" variability="discrete" initial="calculated"'
    variables += variables_of(OUTPUTS, FIRST_OUTPUT, kind, lambda s: "")
    variables += _parameters(n0)
    about = f"driver on {values['model']}{values['effects']}, softsoil {values['version']}"
    outputs = range(FIRST_OUTPUT, FIRST_OUTPUT + len(OUTPUTS))
    text = description(
        DRIVER_IDENTIFIER, "softsoil driver", token, about, step, variables, outputs, (*measured, *OUTPUTS), False, True
    )
    filled = {
        "fmu_points": str(POINTS), "fmu_obstacles": str(OBSTACLES), "fmu_outputs": str(len(OUTPUTS)),
        "token": token, "fmu_speed": number(SPEED), "fmu_n0": number(n0),
        "fmu_values": ", ".join(f"(double)c->{_FIELDS.get(name, name)}" for name in OUTPUTS.names),
    }  # fmt: skip
    source = fill(template("fmu_driver.c.in"), filled)
    return {"fmi/fmu_driver.c": source, "fmi/driverDescription.xml": text}


def _parameters(n0: float) -> list[str]:
    """Lines of what a drive is given; a path of `path_points` points, straight on where none is set."""
    limits = SOIL_SIGNALS["n"]
    rows: list[tuple[str, str, int, str, str]] = [
        ("speed", "m/s", 1, number(SPEED), "wanted speed"),
        ("n0", "", 1, number(n0), f"initial guess of n, {limits.lower:g} to {limits.upper:g}"),
        ("learn", "", 1, "1.0", "1: n is estimated, 0: it stays n0"),
        ("path_points", "", 1, number(POINTS), "points of the path that count"),
        ("path_x", "m", POINTS, " ".join(number(float(k)) for k in range(POINTS)), "points of the path"),
        ("path_y", "m", POINTS, " ".join(["0.0"] * POINTS), "points of the path"),
        ("obstacle_count", "", 1, "0.0", "obstacles that count"),
        ("obstacles", "", 5 * OBSTACLES, " ".join(["0.0"] * 5 * OBSTACLES), "x, y, radius (m), velocity (m/s) of each"),
    ]
    lines = []
    for i, (name, unit, size, start, doc) in enumerate(rows):
        declared = f" unit=\"{unit}\"" if unit else ""
        head = f'    <Float64 name="{name}" valueReference="{FIRST_PARAMETER + i}" causality="parameter" variability="tunable"'
        tail = f'{declared} start="{start}" description="{doc}"'
        lines.append(f"{head}{tail}/>" if size == 1 else f'{head}{tail}><Dimension start="{size}"/></Float64>')
    return lines
