"""Counts of encoders that wrap around at 16 or 32 bits, unwrapped."""

from __future__ import annotations

import numpy as np

from softsoil.recording.drive import Array

BITS = (16, 32)
NEARLY = 0.9
"""A jump of more than this share of a counter's range is a wrap: no wheel turns so far between two samples."""


def unwrapped(counts: Array) -> tuple[Array, int]:
    """(N,) counts that go on where a counter of 16 or 32 bits, signed or not, started anew, and how often that was.

    counts (N,): NaN where missing; what is not whole numbers within one range of a counter stays as it is.
    """
    good = np.flatnonzero(np.isfinite(counts))
    whole = counts[good]
    if len(whole) < 2 or np.any(whole != np.round(whole)):
        return counts, 0
    jumps = np.diff(whole)
    for bits in BITS:
        period = 2.0**bits
        wraps = np.where(np.abs(jumps) > NEARLY * period, -np.sign(jumps), 0.0)
        if np.ptp(whole) < period and wraps.any():
            out = counts.copy()
            out[good[1:]] += period * np.cumsum(wraps)
            return out, int(np.abs(wraps).sum())
    return counts, 0
