"""Tables of robot messages: columns named by a field's path, as rostopic, PlotJuggler and pandas write them."""

from __future__ import annotations

import re

import numpy as np
import pandas as pd

FIELDS: tuple[tuple[str, str], ...] = (
    ("a_x_imu", r"linear\.acceleration\.x"), ("a_y_imu", r"linear\.acceleration\.y"),
    ("omega_z", r"angular(\.velocity)?\.z"),
    ("u", r"linear(\.velocity)?\.x"), ("v", r"linear(\.velocity)?\.y"),
    ("x", r"position\.x"), ("y", r"position\.y"),
    ("psi", r"(orientation|rotation)\.heading"),
    ("", r"(angular(\.velocity)?|linear(\.velocity|\.acceleration)?|position)\.[xyz]"),
    ("", r"(orientation|rotation|quaternion|covariance|magnetic\.field|force|torque)\.([xyzw]|\d+)"),
)  # fmt: skip
"""Channel, "" for a field of a standard message that is none, and the end of its path with dots between all words."""
_WORDS = re.compile(r"[./_ \[\]]+")
_QUATERNION = re.compile(r"(orientation|rotation|quaternion)[./_](w)\Z", re.I)


def message_field(path: str) -> str | None:
    """Channel of a standard message's field by its path; "" for a field that is no channel, None for no such path."""
    dotted = _WORDS.sub(".", path.strip().lower()).strip(".")
    return next((channel for channel, end in FIELDS if re.search(rf"(\A|\.){end}\Z", dotted)), None)


def with_headings(frame: pd.DataFrame) -> pd.DataFrame:
    """The table with a column `heading` (rad, to the left) beside each quaternion x, y, z, w; NaN where it is none."""
    found = {}
    for name in map(str, frame.columns):
        base = name[:-1] if _QUATERNION.search(name) else ""
        parts = [f"{base}{part}" for part in "xyzw"]
        if not base or f"{base}heading" in frame.columns or any(part not in frame.columns for part in parts):
            continue
        x, y, z, w = (pd.to_numeric(frame[part], errors="coerce").to_numpy(dtype=float) for part in parts)
        size = x * x + y * y + z * z + w * w
        heading = np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
        found[f"{base}heading"] = np.where((size > 0.5) & (size < 1.5), heading, np.nan)
    return frame.assign(**found) if found else frame
