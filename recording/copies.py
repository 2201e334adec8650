"""Logs that are given twice."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from softsoil.recording.drive import Recording

COMPARED = ("x", "y", "u", "omega_z")
"""Channels by which two drives are one."""


def copied_from(recording: Recording, others: Sequence[Recording]) -> str:
    """Name of the first of the others that has the same rows; "" where none has."""
    for other in others:
        pairs = ((recording.channels.get(name), other.channels.get(name)) for name in COMPARED)
        if all(a is not None and b is not None and np.array_equal(a, b, equal_nan=True) for a, b in pairs):
            return other.name
    return ""


def refuse_copies(recordings: Sequence[Recording]) -> None:
    """Raise ValueError where two drives have the same rows: noise would count as known twice as well, and a log that is fitted
    could judge."""
    for i, recording in enumerate(recordings):
        other = copied_from(recording, recordings[:i])
        if other:
            raise ValueError(f"{recording.name}: expected drives that differ, found the rows of {other} again: a log counts once")
