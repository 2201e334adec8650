"""Lines through samples that are not at every place: drawn between them, and not across where nothing is."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
FAR = 1.5
"""Usual steps of time beyond which a line is broken."""


def bridged(values: ArrayLike) -> Array:
    """Each row of values (W, N) with straight lines between its finite ones; NaN before the first and after the last.

    Example: bridged([[1.0, np.nan, 3.0]]).tolist() == [[1.0, 2.0, 3.0]]
    """
    out = np.array(values, dtype=float)
    places = np.arange(out.shape[1])
    for row in out:
        there = np.flatnonzero(np.isfinite(row))
        if len(there):
            inside = (places >= there[0]) & (places <= there[-1])
            row[inside] = np.interp(places[inside], there, row[there])
    return out


def broken(t: ArrayLike, values: ArrayLike) -> tuple[Array, Array]:
    """Times t (N,) and values (N,) with NaN in between where a step of time is far longer than most."""
    t, values = np.asarray(t, dtype=float), np.asarray(values, dtype=float)
    if len(t) < 3:
        return t, values
    steps = np.diff(t)
    far = np.flatnonzero(steps > FAR * np.median(steps)) + 1
    return np.insert(t, far, np.nan), np.insert(values, far, np.nan)


def root_mean_square(values: ArrayLike) -> Array:
    """(N,) over the rows of values (W, N) that are finite there; NaN where none is."""
    values = np.asarray(values, dtype=float)
    seen = np.isfinite(values)
    count = seen.sum(axis=0)
    squares = (np.where(seen, values, 0.0) ** 2).sum(axis=0)
    return np.sqrt(np.divide(squares, count, out=np.full(len(count), np.nan), where=count > 0))
