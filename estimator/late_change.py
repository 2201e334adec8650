"""A change of soil that only a whole drive shows.

While driving, the newest few windows are tested against all before them. A small change, or one under noisy sensors, passes that
test and leaves an n between both soils. At the end, n of an earlier and of a later part of the drive are compared: where they
differ beyond doubt, the border is where two values fit the windows best, and the last soil is what lies behind it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from softsoil.estimator.summary import Summary

Array = NDArray[np.float64]

SPLITS = (1 / 3, 1 / 2, 2 / 3)
"""Shares of a drive's windows that count as its earlier part, when n of both parts is compared."""
LEAST_PART = 4
"""Windows of a part, at least."""
PARTS, PARTS_SIGMAS = 0.10, 2.5
"""Share of n by which both parts differ, and standard deviations, where they are two soils."""


def parts_of(summary: Summary, since: int, share: float, last: int) -> tuple[Array, float]:
    """(2,) n of the earlier and of the later windows where these differ most, and by how many standard deviations.

    since, last: first and newest window of the present soil that count; share: of a window that its neighbour does not cover.
    """
    count, parts, sigmas = last + 1 - since, np.zeros(2), 0.0
    for split in SPLITS:
        cut = since + round(split * count)
        if min(cut - since, last + 1 - cut) < LEAST_PART:
            continue
        ends, apart = _two(summary, since, cut, last, share)
        axle = int(np.argmax(apart))
        if apart[axle] > sigmas:
            parts, sigmas = ends[:, axle], float(apart[axle])
    return parts, sigmas


def later_soil(
    summary: Summary, since: int, share: float, soil: NDArray[np.bool_], across: int
) -> tuple[int, Array] | None:
    """First window of a later soil and the (A,) minimum of its windows; None where all from `since` on are of one soil.

    share: of a window that its neighbour does not cover; soil (A,): which numbers are n; across: windows that may hold a border.
    """
    last = len(summary.at) - 1
    cuts = range(since + LEAST_PART, last + 2 - LEAST_PART - across)
    parts, sigmas = parts_of(summary, since, share, last)
    if not cuts or not sigmas > PARTS_SIGMAS or not abs(parts[1] - parts[0]) > PARTS * parts[1]:
        return None
    border = min(cuts, key=lambda cut: _left(summary, since, cut, share) + _left(summary, cut, last + 1, share))
    ends, apart = _two(summary, since, border, last, share)
    if not np.any(soil & (apart > PARTS_SIGMAS)):
        return None
    return border + across, ends[1]


def _two(summary: Summary, since: int, cut: int, last: int, share: float) -> tuple[Array, Array]:
    """(2, A) minima of the windows before `cut` and from it on, and (A,) standard deviations by which they differ."""
    weight, rows = np.full(last + 1, share), (slice(since, cut), slice(cut, last + 1))
    ends = np.array([summary.minimum(weight, None, part)[0] for part in rows])
    variances = [summary.variance(end, weight, None, part) for end, part in zip(ends, rows, strict=True)]
    return ends, np.abs(ends[1] - ends[0]) / np.sqrt(variances[0] + variances[1])


def _left(summary: Summary, start: int, stop: int, share: float) -> float:
    """What the quadratics of the windows from `start` to before `stop` leave at their minimum, but for what no number moves."""
    part = slice(start, stop)
    n, _ = summary.minimum(np.full(stop, share), None, part)
    at, hessian, gradient = (np.array(kept[part]) for kept in (summary.at, summary.hessian, summary.gradient))
    away = n - at
    return float(share * (np.einsum("wk,wkl,wl->", away, hessian, away) + 2.0 * np.einsum("wk,wk->", away, gradient)))
