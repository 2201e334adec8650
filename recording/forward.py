"""The parts of a drive that a vehicle model can use: those driven forwards."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from softsoil.recording.drive import Recording

STANDING = 0.2
"""m/s: below this the vehicle stands, crawls or reverses: slip has no meaning there."""
STANDSTILL = 0.2
"""s: a standstill lasts this long at least; a shorter one is noise."""
REVERSING = -0.2
"""m/s: below this it reverses."""


def driven(recording: Recording, start: float = 0.0) -> NDArray[np.bool_]:
    """(N,) whether each row is driven forwards, and by `start` seconds later than the last standstill or reversing.

    Missing speeds are interpolated. A drive without a speed stands.
    """
    t = recording.t
    if not np.isfinite(recording["u"]).any():
        return np.zeros(len(t), dtype=bool)
    forwards = np.ones(len(t), dtype=bool)
    for first, last in _slower(recording, STANDING):
        forwards[first : max(last, int(np.searchsorted(t, t[last - 1] + start, side="right")))] = False
    return forwards


def _slower(recording: Recording, speed: float) -> list[tuple[int, int]]:
    """(first row, row after the last) of each stretch of a STANDSTILL or longer below a speed (m/s)."""
    u, t = recording["u"], recording.t
    good = np.isfinite(u)
    slow = np.interp(t, t[good], u[good]) < speed if good.any() else np.zeros(len(t), dtype=bool)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], slow, [False]]).astype(int))).reshape(-1, 2)
    return [(int(first), int(last)) for first, last in edges if t[last - 1] - t[first] >= STANDSTILL]


def with_note_of_reversing(recording: Recording) -> Recording:
    """The recording with a note of how long the vehicle reverses in it, where it does for longer than a STANDSTILL."""
    t = recording.t
    times = [(float(t[last - 1] - t[first]), float(t[first])) for first, last in _slower(recording, REVERSING)]
    if not times:
        return recording
    note = (
        f"u: the vehicle reverses for {sum(length for length, _ in times):.3g} s in this log, first at {times[0][1]:.4g} s; the "
        "model does not: n is held there, and no window of a fit or of predictions runs across it"
    )
    return replace(recording, notes=(*recording.notes, note))
