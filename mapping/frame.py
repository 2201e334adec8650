"""The frame of a soil map, and which drives can be laid in it: asked before any of them is estimated."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from softsoil.importing.local_frame import LARGEST_LATITUDE, LARGEST_LONGITUDE, other_frame
from softsoil.mapping.place import misplaced
from softsoil.recording.copies import copies
from softsoil.recording.drive import Recording

OFF_THE_MAP = 0.25
"""Cells that a position may leap by."""
FIELD = 2e4
"""m from the map's origin within which a drive is on the same piece of ground."""
EARTH = 6.371e6
"""m: mean radius."""
Origin = tuple[float, float] | None


def frame_of(recordings: Sequence[Recording], origin: Origin = None) -> Origin:
    """Latitude and longitude (deg) of the map's x = y = 0: the origin asked for, else that of the recording with most others on
    its piece of ground, the first of several; None where none has one. Raises ValueError for an origin on no globe, and for one
    where no recording has its own."""
    known = [one.origin for one in recordings if one.origin is not None]
    if origin is None:
        return known[int(np.argmax(_neighbours(np.array(known))))] if known else None
    if not (abs(origin[0]) <= LARGEST_LATITUDE and abs(origin[1]) <= LARGEST_LONGITUDE):
        raise ValueError(f"map: expected an origin of latitude and longitude in degrees, found {origin[0]:g}, {origin[1]:g}")
    if not known:
        raise ValueError("map: expected logs that an import made of fixes for a map with an origin, found none")
    return origin


def placed(recordings: Sequence[Recording], frame: Origin, size: float) -> list[str]:
    """Why each of the recordings cannot be laid on a map of cells of `size` (m), in words; empty where it can.

    recordings: `usable`; frame: as of `frame_of`.
    """
    others = (f"it has the rows of {other}" if other else "" for other in copies(recordings))
    return [_elsewhere(one, frame) or copied or misplaced(one, OFF_THE_MAP * size)
            for one, copied in zip(recordings, others, strict=True)]  # fmt: skip


def _elsewhere(recording: Recording, frame: Origin) -> str:
    """Says so where the map's frame is on the globe and the drive is not, or is far from it."""
    if frame is None or recording.origin == frame:
        return ""
    if recording.origin is None:
        return "its place on the globe is not known, as that of other logs is: import it with its fixes"
    away = _away(recording.origin, frame)
    return f"it is on another piece of ground, {away / 1e3:.0f} km from the map's origin" if away > FIELD else ""


def _neighbours(origins: NDArray[np.float64]) -> NDArray[np.int_]:
    """(N,) how many of the origins (N, 2), deg, are on one's piece of ground."""
    latitude, longitude = np.deg2rad(origins).T
    apart = np.angle(np.exp(1j * (longitude[:, None] - longitude))) * np.cos(latitude)
    return (EARTH * np.hypot(latitude[:, None] - latitude, apart) <= FIELD).sum(axis=1)


def _away(there: tuple[float, float], here: tuple[float, float]) -> float:
    """Distance (m) of one origin from another."""
    if there == here:
        return 0.0
    (x,), (y,) = other_frame("map", np.zeros(1), np.zeros(1), there, here)
    return float(np.hypot(x, y))
