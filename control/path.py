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

    s (M,): length along it (m); psi (M,): course (rad, unwrapped).
    Raises ValueError for another shape or a point that is not finite.
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
        psi = np.unwrap(np.arctan2(np.gradient(self.points[:, 1]), np.gradient(self.points[:, 0])))
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
        comes by again, as a closed one does, is driven from its beginning.
        """
        squares = (self.points[:, 0] - x) ** 2 + (self.points[:, 1] - y) ** 2
        if near is not None:
            squares = np.where(np.abs(self.s - near) <= reach, squares, np.inf)
        i = int(np.argmin(squares))
        if near is None:
            nearer = np.concatenate([[True], squares[1:] < squares[:-1]]) & np.concatenate([squares[:-1] <= squares[1:], [True]])
            i = int(np.flatnonzero(nearer & (np.sqrt(squares) <= math.sqrt(squares[i]) + AGAIN))[0])
        cos, sin = np.cos(self.psi[i]), np.sin(self.psi[i])
        dx, dy = x - self.points[i, 0], y - self.points[i, 1]
        return float(self.s[i] + cos * dx + sin * dy), float(cos * dy - sin * dx)
