"""The driver as C: the texts of its files."""

from __future__ import annotations

import hashlib

from softsoil.codegen.c_library.kernels import number
from softsoil.codegen.c_library.library import fill, template
from softsoil.control import live_steering as steering
from softsoil.control import motion_watch
from softsoil.control.driver_checks import FARTHEST, LARGEST, LATEST
from softsoil.control.driver_types import CONTESTED, CONTESTED_SIGMAS, MEASUREMENTS, STANDING_SHARE, DriverSettings
from softsoil.control.inbox import TOGETHER
from softsoil.control.live_estimator import FIRST_SPREAD, SEEN
from softsoil.control.nmpc_clearance import ABSENT
from softsoil.control.nmpc_settings import SETTINGS
from softsoil.control.ocp import Ocp
from softsoil.estimator.tuning import N_NAMES, Tuning
from softsoil.recording.drive import STATE_CHANNELS, UNSEEN
from softsoil.symbolic.model import Model
from softsoil.symbolic.soil import SOIL_SIGNALS

TEMPLATES = {
    "include/softsoil_driver.h": "softsoil_driver.h.in",
    "src/softsoil_driver.c": "softsoil_driver.c.in",
    "src/softsoil_driver_watch.h": "softsoil_driver_watch.h.in",
}


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
    """Values of the @key@ of the driver's templates: the numbers of the settings; those of the filter are its own."""
    tuning, limits = Tuning(), SOIL_SIGNALS["n"]
    names = (
        "tick", "slip_share", "speed_gain", "overspeed", "resistance_share", "most_resistance", "caution", "settled",
        "most", "standing", "stands", "dead_reckoning", "most_position_std", "steering_gap", "actuator_lag", "end",
    )  # fmt: skip
    numbers = ("JUMP", "LEAD", "MEMORY", "MOVES", "QUICK", "SLOWEST", "SMOOTH", "STILL", "WHILE")
    of_steering = {f"steer_{name.lower()}": number(getattr(steering, name), 17) for name in numbers}
    watched = (
        "HELD", "PAUSE", "SHORTEST", "STALE", "LONGEST", "LEAST_WAY", "WAY_STDS", "MOST_STD", "FROZEN", "LEAST_TURN", "TURN_STDS",
        "MOST_TURN_STD", "MOVING", "OFFSET", "SHARE", "NEW",
    )  # fmt: skip
    of_watch = {f"watch_{name.lower()}": number(getattr(motion_watch, name), 17) for name in watched}
    lengths = {name: number(getattr(ocp.vehicle, name), 17) for name in ("l_f", "l_r")}
    of_settings = {f"driver_{name}": number(getattr(settings, name), 17) for name in names}
    return of_steering | of_watch | of_settings | lengths | {
        "watch_count": str(motion_watch.COUNT), "watch_sizes": _list(motion_watch.CHANNELS.values()),
        "contested": number(CONTESTED, 17), "contested_sigmas": number(CONTESTED_SIGMAS, 17),
        "driver_measurements": ", ".join(f"SOFTSOIL_DRIVER_{name}" for name in MEASUREMENTS),
        "driver_states": ", ".join(f"SOFTSOIL_X_{name}" for name in ocp.model.x.names),
        "soil_indices": ", ".join(f"SOFTSOIL_X_{name}" for name in model.x.names if name in N_NAMES),
        "first_spread": _list(FIRST_SPREAD), "unseen": _list(UNSEEN),
        "n_lower": number(limits.lower, 17), "n_upper": number(limits.upper, 17), "most_lag": number(steering.MOST_LAG),
        "together": number(TOGETHER),
        "steer_limit": number(steering.STEER_LIMIT, 17), "max_steer_rate": number(ocp.vehicle.max_steer_rate, 17),
        "driver_r_std": _list(settings.sensor_std), "driver_n_std": number(tuning.n_std, 17),
        "driver_plan_every": str(settings.plan_every), "driver_update_every": str(tuning.update_every),
        "driver_seen": ", ".join(f"SOFTSOIL_Y_{name}" for name in SEEN), "clear_steps": str(SETTINGS.clear_steps),
        "farthest": number(FARTHEST), "largest": number(LARGEST), "latest": number(LATEST),
        "standing_share": number(STANDING_SHARE), "least_room": number(SETTINGS.least_room, 17),
        "least_speed": f"{ocp.settings.speed[0]:g}", "greatest_speed": f"{ocp.settings.speed[1]:g}",
        "extra_std": number(tuning.extra_std, 17), "radius": number(ocp.vehicle.radius, 17),
        "radius_rear": number(ocp.vehicle.rear_radius, 17), "absent": _list(ABSENT),
    }  # fmt: skip


def _list(values) -> str:
    return ", ".join(number(float(value), 17) for value in values)
