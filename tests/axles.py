"""Which way the plant's wheels point, from its suspension's hardpoints."""

import numpy as np

from softsoil.plant.machine import load_plant_vehicle
from softsoil.plant.suspension import AXLE_X, AXLE_Z, COUNT, carrier


def axle_of(wheel: int, travel: float, pitman: float) -> np.ndarray:
    """Unit vector along a wheel's axle, leftward, in the chassis frame; wheels fl, fr, rl, rr by number."""
    value, by_travel, by_angle = np.empty(COUNT), np.empty(COUNT), np.empty(COUNT)
    carrier(load_plant_vehicle().machine.paths[wheel], travel, pitman, value, by_travel, by_angle)
    across = np.sqrt(1.0 - value[AXLE_X] ** 2 - value[AXLE_Z] ** 2)
    return np.array([value[AXLE_X], across, value[AXLE_Z]])
