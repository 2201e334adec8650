"""Numbers out of robot messages: fields by path, headings of quaternions, joints by name, header stamps."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

QUATERNION = ("heading", "pitch", "roll")
"""What stands in a quaternion's place: angles of the body against the frame (rad), z up, heading to the left."""
SPEED = "speed"
"""Name of the horizontal length of a velocity `linear`, for those that are given to the east and north."""
MOST_ELEMENTS = 64
"""Elements of an array that are looked at; longer ones are images and clouds."""
_PART = re.compile(r"([A-Za-z_]\w*)((?:\[[^\]]*\])*)\Z")


def heading_of(x: ArrayLike, y: ArrayLike, z: ArrayLike, w: ArrayLike) -> NDArray[np.float64]:
    """(N,) heading (rad) of quaternions x, y, z, w (N,), or of one; NaN where it is none."""
    x, y, z, w = (np.asarray(part, dtype=float) for part in (x, y, z, w))
    size = x * x + y * y + z * z + w * w
    return np.where((size > 0.5) & (size < 1.5), np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)), np.nan)


def angle_of(q: Any, name: str) -> float:
    """heading, pitch or roll (rad; `name`) of a quaternion q with x, y, z, w; NaN where it is none."""
    x, y, z, w = float(q.x), float(q.y), float(q.z), float(q.w)
    if not 0.5 < x * x + y * y + z * z + w * w < 1.5:
        return math.nan
    if name == "heading":
        return float(heading_of(x, y, z, w))
    if name == "pitch":
        return math.asin(max(-1.0, min(1.0, 2 * (w * y - z * x))))
    return math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))


def speed_of(vector: Any) -> float:
    """Horizontal speed (m/s) of a velocity vector with x and y in any frame; NaN where it is none."""
    x, y = getattr(vector, "x", None), getattr(vector, "y", None)
    return math.hypot(x, y) if isinstance(x, int | float) and isinstance(y, int | float) else math.nan


def is_quaternion(value: Any) -> bool:
    """Whether a message part is a quaternion."""
    return type(value).__name__.endswith("Quaternion")


def fields_of(message: Any, prefix: str = "") -> Iterator[tuple[str, float]]:
    """Every number of a message with its path, quaternions as angles, joints by name; long arrays are left out."""
    if is_quaternion(message):
        for name in QUATERNION:
            yield f"{prefix}{name}", angle_of(message, name)
        return
    names = [str(n) for n in message.name] if _named(message) else None
    for key, value in vars(message).items():
        if key.startswith("__") or key.isupper() or key in ("header", "covariance"):
            continue
        path = f"{prefix}{key}"
        if isinstance(value, bool | int | float | np.number):
            yield path, float(value)
        elif isinstance(value, np.ndarray | list):
            if len(value) <= MOST_ELEMENTS and not path.endswith("covariance"):
                for i, element in enumerate(value):
                    label = names[i] if names is not None and len(names) == len(value) else str(i)
                    if isinstance(element, bool | int | float | np.number):
                        yield f"{path}[{label}]", float(element)
                    elif hasattr(element, "__dict__") and not isinstance(element, str):
                        yield from fields_of(element, f"{path}[{label}].")
        elif hasattr(value, "__dict__"):
            yield from fields_of(value, f"{path}.")
            if key == "linear":
                yield f"{path}.{SPEED}", speed_of(value)


def _named(message: Any) -> bool:
    names = getattr(message, "name", None)
    return isinstance(names, list) and bool(names) and all(isinstance(n, str) for n in names)


def reader_of(path: str) -> Callable[[Any], float]:
    """A function message -> number for a field's path, as `fields_of` writes it; NaN where a message lacks it.

    Raises ValueError for a path that is none.
    """
    steps: list[tuple[str, tuple[str, ...]]] = []
    for part in re.split(r"\.(?![^\[]*\])", path):
        found = _PART.match(part)
        if not found:
            raise ValueError(
                f"field: expected a path such as twist.twist.linear.x or velocity[front_left], found {path!r}"
            )
        steps.append((found.group(1), tuple(re.findall(r"\[([^\]]*)\]", found.group(2)))))

    def read(message: Any) -> float:
        value = message
        for name, indices in steps:
            if is_quaternion(value) and name in QUATERNION:
                return angle_of(value, name)
            if name == SPEED and not hasattr(value, SPEED):
                return speed_of(value)
            owner, value = value, getattr(value, name, None)
            for index in indices:
                at = _position(owner, index)
                if value is None or at is None or at >= len(value):
                    return math.nan
                value = value[at]
            if value is None:
                return math.nan
        return float(value) if isinstance(value, bool | int | float | np.number) else math.nan

    return read


def _position(owner: Any, index: str) -> int | None:
    names = getattr(owner, "name", None)
    if isinstance(names, list) and index in names:
        return names.index(index)
    return int(index) if index.isdigit() else None


def stamp_of(message: Any) -> float:
    """Header stamp (s) of a message; NaN where it has none or it was left at zero."""
    stamp = getattr(getattr(message, "header", None), "stamp", None)
    if stamp is None:
        stamp = getattr(message, "stamp", None)
    seconds, rest = getattr(stamp, "sec", None), getattr(stamp, "nanosec", 0)
    if seconds is None or (seconds == 0 and rest == 0):
        return math.nan
    return float(seconds) + 1e-9 * float(rest)


def values_of(message: Any, readers: Mapping[str, Callable[[Any], float]]) -> list[float]:
    """The wanted numbers of one message, in the order of readers."""
    return [read(message) for read in readers.values()]
