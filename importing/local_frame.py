"""Latitude and longitude to a local frame: metres east and north of the first fix (WGS 84)."""

from __future__ import annotations

import numpy as np

from softsoil.recording.drive import Array

LARGEST_LATITUDE, LARGEST_LONGITUDE = 90.0, 360.0


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
    try:
        from pymap3d import geodetic2enu
    except ImportError:
        raise ValueError(
            f"{where}: expected the library pymap3d for fixes, found none: pip install softsoil[logs]"
        ) from None
    first = int(np.argmax(good))
    height = np.where(np.isfinite(altitude), altitude, 0.0)
    origin = float(latitude[first]), float(longitude[first])
    east, north, _ = geodetic2enu(np.where(good, latitude, origin[0]), np.where(good, longitude, origin[1]), height,
                                  *origin, float(height[first]))  # fmt: skip
    return np.where(good, east, np.nan), np.where(good, north, np.nan), origin
