"""What measured wheel speeds say about an axle's differential."""

from __future__ import annotations

import numpy as np

from softsoil.recording.drive import Recording
from softsoil.refinement.rules import RULES
from softsoil.symbolic.vehicle import Vehicle

AXLES = {"front": ("omega_fl", "omega_fr"), "rear": ("omega_rl", "omega_rr")}


def differential_shares(recording: Recording, vehicle: Vehicle) -> dict[str, float]:
    """Axle -> speed difference of its wheels in turns over that of freely rolling ones, track omega_z/radius (medians).

    0 for a locked differential; the median, since a lock may slip for a moment. Empty where the drive hardly turns; an
    axle without two measured wheel speeds is left out. vehicle: its track and radius.
    """
    omega_z = recording["omega_z"]
    size = max(round(RULES.averaged / recording.dt), 1)
    shares = {}
    for axle, (left, right) in AXLES.items():
        if not recording.measured(left, right):
            continue
        apart = np.convolve(recording[right] - recording[left], np.full(size, 1.0 / size), mode="same")
        rows = (np.abs(omega_z) > RULES.turning) & np.isfinite(apart)
        if rows.sum() >= RULES.fewest_rows:
            free = vehicle.track / vehicle.radius * np.abs(omega_z[rows])
            shares[axle] = float(np.median(np.abs(apart[rows])) / np.median(free))
    return shares


def locked_axles(recording: Recording, vehicle: Vehicle) -> tuple[str, ...]:
    """Axles whose wheels turn together although the vehicle turns."""
    return tuple(axle for axle, share in differential_shares(recording, vehicle).items() if share < RULES.locked)


def all_open(recording: Recording, vehicle: Vehicle) -> bool:
    """Whether both axles' wheels turn at different speeds as on open differentials: no axle can be locked then."""
    shares = differential_shares(recording, vehicle)
    return len(shares) == len(AXLES) and min(shares.values()) > RULES.open
