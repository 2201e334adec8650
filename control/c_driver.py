"""The driver as C: the texts of its files."""

from __future__ import annotations

import hashlib

import numpy as np

from softsoil.codegen.c_library.kernels import number
from softsoil.codegen.c_library.library import fill, template
from softsoil.control.driver import END, STEER_LIMIT, UNSEEN
from softsoil.control.driver_types import DriverSettings
from softsoil.control.live_estimator import FIRST_SPREAD, LOOP_TUNING
from softsoil.control.nmpc_clearance import NOWHERE
from softsoil.control.ocp import Ocp
from softsoil.recording.drive import STATE_CHANNELS, WHEEL_CHANNELS
from softsoil.symbolic.model import Model
from softsoil.symbolic.soil import SOIL_SIGNALS

MEASUREMENTS = (*STATE_CHANNELS, *WHEEL_CHANNELS, "a_x_imu", "steer")
"""What a tick takes, in the order of enum softsoil_driver_measurement."""
TEMPLATES = {"include/softsoil_driver.h": "softsoil_driver.h.in", "src/softsoil_driver.c": "softsoil_driver.c.in"}
N_NAMES = ("n", "n_f", "n_r")
EXTRA_STD, EXTRA_WALK = 1e-2, 1e-4
"""Of states that an effect brings: standard deviation of the first value, and of the change per root of a second."""


def driver_files(
    ocp: Ocp, model: Model, values: dict[str, str], settings: DriverSettings | None = None
) -> dict[str, str]:  # fmt: skip
    """Path inside the folder -> text of the driver's files.

    ocp: the controller's problem; model: the filter's, whose states are those of the controller's model and n; values:
    of `controller_values`; settings: the driver's declared numbers. Raises ValueError for a model that measures
    anything but the six states of a vehicle.
    """
    if model.y.names != STATE_CHANNELS:
        raise ValueError(f"driver: expected the measurements {', '.join(STATE_CHANNELS)}, found {', '.join(model.y.names)}")
    mine = values | driver_values(ocp, model, settings or DriverSettings())
    texts = {path: template(name) for path, name in TEMPLATES.items()}
    known = hashlib.sha256(repr(sorted(mine.items())).encode()).hexdigest()
    return {path: fill(text, mine | {"driver_magic": known[:8]}) for path, text in texts.items()}


def driver_values(ocp: Ocp, model: Model, settings: DriverSettings) -> dict[str, str]:
    """Values of the @key@ of the driver's templates: the numbers of the settings and of the loop's filter."""
    tuning, limits = LOOP_TUNING, SOIL_SIGNALS["n"]
    extra = model.x.names[len(STATE_CHANNELS) :]
    q_std = (*tuning.model_error, *(tuning.n_walk if name in N_NAMES else EXTRA_WALK for name in extra))
    names = (
        "tick", "slip_share", "speed_gain", "resistance_share", "most_resistance", "caution", "settled", "most", "standing",
        "stands",
    )  # fmt: skip
    return {f"driver_{name}": number(getattr(settings, name), 17) for name in names} | {
        "driver_measurements": ", ".join(f"SOFTSOIL_DRIVER_{name}" for name in MEASUREMENTS),
        "driver_states": ", ".join(f"SOFTSOIL_X_{name}" for name in ocp.model.x.names),
        "soil_indices": ", ".join(f"SOFTSOIL_X_{name}" for name in model.x.names if name in N_NAMES),
        "first_spread": _list(FIRST_SPREAD), "unseen": _list(UNSEEN), "driver_end": number(END, 17),
        "n_lower": number(limits.lower, 17), "n_upper": number(limits.upper, 17), "steer_limit": number(STEER_LIMIT, 17),
        "driver_q_std": _list(q_std), "driver_r_std": _list(settings.sensor_std), "driver_n_std": number(tuning.n_std, 17),
        "driver_filter_options": f"  settings->filter.gate = {number(tuning.gate, 17)};\n"
        f"  settings->filter.gate_patience = {tuning.patience};",
        "driver_plan_every": str(settings.plan_every), "driver_update_every": str(tuning.update_every),
        "extra_std": number(EXTRA_STD, 17), "radius": number(ocp.vehicle.radius, 17), "nowhere": number(NOWHERE, 17),
    }  # fmt: skip


def _list(values) -> str:
    return ", ".join(number(float(value), 17) for value in np.asarray(values))
