"""The part of a drive that a vehicle model can use: the longest stretch driven forwards."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from softsoil.recording.drive import Array, Recording

STANDING = 0.2
"""m/s: below this the vehicle stands, crawls or reverses: slip has no meaning there."""
STANDSTILL = 0.2
"""s: a standstill lasts this long at least; a shorter one is noise."""


def forward_part(recording: Recording) -> Recording:
    """The longest stretch of a drive without a standstill or reversing, with a note; the drive itself where there is none.

    Missing speeds are interpolated. A drive that never goes forwards comes back as it is: what reads it says why it cannot.
    """
    u, t = recording["u"], recording.t
    good = np.isfinite(u)
    if not good.any():
        return recording
    stretches = _stretches(np.interp(t, t[good], u[good]) < STANDING, t)
    if len(stretches) == 0 or stretches == [(0, len(t))]:
        return recording
    first, last = max(stretches, key=lambda ends: t[ends[1] - 1] - t[ends[0]])
    until = t[last] if last < len(t) else np.inf
    note = (
        f"u: the vehicle stands or reverses in this log; its longest drive forwards, {t[first]:.4g} to {t[last - 1]:.4g} s, "
        f"is used ({last - first} of {len(t)} rows)"
    )
    part = recording.between(float(t[first]), float(until))
    return replace(part, notes=(*part.notes, note))


def _stretches(slow: NDArray[np.bool_], t: Array) -> list[tuple[int, int]]:
    """(first row, row after the last) of what lies between standstills."""
    edges = np.flatnonzero(np.diff(slow.astype(int), prepend=0, append=0))
    standing = np.zeros(len(t), dtype=int)
    for start, stop in edges.reshape(-1, 2):
        if t[stop - 1] - t[start] >= STANDSTILL:
            standing[start:stop] = 1
    edges = np.flatnonzero(np.diff(1 - standing, prepend=0, append=0))
    return [(int(start), int(stop)) for start, stop in edges.reshape(-1, 2)]
