"""Logs that are given twice."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from softsoil.recording.drive import Recording

COMPARED = ("x", "y", "u", "omega_z")
"""Channels by which two drives are one."""
SHARED = 0.25
"""Share of the rows of the shorter of two drives in the other one, from which they are one drive: a part counts as a copy."""
RUN, PLACED = 8, 10
"""Rows in a row that have to be alike in a log without positions, whose rows may hold but a yaw rate in steps of its sensor; rows
with a position from which on these are compared one by one."""


def copies(recordings: Sequence[Recording]) -> list[str]:
    """For each drive the name of the first before it that it shares rows with, over SHARED of the shorter one's; "" for none.

    Rows that stand still are alike in any two drives: they count once.
    """
    rows = [_rows(recording) for recording in recordings]

    def first(i: int) -> str:
        shared = (k for k in range(i) if len(rows[k] & rows[i]) > SHARED * min(len(rows[k]), len(rows[i])))
        return next((recordings[k].name for k in shared), "")

    return [first(i) for i in range(len(recordings))]


def _rows(recording: Recording) -> set[bytes]:
    """The different rows of a drive with a position, or runs of RUN rows; none where it lacks a channel of COMPARED."""
    columns = [recording.channels.get(name) for name in COMPARED]
    if any(column is None for column in columns):
        return set()
    rows = np.column_stack([np.asarray(column, dtype=float) for column in columns])
    placed = np.isfinite(rows[:, :2]).all(axis=1)
    some = int(placed.sum()) >= PLACED
    rows = rows[placed if some else np.isfinite(rows).any(axis=1)]
    width, data, run = rows.shape[1] * rows.itemsize, rows.tobytes(), 1 if some else min(RUN, len(rows))
    if not len(rows):
        return set()
    return {data[at * width : (at + run) * width] for at in range(len(rows) - run + 1)}


def refuse_copies(recordings: Sequence[Recording]) -> None:
    """Raise ValueError where two drives share their rows: noise would count as known twice as well, and a log that is fitted
    could judge."""
    for recording, other in zip(recordings, copies(recordings), strict=True):
        if other:
            raise ValueError(f"{recording.name}: expected drives that differ, found the rows of {other} again: a log counts once")
