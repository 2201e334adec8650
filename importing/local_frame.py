"""Latitude and longitude to a local frame and back: metres east and north of the first fix (WGS 84)."""

from __future__ import annotations

from types import ModuleType

import numpy as np

from softsoil.recording.drive import Array

LARGEST_LATITUDE, LARGEST_LONGITUDE = 90.0, 360.0


def _pymap3d(where: str) -> ModuleType:
    try:
        import pymap3d
    except ImportError:
        raise ValueError(
            f"{where}: expected the library pymap3d for fixes, found none: pip install '.[logs]' in the project's folder"
        ) from None
    return pymap3d


def latitude_longitude(where: str, east: Array, north: Array, origin: tuple[float, float]) -> tuple[Array, Array]:
    """latitude, longitude (deg) of points at east, north (m, any shape) of the origin (latitude, longitude in deg).

    where: for messages. Raises ValueError where the library is missing.
    """
    latitude, longitude, _ = _pymap3d(where).enu2geodetic(east, north, np.zeros_like(east), *origin, 0.0)
    return latitude, longitude


def other_frame(
    where: str, east: Array, north: Array, origin: tuple[float, float], other: tuple[float, float]
) -> tuple[Array, Array]:
    """east, north (m) of the other origin, of points at east, north (N,) (m) of the origin; both latitude and longitude in deg.

    where: for messages. Raises ValueError where the library is missing.
    """
    latitude, longitude = latitude_longitude(where, east, north, origin)
    x, y, _ = _pymap3d(where).geodetic2enu(latitude, longitude, np.zeros_like(latitude), *other, 0.0)
    return x, y


def east_north(
    where: str, latitude: Array, longitude: Array, altitude: Array
) -> tuple[Array, Array, tuple[float, float]]:
    """east, north (N,) in m, and the origin (latitude, longitude in deg): the first fix.

    where: for messages; latitude, longitude (N,): deg; altitude (N,): m, NaN where not known. Raises ValueError for values that
    are no degrees, and where the library is missing.
    """
    good = np.isfinite(latitude) & np.isfinite(longitude) & ((latitude != 0.0) | (longitude != 0.0))
    if not good.any():
        raise ValueError(f"{where}: expected fixes of latitude and longitude, found none")
    if np.abs(latitude[good]).max() > LARGEST_LATITUDE or np.abs(longitude[good]).max() > LARGEST_LONGITUDE:
        raise ValueError(f"{where}: expected latitude and longitude in degrees, found {np.abs(latitude[good]).max():g}")
    to_enu = _pymap3d(where).geodetic2enu
    first = int(np.argmax(good))
    height = np.where(np.isfinite(altitude), altitude, 0.0)
    origin = float(latitude[first]), float(longitude[first])
    east, north, _ = to_enu(
        np.where(good, latitude, origin[0]), np.where(good, longitude, origin[1]), height, *origin, float(height[first])
    )
    return np.where(good, east, np.nan), np.where(good, north, np.nan), origin
