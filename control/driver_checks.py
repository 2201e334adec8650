"""What a driver is asked to drive and what it is given, checked by the same rules as in the generated C."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from numbers import Real

import numpy as np
from numpy.typing import ArrayLike, NDArray

from softsoil.control.path import Path
from softsoil.symbolic.soil import SOIL_SIGNALS

Array = NDArray[np.float64]
FARTHEST, LARGEST, LATEST = 1e9, 1e6, 1e12
"""Bounds of a number of an obstacle (m, m/s), of a first state (SI units) and of a time (s)."""


def checked_path(path: Path) -> Path:
    """The path; TypeError for what is none, as an array of points."""
    if not isinstance(path, Path):
        raise TypeError(f"path: expected a Path, as softsoil.control.path.Path(points); found {type(path).__name__}")
    return path


def check_speed(speed: float, limits: tuple[float, float]) -> None:
    """Raises TypeError for a speed that is no number, ValueError for one (m/s) outside the limits (least, greatest) of u that the
    controller keeps."""
    least, greatest = limits
    if not isinstance(speed, Real) and not (isinstance(speed, np.ndarray) and speed.ndim == 0):
        raise TypeError(f"speed: expected a number of m/s, found {speed!r}")
    if not least <= speed <= greatest:
        raise ValueError(
            f"speed: expected {least:g} to {greatest:g} m/s, the controller's limits of u (OcpSettings.speed), found {speed}; "
            "no speed stops a vehicle: to stop, end the drive and brake"
        )


def checked_obstacles(obstacles: ArrayLike) -> Array:
    """The obstacles (K, 5): x, y, radius (m), velocity (m/s); ValueError for another shape, a number not finite, a radius < 0."""
    given = np.asarray(obstacles, dtype=float) if np.size(obstacles) else np.zeros((0, 5))
    if given.ndim != 2 or given.shape[1] != 5:
        raise ValueError(f"obstacles: expected (K, 5): x, y, radius, velocity; found shape {given.shape}")
    for i, row in enumerate(given):
        if not (np.abs(row) < FARTHEST).all():
            raise ValueError(f"obstacles: expected finite numbers, below {FARTHEST:g}, found {row.tolist()} in row {i}")
        if row[2] < 0:
            raise ValueError(f"obstacles: expected a radius >= 0 m, found {row[2]} in row {i}")
    return given


def checked_n0(n0: float) -> float:
    """The first guess n0; ValueError out of the bounds of n."""
    bounds = SOIL_SIGNALS["n"]
    if not bounds.lower <= n0 <= bounds.upper:
        raise ValueError(f"n0: expected a first guess in [{bounds.lower}, {bounds.upper}], found {n0}")
    return float(n0)


def checked_start(start: ArrayLike | None) -> Array | None:
    """(6,) first state x, y, psi, u, v, omega_z (SI units), None where it is not known; ValueError for another shape or a number
    that is not finite."""
    if start is None:
        return None
    given = np.asarray(start, dtype=float)
    if given.shape != (6,) or not (np.abs(given) < LARGEST).all():
        raise ValueError(f"start: expected six finite numbers x, y, psi, u, v, omega_z, found {given.tolist()}")
    return given


def check_time(t: float, last: float, pause: float) -> bool:
    """Whether the clock was set back, by more than a `pause` (s), from the last tick's, `last` (s), to t (s): one stamp that was
    far ahead must not stop a vehicle for good. Raises ValueError for a t that is not finite, or less far before the last."""
    if not abs(t) < LATEST:
        raise ValueError(f"t: expected a finite time of the tick, below {LATEST:g} s, found {t}")
    back = last - t
    if 0.0 < back <= pause:
        raise ValueError(
            f"t: expected a time that is not before the last tick's, {last} s, or of a clock set back by more than {pause:g} s; "
            f"found {t} s"
        )
    return back > pause


def check_names(measured: Iterable[str], known: Collection[str]) -> None:
    """Raises ValueError for a name of a measurement that is not among those known."""
    unknown = [name for name in measured if name not in known]
    if unknown:
        raise ValueError(f"measured: expected names of {', '.join(known)}; found {', '.join(map(repr, unknown))}")
