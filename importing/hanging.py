"""Sensors that hang upside down, by the gravity that their accelerometers read."""

from __future__ import annotations

import re

from softsoil.importing.sources import Holding, Spread
from softsoil.importing.written_units import without_unit, written_unit

UPWARD = re.compile(r"(\A|[./_])(linear_acceleration[./_]z|a(cc\w*)?_?z)(_imu)?\Z", re.I)
"""Field of an accelerometer along its own third axis, without its unit."""
HANGING = (-13.0, -6.0)
"""m/s^2: what an accelerometer reads along an axis that points down; along one that points up it is the opposite."""
IN_G = (0.6, 1.4)
"""Size of what a field without a unit reads that is in g."""
G = 9.81


def hangs(holding: Holding) -> bool:
    """Whether a sensor's third axis points down."""
    read = (_gravity(path, s) for path, s in holding.fields.items() if UPWARD.search(without_unit(path.lower()) or path))
    return any(HANGING[0] < value < HANGING[1] for value in read)


def _gravity(path: str, spread: Spread) -> float:
    """What the field reads typically, m/s^2; 0 where it has another unit."""
    unit = written_unit(path, spread)
    in_g = unit == "g" or (not unit and IN_G[0] < abs(spread.middle) < IN_G[1])
    return spread.middle * (G if in_g else 1.0) if unit in ("", "g", "m/s^2") else 0.0
