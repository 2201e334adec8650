"""Tables of robot messages: columns named by a field's path, as rostopic, PlotJuggler and pandas write them."""

from __future__ import annotations

import re

import pandas as pd

from softsoil.importing.messages import heading_of

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
        found[f"{base}heading"] = heading_of(*(pd.to_numeric(frame[part], errors="coerce") for part in parts))
    return frame.assign(**found) if found else frame
