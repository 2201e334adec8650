"""Paths to be followed, by their points."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
AGAIN = 1.0
"""m by which a place farther along a path has to be nearer, for a vehicle to begin there."""


@dataclass(frozen=True)
class Path:
    """A path by its points (M, 2) (m), equally spaced closely enough to be taken as a curve.

    s (M,): length along it (m); psi (M,): course (rad, unwrapped), of a point that stands twice that of the way to it, or from it
    at the beginning. Raises ValueError for another shape, a point that is not finite, or points that are all one.
    """

    points: Array

    def __post_init__(self) -> None:
        if self.points.ndim != 2 or self.points.shape[1] != 2 or len(self.points) < 2:
            raise ValueError(f"path: expected points (M, 2), M >= 2, found shape {self.points.shape}")
        wrong = np.flatnonzero(~np.isfinite(self.points).all(axis=1))
        if len(wrong):
            raise ValueError(f"path: expected finite x, y, found {self.points[wrong[0]].tolist()} in point {wrong[0]}")
        moves = np.diff(self.points, axis=0)
        s = np.concatenate([[0.0], np.cumsum(np.hypot(*moves.T))])
        if not s[-1] > 0.0:
            raise ValueError(f"path: expected points of a path, found {len(self.points)} times {self.points[0].tolist()}")
        ahead = np.gradient(self.points, axis=0)
        for k in np.flatnonzero((ahead == 0.0).all(axis=1)):  # points that stand twice, as at a stop of a path that was driven
            before, after = np.flatnonzero(s < s[k]), np.flatnonzero(s > s[k])
            ahead[k] = self.points[k] - self.points[before[-1]] if len(before) else self.points[after[0]] - self.points[k]
        psi = np.unwrap(np.arctan2(ahead[:, 1], ahead[:, 0]))
        object.__setattr__(self, "s", s)
        object.__setattr__(self, "psi", psi)

    s: Array = field(init=False)
    psi: Array = field(init=False)

    def at(self, s: Array) -> Array:
        """(K, 3) x, y, psi at lengths s (K,); straight on beyond the end."""
        beyond = np.maximum(s - self.s[-1], 0.0)
        end = self.psi[-1]
        x = np.interp(s, self.s, self.points[:, 0]) + beyond * np.cos(end)
        y = np.interp(s, self.s, self.points[:, 1]) + beyond * np.sin(end)
        return np.stack([x, y, np.interp(s, self.s, self.psi)], axis=1)

    def project(self, x: float, y: float, near: float | None = None, reach: float = 8.0) -> tuple[float, float]:
        """(length along the path, distance left of it) of the point nearest to x, y (m); near: only within `reach` m of there.

        Without `near`, the first place along the path that is no more than `AGAIN` farther away than the nearest: a path that
        comes by again, as a closed one does, is driven from its beginning, by a vehicle within `reach` before it, too: its length
        is negative then. Where no point is within `reach` of `near`, as far beyond the end, it is the nearest along the path.
        """
        squares = (self.points[:, 0] - x) ** 2 + (self.points[:, 1] - y) ** 2
        if near is None:
            i, before = self._first(squares, reach)
        else:
            away, before = np.abs(self.s - near), 0.0
            i = int(np.argmin(np.where(away <= max(reach, float(away.min())), squares, np.inf)))
        cos, sin = np.cos(self.psi[i]), np.sin(self.psi[i])
        dx, dy = x - self.points[i, 0], y - self.points[i, 1]
        return float(self.s[i] - before + cos * dx + sin * dy), float(cos * dy - sin * dx)

    def _first(self, squares: Array, reach: float) -> tuple[int, float]:
        """The point where a vehicle begins, by squares of its distances from all (M,), and the length that its own is beyond that
        of the vehicle: the whole one for the last stretch of a closed path, which lies before its beginning."""
        order, last = np.arange(len(squares)), float(self.s[-1])
        closed = float(np.hypot(*(self.points[-1] - self.points[0]))) <= AGAIN and last > 2.0 * reach
        order = np.concatenate([order[self.s > last - reach], order]) if closed else order
        along = squares[order]
        nearer = np.concatenate([[True], along[1:] < along[:-1]]) & np.concatenate([along[:-1] <= along[1:], [True]])
        first = int(np.flatnonzero(nearer & (np.sqrt(along) <= math.sqrt(along.min()) + AGAIN))[0])
        return int(order[first]), last if first < len(order) - len(squares) else 0.0
