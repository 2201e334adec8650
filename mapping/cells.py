"""Cells of a soil map: n of the windows in each, fused over drives and over the ground, and a verdict.

Windows of one drive in one piece of ground are a mean weighted by information. These means are fused with a variance between
them (random effects; DerSimonian and Laird, Controlled Clinical Trials 7, 1986): drives that contradict each other, and ground
that is not the same all over a large cell, make the cell uncertain instead of the surer one winning.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from softsoil.estimator.moving_horizon import HorizonRules
from softsoil.estimator.verdict_rules import VerdictRules
from softsoil.mapping.drive_soil import DriveSoil
from softsoil.symbolic.soil import SOIL_SIGNALS

Array = NDArray[np.float64]

FEWEST = 2
"""Windows that a cell needs, so that their scatter says something."""
LEAST = 1e-6
"""Information (1 over the variance of n) that a window needs: one in which no state was measured has none."""
PIECE = 10.0
"""m: ground is taken to be alike within; larger cells are fused from pieces of this size at most."""
OVERLAP = HorizonRules().length / HorizonRules().stride
"""Windows that each row of a drive is in, since they overlap: so many count as one observation."""
KNOWN = 0.10
"""Largest standard deviation of a cell's n, over n, with which it is identified."""
DIFFERENT, SURE = 0.10, 0.99
"""Standard deviation between drives or pieces of ground, over n, from which they contradict each other, and how surely."""


@dataclass(frozen=True)
class Cell:
    """One cell of the ground.

    column, row: its corner is at x = column size, y = row size; n, std: of a place in it; windows: how many; drives: how many
    logs have windows in it; verdict: "identified", "not_excited" (n is known to worse than KNOWN), "inconsistent" (drives, or
    pieces of ground in it, contradict each other) or "at_bound".
    """

    column: int
    row: int
    n: float
    std: float
    windows: int
    drives: int
    verdict: str


def fuse(drives: Sequence[DriveSoil], size: float) -> tuple[Cell, ...]:
    """Cells of `size` (m) in which the drives have windows, row by row. Raises ValueError for a size that is not positive."""
    if not 0 < size < np.inf:
        raise ValueError(f"cell size: expected a positive number of metres, found {size}")
    parts = ceil(size / PIECE)
    members: dict[tuple[int, int], dict[tuple[int, int, int], list[tuple[float, float]]]] = {}
    for k, drive in enumerate(drives):
        for x, y, n, information in zip(drive.x, drive.y, drive.n, drive.information, strict=True):
            if not information > LEAST:
                continue
            row, column = int(np.floor(y / size)), int(np.floor(x / size))
            piece = (k, int((y / size - row) * parts), int((x / size - column) * parts))
            members.setdefault((row, column), {}).setdefault(piece, []).append((n, information))
    cells = []
    for (row, column), pieces in sorted(members.items()):
        windows = sum(map(len, pieces.values()))
        if windows < FEWEST:
            continue
        crossed = {k for k, _, _ in pieces}
        n, variance, between, surely = _together(np.array([_mean(np.array(found)) for found in pieces.values()]))
        common = max(drives[k].common for k in crossed)
        std = float(np.sqrt(variance + between + (common * n) ** 2))
        word = _word(n, std, surely and np.sqrt(between) > DIFFERENT * n)
        cells.append(Cell(column, row, n, std, windows, len(crossed), word))
    return tuple(cells)


def _mean(found: Array) -> tuple[float, float]:
    """n of one drive in one piece of ground, and its variance by noise and by the scatter of its windows (W, 2)."""
    n, weight = found.T
    mean = float(weight @ n / weight.sum())
    noise = float(1.0 / weight.sum())
    if len(n) < 2:
        return mean, noise
    scatter = OVERLAP * float(weight**2 @ (n - mean) ** 2 / weight.sum() ** 2) * len(n) / (len(n) - 1)
    return mean, max(noise, scatter)


def _together(means: Array) -> tuple[float, float, float, bool]:
    """n of all means (M, 2: value and variance), its variance, the variance between them, and whether they surely differ."""
    value, variance = means.T
    weight = 1.0 / np.maximum(variance, 1e-12)
    n = float(weight @ value / weight.sum())
    if len(value) < 2:
        return n, float(variance[0]), 0.0, False
    apart = float(weight @ (value - n) ** 2)
    between = max(apart - (len(value) - 1), 0.0) / float(weight.sum() - (weight**2).sum() / weight.sum())
    weight = 1.0 / (variance + between)
    return float(weight @ value / weight.sum()), float(1.0 / weight.sum()), between, apart > chi2.ppf(SURE, len(value) - 1)


def _word(n: float, std: float, differ: bool) -> str:
    bounds, near = SOIL_SIGNALS["n"], VerdictRules().bound
    if differ:
        return "inconsistent"
    if n < bounds.lower + near or n > bounds.upper - near:
        return "at_bound"
    return "identified" if std <= KNOWN * n else "not_excited"
