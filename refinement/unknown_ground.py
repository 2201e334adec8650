"""What is unknown of the ground under drives: on soil n of each; on hard ground friction and tread of each class."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from softsoil.estimator.hard_ground import ROAD
from softsoil.symbolic.soil import SOIL_SIGNALS, Soil
from softsoil.windows.parameters import Free

Array = NDArray[np.float64]

N_NAMES, N_SCALE = ("n_f", "n_r"), 0.1
N_SHIFTS = (-0.25, -0.12, 0.0, 0.12, 0.25)
FRICTIONS, TREADS = (0.35, 0.6, 0.9), (0.2, 0.5, 1.0, 2.5)
"""Where a fit of the ground starts: n around what is known; friction angles (rad) beside it, with multiples of the tread."""


def free_n(drives: int) -> tuple[Free, ...]:
    """The sinkage exponent of each of so many drives, one for both axles."""
    n = SOIL_SIGNALS["n"]
    return tuple(Free(f"n_{i}", N_NAMES, N_SCALE, n.lower, n.upper, drive=i) for i in range(drives))


def free_road(soils: Sequence[Soil]) -> tuple[Free, ...]:
    """Friction angle and shear length of the tread for each class of hard ground; soils: the class of each drive."""
    found = []
    for soil in dict.fromkeys(soils):
        drives = tuple(i for i, other in enumerate(soils) if other == soil)
        mark, drive = ("", None) if len(drives) == len(soils) else (f"_{drives[0]}", drives)
        found += [Free(f"{f.name}{mark}", f.sets, f.scale, f.lower, f.upper, drive=drive) for f in ROAD]
    return tuple(found)


def ground_starts(free: Sequence[Free], values: Array) -> Array:
    """(S, K) values of the ground's free numbers from which a fit takes the best; values (K,): what is known of them."""
    if free[0].sets == N_NAMES:
        return np.clip(values + np.array(N_SHIFTS)[:, None], 0.25, 1.5)
    angle = np.array([f.sets == ROAD[0].sets for f in free])
    return np.array([values, *(np.where(angle, phi, values * times) for phi in FRICTIONS for times in TREADS)])
