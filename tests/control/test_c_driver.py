"""The generated driver: the same commands as Python's on the same measurements, and what it promises."""

import ctypes
from functools import lru_cache

import numpy as np
import pytest

from drives import reference_vehicle
from softsoil.control.c_folder import controller_texts
from softsoil.control.courses import double_lane_change
from softsoil.control.driver import Driver
from softsoil.control.driver_binding import CDriver
from softsoil.control.driver_types import DriverSettings
from softsoil.control.live_estimator import LiveEstimator
from softsoil.control.nmpc import Nmpc
from softsoil.control.ocp import Ocp
from softsoil.declaration.model_file import Declaration
from softsoil.symbolic.soil import CLAY

pytestmark = pytest.mark.compiler
SENSORS = DriverSettings(sensor_std=(0.05, 0.05, 0.003, 0.05, 0.05, 0.005))
DECLARED = Declaration(reference_vehicle(), CLAY, "hard_ground")
OBSTACLES = np.array([[62.0, 1.6, 1.0, 0.0, 0.0], [92.0, 2.4, 1.0, -0.1, 0.0]])


@lru_cache(maxsize=1)
def in_c() -> CDriver:
    return CDriver(controller_texts(DECLARED, driver=SENSORS), len(problem().z))


@lru_cache(maxsize=1)
def problem() -> Ocp:
    return Ocp(DECLARED.build(), DECLARED.vehicle)


class Stranger:
    """The vehicle of examples/bring_your_own_vehicle.py in this process: its generator of measurements, driven by commands."""
