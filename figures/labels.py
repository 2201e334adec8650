"""Words and units for people: quantities, force laws and effects as figures and reports name them.

Angles are in degrees wherever a person looks; files, Python and C keep radians.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

DEGREE = 180.0 / math.pi


@dataclass(frozen=True)
class Quantity:
    """How a quantity is shown: words, unit, and factor from SI to that unit."""

    words: str
    unit: str
    factor: float = 1.0

    @property
    def label(self) -> str:
        """Words and unit for an axis."""
        return f"{self.words}, {self.unit}" if self.unit else self.words


QUANTITIES: Mapping[str, Quantity] = MappingProxyType(
    {
        "t": Quantity("time", "s"),
        "time": Quantity("time", "s"),
        "x": Quantity("x", "m"),
        "y": Quantity("y", "m"),
        "psi": Quantity("heading", "deg", DEGREE),
        "u": Quantity("speed", "m/s"),
        "v": Quantity("lateral velocity", "m/s"),
        "omega_z": Quantity("yaw rate", "deg/s", DEGREE),
        "a_x": Quantity("longitudinal acceleration", "m/s²"),
        "a_y": Quantity("lateral acceleration", "m/s²"),
        "a_x_imu": Quantity("longitudinal accelerometer", "m/s²"),
        "a_y_imu": Quantity("lateral accelerometer", "m/s²"),
        "steer": Quantity("steering angle", "deg", DEGREE),
        "steer_rate": Quantity("steering rate", "deg/s", DEGREE),
        "side_slip": Quantity("side slip angle", "deg", DEGREE),
        "cos_heading": Quantity("cosine of the heading", ""),
        "sin_heading": Quantity("sine of the heading", ""),
        "omega_fl": Quantity("wheel speed, front left", "rad/s"),
        "omega_fr": Quantity("wheel speed, front right", "rad/s"),
        "omega_rl": Quantity("wheel speed, rear left", "rad/s"),
        "omega_rr": Quantity("wheel speed, rear right", "rad/s"),
    }
)
SYMBOLS: Mapping[str, str] = MappingProxyType(
    {"x": "x", "y": "y", "psi": "ψ", "u": "u", "v": "v", "omega_z": "ω"}
)
"""States where there is no room for words."""
LAWS: Mapping[str, str] = MappingProxyType(
    {
        "bekker": "Bekker", "dallas": "Dallas", "dallas_refit": "Dallas, refitted", "hard_ground": "hard ground",
        "turn_slip": "turn slip", "turn_slip_calibrated": "turn slip, calibrated",
    }
)  # fmt: skip


NAMES: Mapping[str, str] = MappingProxyType(
    {
        "l_f": "centre of gravity to front axle", "l_r": "centre of gravity to rear axle",
        "h_cg": "height of centre of gravity", "sandyloam": "sandy loam",
    }
)  # fmt: skip
"""Identifiers that are no words."""
AXLES: Mapping[str, str] = MappingProxyType({"_f": " front", "_r": " rear"})


def plain(name: str) -> str:
    """An identifier as words: toe_rear_load -> toe rear load, aligning_f -> aligning front."""
    if name in NAMES:
        return NAMES[name]
    return re.sub(r"_[fr]\b", lambda end: AXLES[end[0]], name).replace("_", " ")


def per_cent(share: float, digits: int = 0, sign: str = "") -> str:
    """A share (of 1) in per cent, never "-0"; digits: behind the point; sign: "+" writes it in any case."""
    return f"{round(100.0 * share, digits) + 0.0:{sign}.{digits}f} %"


def quantity(name: str) -> Quantity:
    """How the channel or signal `name` is shown; an unknown one by its name, as it is."""
    return QUANTITIES.get(name, Quantity(plain(name), ""))


def rms(name: str, mean_square: float) -> float:
    """Root of the mean squared error `mean_square` (SI, squared) of the channel `name`, in the unit that `quantity` shows."""
    return quantity(name).factor * math.sqrt(mean_square)


def law_words(name: str) -> str:
    """A force law's name for people."""
    return LAWS.get(name, plain(name))
