"""What measured wheel speeds say about an axle's differential."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from softsoil.recording.drive import Recording
from softsoil.refinement.rules import RULES
from softsoil.symbolic.vehicle import Vehicle

Array = NDArray[np.float64]
AXLES = {"front": ("omega_fl", "omega_fr"), "rear": ("omega_rl", "omega_rr")}


def differential_shares(recording: Recording, vehicle: Vehicle) -> dict[str, float]:
    """Axle -> speed difference of its wheels in turns over that of freely rolling ones, track omega_z/radius (medians).

    0 for a locked differential; the median, since a lock may slip for a moment. Empty where the drive hardly turns; an
    axle without two measured wheel speeds is left out. vehicle: its tracks and radius.
    """
    omega_z = recording["omega_z"]
    size = max(round(RULES.averaged / recording.dt), 1)
    shares = {}
    for axle, (left, right) in AXLES.items():
        if not recording.measured(left, right):
            continue
        apart = _averaged(recording[right] - recording[left], size)
        rows = (np.abs(omega_z) > RULES.turning) & np.isfinite(apart)
        if rows.sum() >= RULES.fewest_rows:
            track = vehicle.track if axle == "front" else vehicle.rear_track
            radius = vehicle.radius if axle == "front" else vehicle.rear_radius
            free = track / radius * np.abs(omega_z[rows])
            shares[axle] = float(np.median(np.abs(apart[rows])) / np.median(free))
    return shares


def _averaged(values: Array, size: int) -> Array:
    """(N,) mean of the finite ones of `size` values about each, NaN where there is none."""
    known, ones = np.isfinite(values), np.ones(size)
    count = np.convolve(known, ones, mode="same")
    total = np.convolve(np.where(known, values, 0.0), ones, mode="same")
    return np.where(count > 0.5, total / np.maximum(count, 1.0), np.nan)


def locked_axles(recording: Recording, vehicle: Vehicle) -> tuple[str, ...]:
    """Axles whose wheels turn together although the vehicle turns."""
    return tuple(axle for axle, share in differential_shares(recording, vehicle).items() if share < RULES.locked)


def all_open(recording: Recording, vehicle: Vehicle) -> bool:
    """Whether both axles' wheels turn at different speeds as on open differentials: no axle can be locked then."""
    shares = differential_shares(recording, vehicle)
    return len(shares) == len(AXLES) and min(shares.values()) > RULES.open
