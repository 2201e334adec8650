"""Whether the positions of a drive say where it was: measured, and without a leap of the receiver's."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from softsoil.recording.clock import on_even_clock
from softsoil.recording.drive import Recording
from softsoil.recording.evidence import filled
from softsoil.recording.states import known_states

Array = NDArray[np.float64]

BESIDE = 0.5
"""s on either side of a row over which positions are compared."""
PARTS = 5
"""Steps in BESIDE at which that is looked at."""
STRIDE = 1.0
"""m between the points of a way, at most."""
DRIFT = 0.1
"""Share of the way in a gap of the position, by which speed and heading may miss where it goes on."""
LEAST = 1.0
"""m: smaller leaps are what the front axle moves sideways in BESIDE of a sharp turn."""


def misplaced(recording: Recording, most: float) -> str:
    """Why a drive cannot be laid on a map, in words; empty where it can.

    recording: with derived channels marked; most: leap of the position that does not matter (m).
    """
    if any(recording.state.get(name, "measured") != "measured" for name in ("x", "y")):
        return "its position is not measured"
    leap, at = largest_leap(recording)
    return f"its position leaps by {leap:.1f} m at {at:.1f} s" if leap > max(most, LEAST) else ""


def largest_leap(recording: Recording) -> tuple[float, float]:
    """Size (m) and time (s) of the largest step of the position that stays and that the vehicle did not drive.

    Positions less the way by speed and heading: their medians over BESIDE before and after a row, or a gap of the position
    through which speed and heading were measured, less DRIFT of the way in it.
    """
    recording = on_even_clock(recording)  # a pause of the logger has rows, too
    states = known_states(recording)
    (x, y), (psi, u, v) = states.T[:2], (filled(states[:, i]) for i in (2, 3, 4))
    step = max(round(BESIDE / recording.dt / PARTS), 1)
    dt, half = recording.dt, PARTS * step
    east, north = u * np.cos(psi) - v * np.sin(psi), u * np.sin(psi) + v * np.cos(psi)
    left = np.column_stack([x, y]) - np.cumsum(np.column_stack([east, north]) * dt, axis=0)
    if len(left) < 4 * half:
        return 0.0, float(recording.t[0])
    windows = np.lib.stride_tricks.sliding_window_view(left, half, axis=0)[::step]
    before, after = _compared(np.isfinite(windows[:, 0]).any(axis=1))
    begin, end = before * step + half, after * step  # of what lies between the two
    unknown = np.concatenate([[0], np.cumsum(~np.isfinite(states[:, [2, 3]]).all(axis=1))])
    followed = unknown[end] == unknown[begin]
    before, after, begin, end = (rows[followed] for rows in (before, after, begin, end))
    if not len(before):
        return 0.0, float(recording.t[0])
    way = np.concatenate([[0.0], np.cumsum(np.abs(u) * dt)])
    leaps = np.hypot(*(np.nanmedian(windows[after], axis=2) - np.nanmedian(windows[before], axis=2)).T)
    leaps -= DRIFT * (way[end] - way[begin])
    worst = int(np.argmax(leaps))
    return max(float(leaps[worst]), 0.0), float(recording.t[end[worst]])


def _compared(known: NDArray[np.bool_]) -> tuple[NDArray[np.int_], NDArray[np.int_]]:
    """Pairs of windows: each known one, and the next known one that begins at its end or later."""
    there = np.flatnonzero(known)
    places = np.searchsorted(there, there + PARTS)
    paired = places < len(there)
    return there[paired], there[places[paired]]


def way_of(recording: Recording, first: int) -> Array:
    """(R, 2) positions (m), at most STRIDE from each other, from the row `first` on; NaN in between where the position is not
    known for longer than that."""
    x, y = (known_states(recording)[first:, i] for i in (0, 1))
    points = np.column_stack([x, y])
    points = points[np.isfinite(points).all(axis=1)]
    if len(points) == 0:
        return np.zeros((0, 2))
    steps = np.hypot(*np.diff(points, axis=0).T)
    along = np.concatenate([[0.0], np.cumsum(steps)])
    kept = points[np.unique((along // STRIDE).astype(int), return_index=True)[1]]
    far = np.flatnonzero(np.hypot(*np.diff(kept, axis=0).T) > 3.0 * STRIDE)
    return np.insert(kept, far + 1, np.nan, axis=0)
