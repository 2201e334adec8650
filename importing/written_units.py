"""Units of fields as files write them: in a heading, or at the end of a name."""

from __future__ import annotations

import re

from softsoil.importing.sources import Spread
from softsoil.recording.columns import UNITS

WRITTEN_UNITS = {"m/s": "m/s", "km/h": "km/h", "kmh": "km/h", "kph": "km/h", "mph": "mph", "deg": "deg", "°": "deg", "rad": "rad",
                 "deg/s": "deg/s", "°/s": "deg/s", "rad/s": "rad/s", "rpm": "rpm", "1/min": "rpm", "g": "g", "m/s^2": "m/s^2",
                 "m/s²": "m/s^2", "m/s2": "m/s^2", "m": "m", "cm": "cm", "mm": "mm", "km": "km", "%": "%"}  # fmt: skip

ENDINGS = {"_kmh": "km/h", "_kph": "km/h", "_mph": "mph", "_mps": "m/s", "_rpm": "rpm", "_dps": "deg/s", "_deg_s": "deg/s",
           "_degs": "deg/s", "_deg": "deg", "_rad": "rad", "_rads": "rad/s", "_m": "m", "_cm": "cm", "_mm": "mm",
           "_mps2": "m/s^2", "_ms2": "m/s^2", "_g": "g"}  # fmt: skip
"""End of a field's name -> unit."""
RPM = re.compile(r"(?<![a-z])rpm(?![a-z])", re.I)
"""In the name of a wheel's field, wherever it stands: rpm_fl, wheel_rpm_rear_left."""


def without_unit(name: str) -> str:
    """The name, in lower case, without a unit at its end; "" where it has none there."""
    return next((name.removesuffix(end) for end in sorted(ENDINGS, key=len, reverse=True) if name.endswith(end)), "")


def written_unit(path: str, spread: Spread) -> str:
    """Unit, as `recording.columns` calls it, that the file says of a field, or that the end of its name, `path`, says; "" for
    none."""
    ending = next((unit for end, unit in ENDINGS.items() if path.lower().endswith(end)), "rpm" if RPM.search(path) else "")
    return WRITTEN_UNITS.get(spread.unit.strip(), ending)


def measures(unit: str, si: str) -> bool:
    """Whether a field in `unit` ("" for unknown) can be one whose SI unit is `si`."""
    return not unit or UNITS[unit][0] == si
